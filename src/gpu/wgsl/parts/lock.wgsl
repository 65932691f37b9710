// A spin lock: a word per pixel, 0 when free. It is taken by an exchange that finds 0, and given back by a store of 0.
//
// WGSL does not guarantee what a lock needs. Its atomics are relaxed, so what was written under the lock may reach the
// next holder late; and nothing guarantees that a waiting lane lets the holder run: lanes of one warp may wait for one
// that waits for them to leave the loop. So the critical section is inside of the loop, and an invocation that has tried
// PATIENCE times gives up with nothing stored, and reports it; the host reruns it. The host defines PATIENCE: fewer
// attempts in a fragment shader, where a hang takes the whole device with it.
//
// What has to be ordered is in functions of its own, here and in methods: in the Vulkan form, an atomic operation in a
// function `acquire_...` acquires, and one in a function `release_...` releases.
//
// The method declares the words: an atomic `lock` of each of `pixels`.

//# include parts/unlock

const FREE: u32 = 0u;
const TAKEN: u32 = 1u;

// Try once: whether this invocation holds it now.
fn acquire_lock(pixel: u32) -> bool {
    return atomicExchange(&pixels[pixel].lock, TAKEN) == FREE;
}
