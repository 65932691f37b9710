// Integers of 64 bits as pairs of 32-bit words, as many devices have none.

// x is the lower half.
alias Wide = vec2<u32>;

fn wide_add(a: Wide, b: Wide) -> Wide {
    let low = a.x + b.x;
    return Wide(low, a.y + b.y + u32(low < a.x));
}

// a - b, for a >= b.
fn wide_subtract(a: Wide, b: Wide) -> Wide {
    return Wide(a.x - b.x, a.y - b.y - u32(a.x < b.x));
}

fn wide_is_less(a: Wide, b: Wide) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

// The whole product of two words.
fn wide_product(a: u32, b: u32) -> Wide {
    let low = (a & 0xFFFFu) * (b & 0xFFFFu);
    let cross = (a >> 16u) * (b & 0xFFFFu) + (low >> 16u);
    let other = (a & 0xFFFFu) * (b >> 16u) + (cross & 0xFFFFu);
    return Wide((low & 0xFFFFu) | (other << 16u), (a >> 16u) * (b >> 16u) + (cross >> 16u) + (other >> 16u));
}

// The quotient, rounded down, where it fits a word; for a divisor below 2^63 that is not 0. Bit by bit.
fn wide_quotient(dividend: Wide, divisor: Wide) -> u32 {
    var rest = Wide(0u);
    var quotient = 0u;
    for (var i = 0u; i < 64u; i++) {
        let bit = 63u - i;
        let word = select(dividend.x, dividend.y, bit >= 32u);
        rest = Wide((rest.x << 1u) | ((word >> (bit % 32u)) & 1u), (rest.y << 1u) | (rest.x >> 31u));
        quotient <<= 1u;
        if !wide_is_less(rest, divisor) {
            rest = wide_subtract(rest, divisor);
            quotient |= 1u;
        }
    }
    return quotient;
}
