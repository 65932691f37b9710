// Runs of keys that are peeled from both ends, RUNS for every pixel. A layer is a key; its fragments are counted in the
// round after the one that found it. Where both ends meet, the layer in the middle counts as near.
//
// The method declares the words: in each of `pixels`, atomic `near_count` and `far_count`, an array of each. 64-bit
// atomics are an extension of naga's.

//# include shared/fragment
//# include shared/word64

// No layer; where peeling goes on from here, it has ended.
const NONE: u64 = 0xFFFFFFFFFFFFFFFFlu;

struct Ends {
    // The smallest key that is not peeled yet; behind the first round, the last near layer's plus 1.
    begin: array<u64, RUNS>,
    // The last far layer: what is nearer is not peeled yet.
    end: array<u64, RUNS>,
    // The layers that this round finds.
    nearest: array<atomic<u64>, RUNS>,
    farthest: array<atomic<u64>, RUNS>,
}

@group(0) @binding(1) var<storage, read_write> ends: array<Ends>;

fn begin_round(pixel: u32, run: u32, begin: u64, end: u64) {
    ends[pixel].begin[run] = begin;
    ends[pixel].end[run] = end;
    atomicStore(&ends[pixel].nearest[run], NONE);
    atomicStore(&ends[pixel].farthest[run], 0lu);
    atomicStore(&pixels[pixel].near_count[run], 0u);
    atomicStore(&pixels[pixel].far_count[run], 0u);
}

fn peel(run: u32, fragment: Fragment) {
    let pixel = fragment.pixel;
    let key = word_of(key_of(fragment));
    let begin = ends[pixel].begin[run];
    let end = ends[pixel].end[run];
    if begin <= key && key < end {
        atomicMin(&ends[pixel].nearest[run], key);
        atomicMax(&ends[pixel].farthest[run], key);
    }
    if key + 1lu == begin {
        atomicAdd(&pixels[pixel].near_count[run], 1u);
    } else if key == end {
        atomicAdd(&pixels[pixel].far_count[run], 1u);
    }
}

fn emit_ends(pixel: u32, run: u32) {
    let begin = ends[pixel].begin[run];
    let end = ends[pixel].end[run];
    let near = min(atomicLoad(&pixels[pixel].near_count[run]), GENERATED);
    let far = min(atomicLoad(&pixels[pixel].far_count[run]), GENERATED);
    for (var i = 0u; i < near; i++) {
        emit(key_in(begin - 1lu));
    }
    for (var i = 0u; i < far; i++) {
        emit(key_in(end));
    }
    let nearest = atomicLoad(&ends[pixel].nearest[run]);
    if nearest == NONE {
        begin_round(pixel, run, NONE, NONE);
    } else {
        begin_round(pixel, run, nearest + 1lu, atomicLoad(&ends[pixel].farthest[run]));
    }
}

fn has_ended(pixel: u32, run: u32) -> bool {
    return ends[pixel].begin[run] == NONE;
}
