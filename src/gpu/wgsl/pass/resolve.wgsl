//# include shared/index
//# include shared/sort
//# include shared/composite

// Add what a pixel has to the records that were emitted before.
fn resolve_behind(pixel: u32, before: u32) {
    ray = rays[pixel];
    ray.count = before;
    resolve(pixel);
    let count = min(ray.count, ray.room);
    rays[pixel].count = ray.count;
    // Merged records are several words each, and their colours are no whole numbers.
    if HOLDS_RECORDS == 0u {
        sort(ray.start, count);
        rays[pixel].color = composite(ray.start, count);
    }
}

@compute @workgroup_size(64)
fn resolve_pass(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = linear(id);
    if pixel < PIXELS {
        resolve_behind(pixel, 0u);
    }
}
