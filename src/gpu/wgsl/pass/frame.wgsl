//# include shared/index
//# include pass/number

// How many invocations it has.
override INVOCATIONS: u32 = 1u;

@compute @workgroup_size(64)
fn frame_pass(@builtin(global_invocation_id) id: vec3<u32>) {
    let index = linear(id);
    if index < INVOCATIONS {
        frame(PASS, index);
    }
}
