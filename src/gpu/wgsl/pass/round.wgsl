//# include pass/resolve

// Not 0: a pixel needs another round.
@group(1) @binding(4) var<storage, read_write> more: atomic<u32>;

// 0 in the first round.
override ROUND: u32 = 0u;

@compute @workgroup_size(64)
fn round_pass(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = linear(id);
    if pixel < PIXELS {
        resolve_behind(pixel, select(rays[pixel].count, 0u, ROUND == 0u));
        if again(pixel) {
            atomicStore(&more, 1u);
        }
    }
}
