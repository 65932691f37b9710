// Z-buffer (Catmull 1974): the nearest fragment only.
//
// One 64-bit atomic minimum on (depth, data), which also settles ties in canonical order. Hardware does the same with
// its depth test. WGSL has no 64-bit atomics: they are an extension of naga's.

//# include shared/fragment
//# include shared/word64
//# include shared/emit

struct Pixel {
    nearest: atomic<u64>,
}

@group(0) @binding(1) var<storage, read_write> pixels: array<Pixel>;

// Every fragment is nearer.
const CLEARED: u64 = 0xFFFFFFFFFFFFFFFFlu;

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].nearest, CLEARED);
}

fn store(fragment: Fragment) -> u32 {
    let own = word_of(key_of(fragment));
    let old = atomicMin(&pixels[fragment.pixel].nearest, own);
    if own >= old {
        return CULLED;
    }
    if old == CLEARED {
        return KEPT;
    }
    return EVICTED;
}

fn resolve(pixel: u32) {
    let nearest = atomicLoad(&pixels[pixel].nearest);
    if nearest < CLEARED {
        emit(key_in(nearest));
    }
}
