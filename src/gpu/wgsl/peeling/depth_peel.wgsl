// Depth peeling (Everitt 2001): front to back, one layer a round. A round finds the nearest fragment behind the layer
// peeled last.
//
// Layers are keys of depth and data. The round after the one that found a layer counts its fragments, and resolve emits
// as many. WGSL has no 64-bit atomics: they are an extension of naga's.

//# include shared/fragment
//# include shared/word64
//# include shared/emit

// No layer; where peeling goes on from here, it has ended.
const NONE: u64 = 0xFFFFFFFFFFFFFFFFlu;

struct Pixel {
    // Fragments still to be emitted, and those of the last layer.
    left: u32,
    count: atomic<u32>,
}

struct Layers {
    // The smallest key that is not peeled yet; behind the first round, the last layer's plus 1.
    begin: u64,
    // The layer that this round finds.
    nearest: atomic<u64>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(1) var<storage, read_write> layers: array<Layers>;

fn begin_round(pixel: u32, begin: u64, left: u32) {
    layers[pixel].begin = begin;
    pixels[pixel].left = left;
    atomicStore(&layers[pixel].nearest, NONE);
    atomicStore(&pixels[pixel].count, 0u);
}

fn clear(pixel: u32) {
    begin_round(pixel, 0lu, K);
}

fn store(fragment: Fragment) -> u32 {
    let key = word_of(key_of(fragment));
    let begin = layers[fragment.pixel].begin;
    if key + 1lu == begin {
        atomicAdd(&pixels[fragment.pixel].count, 1u);
    }
    if key >= begin {
        atomicMin(&layers[fragment.pixel].nearest, key);
    }
    return KEPT;
}

fn resolve(pixel: u32) {
    let left = pixels[pixel].left;
    let times = min(atomicLoad(&pixels[pixel].count), left);
    let layer = key_in(layers[pixel].begin - 1lu);
    for (var i = 0u; i < times; i++) {
        emit(layer);
    }
    let nearest = atomicLoad(&layers[pixel].nearest);
    if times == left || nearest == NONE {
        begin_round(pixel, NONE, left - times);
    } else {
        begin_round(pixel, nearest + 1lu, left - times);
    }
}

fn again(pixel: u32) -> bool {
    return layers[pixel].begin != NONE;
}
