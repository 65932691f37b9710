// Give a lock back by an update, after what the holder's updates have got.

//# include reach/updates

fn release_lock(pixel: u32) {
    atomicExchange(&pixels[pixel].lock, FREE | (given & never(pixel)));
}
