// Light gathered along a ray, front to back, in 16-bit fixed point: as compositing does it (`shared/composite.wgsl`).
// Every product fits 32 bits.

struct Light {
    // Red, green and blue so far, 0 to 65,535; and the share of what is behind that passes.
    color: vec3<u32>,
    transmittance: u32,
}

// Nothing was met.
fn no_light() -> Light {
    return Light(vec3<u32>(0u), 65535u);
}

// The light in two words, 16 bits each, red lowest, transmittance highest.
fn light_of(word: vec2<u32>) -> Light {
    return Light(vec3<u32>(word.x & 0xFFFFu, word.x >> 16u, word.y & 0xFFFFu), word.y >> 16u);
}

fn word_of_light(light: Light) -> vec2<u32> {
    let color = light.color;
    return vec2<u32>(color.x | (color.y << 16u), color.z | (light.transmittance << 16u));
}

// With the next surface behind it.
fn over(light: Light, word: u32) -> Light {
    let color = vec3<u32>(word & 0xFFu, (word >> 8u) & 0xFFu, (word >> 16u) & 0xFFu);
    let alpha = word >> 24u;
    let sum = light.color + (light.transmittance * alpha * color + 32512u) / 65025u;
    let passes = (light.transmittance * (255u - alpha) + 127u) / 255u;
    return Light(min(sum, vec3<u32>(65535u)), passes);
}

// With what was gathered behind it.
fn through(light: Light, behind: Light) -> Light {
    let sum = light.color + (light.transmittance * behind.color + 32767u) / 65535u;
    let passes = (light.transmittance * behind.transmittance + 32767u) / 65535u;
    return Light(min(sum, vec3<u32>(65535u)), passes);
}
