// The max-heap of the k+-buffer: children of i are 2i + 1 and 2i + 2, the farthest record is at the root.
//
// A hole moves, not the new record: others make room for it, and it is written once, where it belongs. So the root goes
// from the old farthest to the new one in one write, and an invocation that reads it without the lock never sees too
// near a depth.
//
// The method says where a row's records are: `entry(row, i)` reads one, `put(row, i, key)` writes one, its depth last.

// Add a record to a heap of `count` (up-heap).
fn heap_append(row: u32, count: u32, key: Key) {
    var hole = count;
    while hole > 0u {
        let parent = (hole - 1u) / 2u;
        let above = entry(row, parent);
        if !is_less(above, key) {
            break;
        }
        put(row, hole, above);
        hole = parent;
    }
    put(row, hole, key);
}

// Put a record in the place of the farthest of `count` (down-heap).
fn heap_replace(row: u32, count: u32, key: Key) {
    var hole = 0u;
    while 2u * hole + 1u < count {
        var child = 2u * hole + 1u;
        var largest = entry(row, child);
        if child + 1u < count {
            let right = entry(row, child + 1u);
            if is_less(largest, right) {
                child += 1u;
                largest = right;
            }
        }
        if !is_less(key, largest) {
            break;
        }
        put(row, hole, largest);
        hole = child;
    }
    put(row, hole, key);
}
