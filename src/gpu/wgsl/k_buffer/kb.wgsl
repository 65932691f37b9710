// k-buffer as published (Bavoil, Callahan, Lefohn, Comba, Silva 2007; KB): a data race.
//
// Read the k entries, insert in registers, write all back. There is no synchronisation: invocations of a pixel that
// overlap lose, double or tear fragments, and WGSL does not define what they then read. Run one after another, they
// keep the k nearest. Entries are sorted front to back; empty ones stay last.

//# include shared/fragment
//# include shared/emit

struct Pixel {
    depth: array<u32, K>,
    data: array<u32, K>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;

fn clear(pixel: u32) {
    for (var i = 0u; i < K; i++) {
        pixels[pixel].depth[i] = EMPTY;
    }
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    var entries: array<Key, K>;
    for (var i = 0u; i < K; i++) {
        entries[i] = Key(pixels[pixel].data[i], pixels[pixel].depth[i]);
    }
    // Insert: the key carried at the end is the one that no longer fits.
    var carried = key_of(fragment);
    for (var i = 0u; i < K; i++) {
        let other = entries[i];
        if is_less(carried, other) {
            entries[i] = carried;
            carried = other;
        }
    }
    for (var i = 0u; i < K; i++) {
        pixels[pixel].depth[i] = entries[i].y;
        pixels[pixel].data[i] = entries[i].x;
    }
    if all(carried == key_of(fragment)) {
        return CULLED;
    }
    if carried.y == EMPTY {
        return KEPT;
    }
    return EVICTED;
}

fn resolve(pixel: u32) {
    for (var i = 0u; i < K; i++) {
        let depth = pixels[pixel].depth[i];
        if depth != EMPTY {
            emit(Key(pixels[pixel].data[i], depth));
        }
    }
}
