// Compositing a pixel's sorted records front to back, in 16-bit fixed point. Every product fits 32 bits:
// 65,535 * 255 * 255 + 32,512 and 65,535 * 65,535 + 32,767 are below 2^32.

//# include shared/emit

// The linear 16-bit values at which sRGB bytes begin, 256 of them; then a colour for every triangle, linear
// straight-alpha RGBA8 with R in the low byte.
@group(1) @binding(3) var<storage, read> palette: array<u32>;

// The background, linear 16-bit.
const BACKGROUND = vec3<u32>(BACKGROUND_R, BACKGROUND_G, BACKGROUND_B);

// The sRGB byte of a linear 16-bit value: the last one that begins at or below it.
fn srgb(linear: u32) -> u32 {
    var low = 0u;
    var high = 256u;
    while high - low > 1u {
        let middle = (low + high) / 2u;
        if palette[middle] <= linear {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

fn color_of(data: u32) -> u32 {
    if DATA_IS_TRIANGLE == 1u {
        return palette[256u + data];
    }
    return data;
}

fn composite(start: u32, count: u32) -> u32 {
    var sum = vec3<u32>(0u);
    var transmittance = 65535u;
    for (var i = 0u; i < count && transmittance > 0u; i++) {
        let word = color_of(lists[start + i].x);
        let color = vec3<u32>(word & 0xFFu, (word >> 8u) & 0xFFu, (word >> 16u) & 0xFFu);
        let alpha = word >> 24u;
        sum = min(sum + (transmittance * alpha * color + 32512u) / 65025u, vec3<u32>(65535u));
        transmittance = (transmittance * (255u - alpha) + 127u) / 255u;
    }
    let behind = (transmittance * BACKGROUND + 32767u) / 65535u;
    let linear = min(sum + behind, vec3<u32>(65535u));
    return srgb(linear.x) | (srgb(linear.y) << 8u) | (srgb(linear.z) << 16u) | 0xFF000000u;
}
