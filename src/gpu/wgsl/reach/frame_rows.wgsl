// How a lock's holder reaches a range of the frame's records: data words are plain; depths are atomic, since entry 0 is
// read without the lock.

// A word that the lock alone guards.
alias Word = u32;

fn entry(first: u32, i: u32) -> Key {
    return Key(memory.data[first + i], atomicLoad(&memory.depth[first + i]));
}

// The same after a barrier.
fn settled(first: u32, i: u32) -> Key {
    return Key(memory.data[first + i], atomicLoad(&memory.depth[first + i]));
}

fn put(first: u32, i: u32, key: Key) {
    memory.data[first + i] = key.x;
    atomicStore(&memory.depth[first + i], key.y);
}

// The depth of entry 0, without the lock.
fn farthest_of(first: u32) -> u32 {
    return atomicLoad(&memory.depth[first]);
}

// Under the lock.
fn count_of(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].counter);
}

// Written after the record that it counts.
fn release_count(pixel: u32, count: u32) {
    atomicStore(&pixels[pixel].counter, count);
}
