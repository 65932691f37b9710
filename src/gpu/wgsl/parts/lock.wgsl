// A spin lock: a word per pixel, 0 when free. It is taken by an exchange that finds 0, and given back by a store of 0.
//
// WGSL does not guarantee what a lock needs. Its atomics are relaxed, so that what was written under the lock may reach
// the next holder late; and nothing promises that a lane which waits lets the holder run. So the critical section stands
// inside the loop, and who has waited too long goes away and says so.

const FREE: u32 = 0u;
const TAKEN: u32 = 1u;

// Attempts before an invocation gives up, with nothing stored; the host then runs it again. Fewer than the 65,535
// iterations after which some drivers end any loop.
const PATIENCE: u32 = 32768u;
