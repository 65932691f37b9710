// Dual depth peeling (Bavoil, Myers 2008): a round finds the nearest and the farthest fragment of those not peeled yet.

//# include shared/fragment
//# include parts/ends
//# include shared/emit

const RUNS: u32 = 1u;

struct Pixel {
    near_count: array<atomic<u32>, RUNS>,
    far_count: array<atomic<u32>, RUNS>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;

fn clear(pixel: u32) {
    begin_round(pixel, 0u, 0lu, NONE);
}

fn store(fragment: Fragment) -> u32 {
    peel(0u, fragment);
    return KEPT;
}

fn resolve(pixel: u32) {
    emit_ends(pixel, 0u);
}

fn again(pixel: u32) -> bool {
    return !has_ended(pixel, 0u);
}
