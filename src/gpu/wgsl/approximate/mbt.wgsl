// Moment-based transparency (Münstermann, Krumpen, Klein, Peters 2018): the first of its two geometry passes, which sums
// the absorbance of a pixel's fragments, and its moments.
//
// The absorbance is a table of integers, and its sum b_0 has the simulator's bits, and so has the transmittance. A moment
// is the absorbance times powers of a float: its terms differ from those of the simulator, which computes in f64, by a
// bounded number of units in the last place (`gpu/twin/bounds.rs` counts the operations of this file). They are added as
// whole numbers, so that the sums do not depend on the order.
//
// The second pass is not here. It reconstructs the transmittance from the moments, which is ill-conditioned: in f32 no
// useful bound holds for it, and there is nothing to compare. The simulator does it in f64.
//
// Depth words are those of format d32. Resolve emits the pixel's words.

//# include shared/fragment
//# include approximate/sums
//# include approximate/table

// Bits after the point of a moment.
const POINT: u32 = 40u;

struct Pixel {
    nearest: atomic<u32>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;

fn clear(pixel: u32) {
    for (var i = 0u; i < WORDS64; i++) {
        clear_sum(pixel, i);
    }
    atomicStore(&pixels[pixel].nearest, EMPTY);
}

// From -1 at the near plane to 1 at the far plane: by the logarithm of the distance, or where rays are parallel, by the
// distance. No difference of near numbers is taken.
fn place_between_planes(depth: u32) -> f32 {
    if PARALLEL == 1u {
        return clamp(f32(depth) * TWICE_PER_DEPTH - 1.0, -1.0, 1.0);
    }
    let share = NEAR_PER_FAR + f32(0xFFFFFFFFu - depth) * SHARE_STEP;
    return clamp(-1.0 - log(share) * TWICE_PER_LOG, -1.0, 1.0);
}

// The same number with the other sign, as two's complement.
fn negative(x: Wide) -> Wide {
    return wide_add(~x, Wide(1u, 0u));
}

fn prepare(fragment: Fragment) {
    let pixel = fragment.pixel;
    let u = place_between_planes(fragment.depth);
    let absorbance = number_of(fragment.data >> 24u);
    add_to(pixel, 0u, absorbance);
    var power = f32(absorbance.y) * 0x1p-8f + f32(absorbance.x) * 0x1p-40f;
    for (var i = 1u; i <= MOMENTS; i++) {
        power *= u;
        let term = fixed(abs(power), POINT);
        if power < 0.0 {
            add_to(pixel, i, negative(term));
        } else {
            add_to(pixel, i, term);
        }
    }
    atomicMin(&pixels[pixel].nearest, fragment.depth);
}

fn screen(pixel: u32) {
    // The reconstruction at the nearest fragment: not here.
}

fn store(fragment: Fragment) -> u32 {
    // The reconstruction at the fragment: not here.
    return MERGED;
}

fn resolve(pixel: u32) {
    for (var i = 0u; i < WORDS64; i++) {
        emit_sum(pixel, i);
    }
    emit(Key(atomicLoad(&pixels[pixel].nearest), 0u));
}
