// What crosses from the rasterizer to a method, and the outcome that a method gives it. The numbers are the
// simulator's.

struct Fragment {
    // Which pixel's memory it goes to: a place in block-linear storage (see shared/grid.wgsl).
    pixel: u32,
    depth: u32,
    data: u32,
    // A third word, where the method's fragments have one: the near end of a slab.
    extra: u32,
    // Written by the store pass.
    outcome: u32,
}

// A record of 64 bits: the data word is the lower half (x), depth the upper one (y).
alias Key = vec2<u32>;

fn key_of(fragment: Fragment) -> Key {
    return Key(fragment.data, fragment.depth);
}

// The canonical order: by depth, then by data.
fn is_less(a: Key, b: Key) -> bool {
    return a.y < b.y || (a.y == b.y && a.x < b.x);
}

const KEPT: u32 = 0u;
const CULLED: u32 = 1u;
const EVICTED: u32 = 2u;
const OVERFLOW: u32 = 3u;
const POOL: u32 = 4u;
const DUPLICATE: u32 = 5u;
const AGE: u32 = 6u;
// It gave up waiting for a lock. No simulated invocation does this.
const STUCK: u32 = 7u;
// It went into another record, or into what its pixel holds instead of records.
const MERGED: u32 = 8u;

// No fragment: what a clear pass writes for a depth.
const EMPTY: u32 = 0xFFFFFFFFu;
