// How a lock's holder reaches a pixel's records in a form where every access is an update: see reach/updates.
//
// Without the lock, the counter is read by a load, and entry 0 of a full row by an update: a stale counter is only lower.

//# include reach/updates

// A word that the lock alone guards.
alias Word = atomic<u32>;

fn entry(pixel: u32, i: u32) -> Key {
    return Key(got(atomicOr(&pixels[pixel].data[i], 0u)), got(atomicOr(&pixels[pixel].depth[i], 0u)));
}

// The same after a barrier.
fn settled(pixel: u32, i: u32) -> Key {
    return Key(atomicLoad(&pixels[pixel].data[i]), atomicLoad(&pixels[pixel].depth[i]));
}

fn put(pixel: u32, i: u32, key: Key) {
    got(atomicExchange(&pixels[pixel].data[i], key.x));
    got(atomicExchange(&pixels[pixel].depth[i], key.y));
}

// The depth of entry 0, without the lock.
fn farthest_of(pixel: u32) -> u32 {
    return atomicOr(&pixels[pixel].depth[0], 0u);
}

// Under the lock.
fn count_of(pixel: u32) -> u32 {
    return got(atomicOr(&pixels[pixel].counter, 0u));
}

// Written after the record that it counts.
fn release_count(pixel: u32, count: u32) {
    got(atomicExchange(&pixels[pixel].counter, count));
}
