// The multi-pass k-buffer (Liu, Wei, Xu, Wu 2009, reconstructed; KB-Multi): rounds of a k-buffer without
// synchronisation, made robust by looking afterwards at what became of it.
//
// The first geometry pass of a round inserts as `kb` does, and an overlapping invocation may undo it. The second one
// verifies: a fragment that finds its key counts there; one that does not, though fewer than k nearer keys are there, is
// missing, and the nearest of those is remembered. Everything nearer than that is right, and is emitted; the next round
// begins behind it. WGSL has no 64-bit atomics: they are an extension of naga's.

//# include shared/fragment
//# include shared/word64
//# include shared/emit

// No entry; a pixel that goes on from here has all its fragments.
const NONE: u64 = 0xFFFFFFFFFFFFFFFFlu;

struct Pixel {
    // Fragments of the key that was missing.
    equal: atomic<u32>,
    // Fragments still to be emitted.
    left: u32,
    // Fragments of each entry's key, at the first entry that has it.
    counts: array<atomic<u32>, K>,
}

struct Entries {
    // The smallest key of this round; behind the first round, the missing one's plus 1.
    begin: u64,
    // The nearest key that is missing.
    missing: atomic<u64>,
    entries: array<atomic<u64>, K>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(1) var<storage, read_write> records: array<Entries>;

fn begin_round(pixel: u32, begin: u64, left: u32) {
    records[pixel].begin = begin;
    pixels[pixel].left = left;
    atomicStore(&pixels[pixel].equal, 0u);
    atomicStore(&records[pixel].missing, NONE);
    for (var i = 0u; i < K; i++) {
        atomicStore(&records[pixel].entries[i], NONE);
        atomicStore(&pixels[pixel].counts[i], 0u);
    }
}

fn clear(pixel: u32) {
    begin_round(pixel, 0lu, K);
}

fn entries_of(pixel: u32) -> array<u64, K> {
    var entries: array<u64, K>;
    for (var i = 0u; i < K; i++) {
        entries[i] = atomicLoad(&records[pixel].entries[i]);
    }
    return entries;
}

// Insert.
fn prepare(fragment: Fragment) {
    let pixel = fragment.pixel;
    var carried = word_of(key_of(fragment));
    if carried < records[pixel].begin {
        return;
    }
    var entries = entries_of(pixel);
    for (var i = 0u; i < K; i++) {
        let other = entries[i];
        entries[i] = min(carried, other);
        carried = max(carried, other);
    }
    for (var i = 0u; i < K; i++) {
        atomicStore(&records[pixel].entries[i], entries[i]);
    }
}

// Verify.
fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    let key = word_of(key_of(fragment));
    let begin = records[pixel].begin;
    if key + 1lu == begin {
        atomicAdd(&pixels[pixel].equal, 1u);
    }
    if key < begin {
        return KEPT;
    }
    var entries = entries_of(pixel);
    // Different keys among the entries that are nearer.
    var nearer = 0u;
    for (var i = 0u; i < K; i++) {
        let entry = entries[i];
        if entry == key {
            atomicAdd(&pixels[pixel].counts[i], 1u);
            return KEPT;
        }
        var is_first = true;
        for (var j = 0u; j < i; j++) {
            is_first = is_first && entries[j] != entry;
        }
        nearer += u32(entry < key && is_first);
    }
    if nearer < K {
        atomicMin(&records[pixel].missing, key);
    }
    return KEPT;
}

// Emit so many fragments of a layer, if it is right, and as long as there are any left; how many are.
fn emit_layer(layer: u64, count: u32, missing: u64, left: u32) -> u32 {
    if layer >= missing {
        return left;
    }
    let times = min(count, left);
    for (var i = 0u; i < times; i++) {
        emit(key_in(layer));
    }
    return left - times;
}

fn resolve(pixel: u32) {
    let missing = atomicLoad(&records[pixel].missing);
    // Layers in order: an overlapping invocation may have left them in any.
    var layers = entries_of(pixel);
    var counts: array<u32, K>;
    for (var i = 0u; i < K; i++) {
        counts[i] = atomicLoad(&pixels[pixel].counts[i]);
    }
    for (var i = 1u; i < K; i++) {
        let layer = layers[i];
        let count = counts[i];
        var place = i;
        while place > 0u && layer < layers[place - 1u] {
            layers[place] = layers[place - 1u];
            counts[place] = counts[place - 1u];
            place -= 1u;
        }
        layers[place] = layer;
        counts[place] = count;
    }
    let last = records[pixel].begin - 1lu;
    var left = emit_layer(last, atomicLoad(&pixels[pixel].equal), missing, pixels[pixel].left);
    for (var i = 0u; i < K; i++) {
        left = emit_layer(layers[i], counts[i], missing, left);
    }
    if left == 0u || missing == NONE {
        begin_round(pixel, NONE, left);
    } else {
        begin_round(pixel, missing + 1lu, left);
    }
}

fn again(pixel: u32) -> bool {
    return records[pixel].begin != NONE;
}
