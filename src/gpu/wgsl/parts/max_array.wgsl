// The max-array of the k+-buffer: the farthest record of a row is at entry 0, the others anywhere. An invocation that
// reads entry 0 without the lock never sees too near a depth: see `kplus_array`.
//
// The method says where a row's records are: `entry(row, i)` reads one, `put(row, i, key)` writes one, its depth last.

// Add a record to an array of `count`.
fn array_append(row: u32, count: u32, key: Key) {
    var last = key;
    if count > 0u {
        let farthest = entry(row, 0u);
        if is_less(farthest, last) {
            put(row, 0u, last);
            last = farthest;
        }
    }
    put(row, count, last);
}

// Put a record in the place of the farthest of `count`: the new farthest is found before anything is written.
fn array_replace(row: u32, count: u32, key: Key) {
    var place = 0u;
    var farthest = key;
    for (var i = 1u; i < count; i++) {
        let other = entry(row, i);
        if is_less(farthest, other) {
            place = i;
            farthest = other;
        }
    }
    if place != 0u {
        put(row, place, key);
    }
    put(row, 0u, farthest);
}
