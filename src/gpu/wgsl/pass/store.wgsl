//# include shared/index
//# include shared/fragments

@compute @workgroup_size(64)
fn store_pass(@builtin(global_invocation_id) id: vec3<u32>) {
    let i = linear(id);
    if i < arrayLength(&fragments) {
        fragments[i].outcome = store(fragments[i]);
    }
}
