// Sums of 64 bits: two 32-bit words with a carry. An addition that wraps the lower word adds 1 to the upper one. The order
// of additions does not matter: in the end, a sum is right. Before that, its two words need not belong together.

//# include shared/wide
//# include shared/emit

// All 64-bit words of a pixel.
struct Sums {
    words: array<array<atomic<u32>, 2>, WORDS64>,
}

@group(0) @binding(1) var<storage, read_write> sums: array<Sums>;

fn clear_sum(pixel: u32, i: u32) {
    atomicStore(&sums[pixel].words[i][0], 0u);
    atomicStore(&sums[pixel].words[i][1], 0u);
}

fn add_to(pixel: u32, i: u32, term: Wide) {
    let old = atomicAdd(&sums[pixel].words[i][0], term.x);
    let upper = term.y + u32(old + term.x < old);
    if upper > 0u {
        atomicAdd(&sums[pixel].words[i][1], upper);
    }
}

fn emit_sum(pixel: u32, i: u32) {
    emit(Key(atomicLoad(&sums[pixel].words[i][0]), atomicLoad(&sums[pixel].words[i][1])));
}

// A float from 0 up to 2^(54 - point) as a whole number of units of 2^-point, rounded: the 24 bits of its mantissa,
// shifted.
fn fixed(x: f32, point: u32) -> Wide {
    let bits = bitcast<u32>(x);
    let mantissa = (bits & 0x7FFFFFu) | 0x800000u;
    // The float is the mantissa times 2 to the power of its exponent - 150.
    let left = i32((bits >> 23u) + point) - 150;
    if left > 0 {
        let by = u32(left) % 32u;
        return Wide(mantissa << by, mantissa >> (32u - by));
    }
    let by = u32(-left);
    if by == 0u {
        return Wide(mantissa, 0u);
    }
    if by > 24u {
        return Wide(0u);
    }
    return Wide((mantissa + (1u << (by - 1u))) >> by, 0u);
}
