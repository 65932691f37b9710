// Give a lock back by a store.

fn release_lock(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
}
