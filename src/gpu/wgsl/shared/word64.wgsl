// Records as 64-bit integers, which one atomic operation can compare and replace as a whole. Not in the standard:
// 64-bit integers, and atomic operations on them, are extensions of naga's.

fn word_of(key: Key) -> u64 {
    return (u64(key.y) << 32u) | u64(key.x);
}

fn key_in(word: u64) -> Key {
    return Key(u32(word & 0xFFFFFFFFlu), u32(word >> 32u));
}
