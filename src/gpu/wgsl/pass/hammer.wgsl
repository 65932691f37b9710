// Invocations that do nothing but load the memory system, beside those of a litmus pixel's copies.

@group(0) @binding(0) var<storage, read_write> scratch: array<atomic<u32>>;

@compute @workgroup_size(64)
fn hammer(@builtin(global_invocation_id) id: vec3<u32>) {
    let room = arrayLength(&scratch);
    var at = id.x * 97u % room;
    for (var i = 0u; i < 64u; i++) {
        at = (at + atomicAdd(&scratch[at], 1u) + 4099u) % room;
    }
}
