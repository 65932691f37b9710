// Weighted blended OIT (McGuire, Bavoil 2013): sums of colours by a weight of depth and opacity, and the transmittance
// of all fragments as a sum of logarithms.
//
// The sum of logarithms is integers, and has the simulator's bits. The weight is a float: its terms differ from those
// of the simulator, which computes in f64, by a bounded number of units in the last place (`gpu/twin/bounds.rs` counts
// the operations of this file). They are added as whole numbers, so that the sums do not depend on the order.
//
// Depth words are those of format d32. Resolve emits the pixel's words, and the host takes the colour from them.

//# include shared/fragment
//# include approximate/sums
//# include approximate/table

// Bits after the point of a weighted sum.
const POINT: u32 = 34u;

// Where the logarithms are summed.
const PASSING: u32 = 4u;

const OPAQUE: u32 = 0x80000000u;

// Weights no longer change beyond this distance, and no power of it overflows.
const FAR_ENOUGH: f32 = 10000.0;

fn clear(pixel: u32) {
    for (var i = 0u; i < WORDS64; i++) {
        clear_sum(pixel, i);
    }
}

// The distance along the line of sight. No difference of near numbers is taken.
fn along(depth: u32) -> f32 {
    if PARALLEL == 1u {
        return NEAR + f32(depth) * DEPTH_STEP;
    }
    return NEAR_TIMES_FAR / (NEAR + f32(0xFFFFFFFFu - depth) * DEPTH_STEP);
}

// The weight, without its factor of opacity.
fn weight(depth: u32) -> f32 {
    let z = min(along(depth), FAR_ENOUGH);
    let far = (z / 200.0) * (z / 200.0);
    var w = 0.0;
    if WEIGHT == 0u {
        w = 10.0 / (1e-5 + (z / 5.0) * (z / 5.0) + far * far * far);
    } else if WEIGHT == 1u {
        w = 10.0 / (1e-5 + (z / 10.0) * (z / 10.0) * (z / 10.0) + far * far * far);
    } else if WEIGHT == 2u {
        w = 0.03 / (1e-5 + far * far);
    } else {
        let rest = f32(0xFFFFFFFFu - depth) / 4294967295.0;
        w = 3000.0 * rest * rest * rest;
    }
    return clamp(w, 0.01, 3000.0);
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    let word = fragment.data;
    let alpha = word >> 24u;
    let color = alpha * vec3<u32>(word & 0xFFu, (word >> 8u) & 0xFFu, (word >> 16u) & 0xFFu);
    let a = f32(alpha) / 255.0;
    let w = a * weight(fragment.depth);
    let terms = vec4<f32>(vec3<f32>(color) / 65025.0, a) * w;
    for (var i = 0u; i < 4u; i++) {
        add_to(pixel, i, fixed(terms[i], POINT));
    }
    if alpha == 255u {
        atomicOr(&sums[pixel].words[PASSING][1], OPAQUE);
    } else {
        add_to(pixel, PASSING, number_of(alpha));
    }
    return MERGED;
}

fn resolve(pixel: u32) {
    for (var i = 0u; i < WORDS64; i++) {
        emit_sum(pixel, i);
    }
}
