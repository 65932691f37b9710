// k+-buffer with a max-heap (Vasilakis, Fudos 2014; K+B-Heap), in its correct form.
//
// As the max-array (`kplus_array`), with a structure that finds the new farthest in O(log k) instead of O(k). The
// counter is raised after the record is in place, and the root goes from the old farthest record to the new one in one
// write: so an invocation that reads counter and root without the lock never sees too near a depth. (As far as WGSL
// goes: its atomics are relaxed.)

//# include shared/fragment
//# include parts/lock
//# include parts/max_heap
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
        heap_append(pixel, count, key);
        release_count(pixel, count + 1u);
        return KEPT;
    }
    if !is_less(key, entry(pixel, 0u)) {
        return CULLED;
    }
    heap_replace(pixel, K, key);
    return EVICTED;
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    // Of equal depths, the data word decides, which only the lock's holder may read.
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
    for (var i = 0u; i < min(count, K); i++) {
        emit(settled(pixel, i));
    }
}
