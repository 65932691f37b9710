//# include shared/index
//# include pass/number

// Every pixel, or only one of them.
const ALL: u32 = 0xFFFFFFFFu;
override ONLY: u32 = ALL;

@compute @workgroup_size(64)
fn screen_pass(@builtin(global_invocation_id) id: vec3<u32>) {
    let pixel = linear(id);
    if pixel < PIXELS && (ONLY == ALL || ONLY == pixel) {
        screen(pixel);
    }
}
