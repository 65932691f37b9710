// A spin lock: a word per pixel, 0 when free. It is taken by an exchange that finds 0, and given back by a store of 0.
//
// WGSL does not guarantee what a lock needs. Its atomics are relaxed, so what was written under the lock may reach the
// next holder late; and nothing guarantees that a waiting lane lets the holder run. So the critical section is inside
// the loop, and an invocation that has waited too long gives up and reports it.

const FREE: u32 = 0u;
const TAKEN: u32 = 1u;

// Attempts before an invocation gives up, with nothing stored; the host then reruns it. Fewer than the 65,535
// iterations after which some drivers end any loop.
const PATIENCE: u32 = 32768u;
