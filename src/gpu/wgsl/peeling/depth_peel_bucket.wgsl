// Depth peeling by bucket sort (Liu, Huang, Liu, Wu 2009): uniform buckets over a pixel's depth range, each peeled from
// both ends until it is empty.

//# include shared/fragment
//# include parts/buckets
//# include parts/ends
//# include shared/emit

const RUNS: u32 = BUCKETS;

struct Pixel {
    near_count: array<atomic<u32>, RUNS>,
    far_count: array<atomic<u32>, RUNS>,
    near: atomic<u32>,
    far: atomic<u32>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].near, EMPTY);
    atomicStore(&pixels[pixel].far, 0u);
    for (var run = 0u; run < RUNS; run++) {
        begin_round(pixel, run, 0lu, NONE);
    }
}

// The depth range; later rounds find the same.
fn prepare(fragment: Fragment) {
    atomicMin(&pixels[fragment.pixel].near, fragment.depth);
    atomicMax(&pixels[fragment.pixel].far, fragment.depth);
}

fn store(fragment: Fragment) -> u32 {
    let near = atomicLoad(&pixels[fragment.pixel].near);
    let far = atomicLoad(&pixels[fragment.pixel].far);
    peel(bucket_of(fragment.depth, near, far), fragment);
    return KEPT;
}

fn resolve(pixel: u32) {
    for (var run = 0u; run < RUNS; run++) {
        emit_ends(pixel, run);
    }
}

fn again(pixel: u32) -> bool {
    var any = false;
    for (var run = 0u; run < RUNS; run++) {
        any |= !has_ended(pixel, run);
    }
    return any;
}
