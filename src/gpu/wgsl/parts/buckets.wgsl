// Uniform buckets over a pixel's depth range, both ends included. The quotient and the product before it may need 34
// bits.

//# include shared/wide

const BUCKETS: u32 = 4u;

// `BUCKETS (depth - near) / (far - near + 1)`, rounded down; near <= depth <= far.
fn bucket_of(depth: u32, near: u32, far: u32) -> u32 {
    let length = wide_add(Wide(far - near, 0u), Wide(1u, 0u));
    return wide_quotient(wide_product(BUCKETS, depth - near), length);
}
