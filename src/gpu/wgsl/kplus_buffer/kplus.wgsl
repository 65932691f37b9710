// k+-buffer with the published choice of structure (Vasilakis, Fudos 2014, section 3.2; K+B): a max-array for k <= 16
// (as `kplus_array`), a max-heap above (as `kplus_heap`). What the lock needs is outside WGSL's guarantees: see
// parts/lock.

//# include shared/fragment
//# include parts/lock
//# include parts/max_array
//# include parts/max_heap
//# include parts/array_up_to
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

fn append(pixel: u32, count: u32, key: Key) {
    if K <= ARRAY_UP_TO {
        array_append(pixel, count, key);
    } else {
        heap_append(pixel, count, key);
    }
}

fn replace(pixel: u32, key: Key) {
    if K <= ARRAY_UP_TO {
        array_replace(pixel, K, key);
    } else {
        heap_replace(pixel, K, key);
    }
}

// Read without the lock, before the farthest depth.
fn acquire_count(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].counter);
}

// Under the lock.
fn insert(pixel: u32, key: Key) -> u32 {
    let count = count_of(pixel);
    if count < K {
        append(pixel, count, key);
        release_count(pixel, count + 1u);
        return KEPT;
    }
    if !is_less(key, entry(pixel, 0u)) {
        return CULLED;
    }
    replace(pixel, key);
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
    for (var i = 0u; i < min(count, K); i++) {
        emit(settled(pixel, i));
    }
}
