// How a lock's holder reaches a pixel's records in a form where all words are atomic: relaxed loads and stores, which
// nothing orders.

// A word that the lock alone guards.
alias Word = atomic<u32>;

fn entry(pixel: u32, i: u32) -> Key {
    return Key(atomicLoad(&pixels[pixel].data[i]), atomicLoad(&pixels[pixel].depth[i]));
}

// The same after a barrier.
fn settled(pixel: u32, i: u32) -> Key {
    return Key(atomicLoad(&pixels[pixel].data[i]), atomicLoad(&pixels[pixel].depth[i]));
}

fn put(pixel: u32, i: u32, key: Key) {
    atomicStore(&pixels[pixel].data[i], key.x);
    atomicStore(&pixels[pixel].depth[i], key.y);
}

// The depth of entry 0, without the lock.
fn farthest_of(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].depth[0]);
}

// Under the lock.
fn count_of(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].counter);
}

// Written after the record that it counts.
fn release_count(pixel: u32, count: u32) {
    atomicStore(&pixels[pixel].counter, count);
}
