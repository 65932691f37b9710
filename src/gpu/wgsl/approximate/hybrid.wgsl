// Hybrid transparency (Maule, Comba, Torchelsen, Bastos 2013): the k nearest exactly, in a max-array as in
// `kplus_array`; of the others, the sums of their premultiplied colours and opacities, and their number.
//
// All of it is integers. What the lock needs is outside WGSL's guarantees: see parts/lock. Resolve emits the pixel's
// words, and the host takes the colour from them.

//# include shared/fragment
//# include parts/lock
//# include parts/max_array
//# include approximate/sums

struct Pixel {
    lock: atomic<u32>,
    counter: atomic<u32>,
    depth: array<atomic<u32>, K>,
    data: array<u32, K>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;

fn entry(pixel: u32, i: u32) -> Key {
    return Key(pixels[pixel].data[i], atomicLoad(&pixels[pixel].depth[i]));
}

fn put(pixel: u32, i: u32, key: Key) {
    pixels[pixel].data[i] = key.x;
    atomicStore(&pixels[pixel].depth[i], key.y);
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
    atomicStore(&pixels[pixel].counter, 0u);
    for (var i = 0u; i < WORDS64; i++) {
        clear_sum(pixel, i);
    }
}

struct Inserted {
    outcome: u32,
    // What has no room among the nearest, if the outcome is MERGED.
    gone: Key,
}

// Under the lock.
fn insert(pixel: u32, key: Key) -> Inserted {
    let count = atomicLoad(&pixels[pixel].counter);
    if count < K {
        array_append(pixel, count, key);
        atomicStore(&pixels[pixel].counter, count + 1u);
        return Inserted(KEPT, key);
    }
    let farthest = entry(pixel, 0u);
    if !is_less(key, farthest) {
        return Inserted(MERGED, key);
    }
    array_replace(pixel, K, key);
    return Inserted(MERGED, farthest);
}

// The fourth sum is that of opacities, and from bit 40 on the number of fragments.
fn add_to_tail(pixel: u32, word: u32) {
    let alpha = word >> 24u;
    for (var i = 0u; i < 3u; i++) {
        add_to(pixel, i, Wide(((word >> (8u * i)) & 0xFFu) * alpha, 0u));
    }
    add_to(pixel, 3u, Wide(alpha, 1u << 8u));
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    var inserted = Inserted(STUCK, key_of(fragment));
    if atomicLoad(&pixels[pixel].counter) == K && fragment.depth > atomicLoad(&pixels[pixel].depth[0]) {
        inserted.outcome = MERGED;
    }
    for (var attempt = 0u; inserted.outcome == STUCK && attempt < PATIENCE; attempt++) {
        if acquire_lock(pixel) {
            inserted = insert(pixel, key_of(fragment));
            release_lock(pixel);
        }
    }
    if inserted.outcome == MERGED {
        add_to_tail(pixel, inserted.gone.x);
    }
    return inserted.outcome;
}

// A depth, or behind them a data word; 0 of a record that there is not.
fn word_at(pixel: u32, i: u32) -> u32 {
    if i % K >= atomicLoad(&pixels[pixel].counter) {
        return 0u;
    }
    let key = entry(pixel, i % K);
    return select(key.x, key.y, i < K);
}

fn resolve(pixel: u32) {
    for (var i = 0u; i < WORDS64; i++) {
        emit_sum(pixel, i);
    }
    emit(Key(atomicLoad(&pixels[pixel].lock), atomicLoad(&pixels[pixel].counter)));
    for (var i = 0u; i < 2u * K; i += 2u) {
        emit(Key(word_at(pixel, i), word_at(pixel, i + 1u)));
    }
}
