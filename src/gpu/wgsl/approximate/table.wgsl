// A 64-bit number for every opacity byte, which the host fills in: two to a vector, the lower half first.

//# include shared/wide

@group(0) @binding(4) var<uniform> table: array<vec4<u32>, 128>;

fn number_of(alpha: u32) -> Wide {
    let pair = table[alpha / 2u];
    if alpha % 2u == 0u {
        return pair.xy;
    }
    return pair.zw;
}
