//# include shared/index
//# include shared/sort
//# include shared/composite

@compute @workgroup_size(64)
fn resolve_pass(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = linear(id);
    if pixel < PIXELS {
        ray = rays[pixel];
        ray.count = 0u;
        resolve(pixel);
        let count = min(ray.count, ray.room);
        rays[pixel].count = ray.count;
        // Merged records are several words each, and their colours are no whole numbers.
        if HOLDS_RECORDS == 0u {
            sort(ray.start, count);
            rays[pixel].color = composite(ray.start, count);
        }
    }
}
