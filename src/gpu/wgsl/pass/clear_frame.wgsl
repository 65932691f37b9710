//# include shared/index

@compute @workgroup_size(1)
fn clear_frame_pass() {
    clear_frame();
}
