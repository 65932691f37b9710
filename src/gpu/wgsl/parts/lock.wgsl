// A spin lock: a word per pixel, 0 when free. It is taken by an exchange that finds 0, and given back by a store of 0.
//
// WGSL does not guarantee what a lock needs. Its atomics are relaxed, so what was written under the lock may reach the
// next holder late; and nothing guarantees that a waiting lane lets the holder run. So the critical section is inside
// the loop, and an invocation that has waited too long gives up and reports it.
//
// What has to be ordered is in functions of its own, here and in methods: in the Vulkan form, an atomic operation in a
// function `acquire_...` acquires, and one in a function `release_...` releases.
//
// The method declares the words: an atomic `lock` of each of `pixels`.

const FREE: u32 = 0u;
const TAKEN: u32 = 1u;

// Attempts before an invocation gives up, with nothing stored; the host then reruns it. Fewer than the 65,535
// iterations after which some drivers end any loop.
const PATIENCE: u32 = 32768u;

// Try once: whether this invocation holds it now.
fn acquire_lock(pixel: u32) -> bool {
    return atomicExchange(&pixels[pixel].lock, TAKEN) == FREE;
}

fn release_lock(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
}
