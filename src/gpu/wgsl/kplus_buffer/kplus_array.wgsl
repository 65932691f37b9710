// k+-buffer with a max-array (Vasilakis, Fudos 2014; K+B-Array), in its correct form.
//
// A spin lock per pixel guards an array whose entry 0 is always its farthest. The new farthest is found before anything
// is written, the freed entry is written before entry 0, and the counter is raised last: so an invocation that reads
// counter and entry 0 without the lock never sees too near a depth. (As far as WGSL goes: its atomics are relaxed.)

//# include shared/fragment
//# include parts/lock
//# include parts/max_array
//# include reach/pixel_rows
//# include shared/emit

struct Pixel {
    lock: atomic<u32>,
    counter: atomic<u32>,
    depth: array<atomic<u32>, K>,
    data: array<Word, K>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
    atomicStore(&pixels[pixel].counter, 0u);
}

// Read without the lock, before the farthest depth.
fn acquire_count(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].counter);
}

// Under the lock.
fn insert(pixel: u32, key: Key) -> u32 {
    let count = count_of(pixel);
    if count < K {
        array_append(pixel, count, key);
        release_count(pixel, count + 1u);
        return KEPT;
    }
    if !is_less(key, entry(pixel, 0u)) {
        return CULLED;
    }
    array_replace(pixel, K, key);
    return EVICTED;
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    if acquire_count(pixel) == K && fragment.depth > farthest_of(pixel) {
        return CULLED;
    }
    var outcome = STUCK;
    for (var attempt = 0u; outcome == STUCK && attempt < PATIENCE; attempt++) {
        if acquire_lock(pixel) {
            outcome = insert(pixel, key_of(fragment));
            release_lock(pixel);
        }
    }
    return outcome;
}

fn resolve(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    for (var i = 0u; i < count; i++) {
        emit(settled(pixel, i));
    }
}
