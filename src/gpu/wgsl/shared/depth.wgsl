// Exact integer depth: a plane per triangle with 24 fraction bits, evaluated modulo 2^64 in pairs of 32-bit words, as
// many devices have no 64-bit integers. What wraps cancels, since the true value at a covered pixel fits easily.

//# include shared/wide

// The product with a number below 2^16.
fn wide_times(a: Wide, factor: u32) -> Wide {
    let first = (a.x & 0xFFFFu) * factor;
    let second = (a.x >> 16u) * factor + (first >> 16u);
    return Wide((first & 0xFFFFu) | (second << 16u), a.y * factor + (second >> 16u));
}

struct Plane {
    // Slope per pixel to the right, per pixel down, and the value at the centre of pixel (0, 0).
    right: Wide,
    down: Wide,
    origin: Wide,
    // The triangle's own range of codes.
    nearest: u32,
    farthest: u32,
}

// The code at the centre of a pixel, halves rounded up, clamped to the triangle's range.
fn depth_code(plane: Plane, place: vec2<u32>) -> u32 {
    let across = wide_add(wide_times(plane.right, place.x), wide_times(plane.down, place.y));
    let sum = wide_add(wide_add(plane.origin, across), Wide(1u << 23u, 0u));
    let whole = i32(sum.y) >> 24u;
    let code = (sum.y << 8u) | (sum.x >> 24u);
    if whole < 0 {
        return plane.nearest;
    }
    if whole > 0 {
        return plane.farthest;
    }
    return clamp(code, plane.nearest, plane.farthest);
}
