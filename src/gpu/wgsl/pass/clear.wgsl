//# include shared/index

@compute @workgroup_size(64)
fn clear_pass(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = linear(id);
    if pixel < PIXELS {
        clear(pixel);
    }
}
