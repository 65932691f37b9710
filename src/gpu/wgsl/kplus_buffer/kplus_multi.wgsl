// The memory-bounded A-buffer (Vasilakis, Fudos 2014, section 3.4): rounds of a k+-buffer over what lies behind the
// farthest fragment of the round before, in a max-array as in `kplus_array`.
//
// Fragments identical to the farthest, of which a round may have room for only some, are counted in the next one, which
// emits the rest. What the lock needs is outside WGSL's guarantees: see parts/lock.

//# include shared/fragment
//# include parts/lock
//# include parts/max_array
//# include shared/emit

// Where a pixel that has all its fragments goes on: behind every key.
const DONE: Key = Key(0xFFFFFFFFu, 0xFFFFFFFFu);

struct Pixel {
    // How many fragments of the last farthest key are emitted, and how many there are.
    emitted: u32,
    equal: atomic<u32>,
    lock: atomic<u32>,
    counter: atomic<u32>,
    depth: array<atomic<u32>, K>,
    data: array<u32, K>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
// The smallest key of this round; behind the first round, the last farthest key plus 1.
@group(0) @binding(1) var<storage, read_write> begins: array<Key>;

fn entry(pixel: u32, i: u32) -> Key {
    return Key(pixels[pixel].data[i], atomicLoad(&pixels[pixel].depth[i]));
}

fn put(pixel: u32, i: u32, key: Key) {
    pixels[pixel].data[i] = key.x;
    atomicStore(&pixels[pixel].depth[i], key.y);
}

fn one_more(key: Key) -> Key {
    let low = key.x + 1u;
    return Key(low, key.y + u32(low == 0u));
}

fn one_less(key: Key) -> Key {
    return Key(key.x - 1u, key.y - u32(key.x == 0u));
}

fn begin_round(pixel: u32, begin: Key, emitted: u32) {
    begins[pixel] = begin;
    pixels[pixel].emitted = emitted;
    atomicStore(&pixels[pixel].equal, 0u);
    atomicStore(&pixels[pixel].counter, 0u);
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
    begin_round(pixel, Key(0u, 0u), 0u);
}

// Read without the lock, before the farthest depth.
fn acquire_count(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].counter);
}

// Written after the record that it counts.
fn release_count(pixel: u32, count: u32) {
    atomicStore(&pixels[pixel].counter, count);
}

// Under the lock.
fn insert(pixel: u32, key: Key) {
    let count = atomicLoad(&pixels[pixel].counter);
    if count < K {
        array_append(pixel, count, key);
        release_count(pixel, count + 1u);
    } else if is_less(key, entry(pixel, 0u)) {
        array_replace(pixel, K, key);
    }
}

// One that counts has nothing to wait for, so one that gives up waiting has done nothing.
fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    let key = key_of(fragment);
    let begin = begins[pixel];
    if all(one_more(key) == begin) {
        atomicAdd(&pixels[pixel].equal, 1u);
    }
    if is_less(key, begin) {
        return KEPT;
    }
    if acquire_count(pixel) == K && fragment.depth > atomicLoad(&pixels[pixel].depth[0]) {
        return KEPT;
    }
    var outcome = STUCK;
    for (var attempt = 0u; outcome == STUCK && attempt < PATIENCE; attempt++) {
        if acquire_lock(pixel) {
            insert(pixel, key);
            outcome = KEPT;
            release_lock(pixel);
        }
    }
    return outcome;
}

fn resolve(pixel: u32) {
    let begin = begins[pixel];
    let equal = min(atomicLoad(&pixels[pixel].equal), GENERATED);
    for (var i = pixels[pixel].emitted; i < equal; i++) {
        emit(one_less(begin));
    }
    let count = min(atomicLoad(&pixels[pixel].counter), K);
    let farthest = entry(pixel, 0u);
    var emitted = 0u;
    for (var i = 0u; i < count; i++) {
        let key = entry(pixel, i);
        emit(key);
        emitted += u32(all(key == farthest));
    }
    // Only a full array has left anything out.
    if count == K {
        begin_round(pixel, one_more(farthest), emitted);
    } else {
        begin_round(pixel, DONE, 0u);
    }
}

fn again(pixel: u32) -> bool {
    return any(begins[pixel] != DONE);
}
