// Multi depth test with 64-bit atomics (Liu, Huang, Liu, Wu 2010; KB-MDT as it would be with them).
//
// k entries, each lowered by an atomic minimum on the whole record; the record that an entry gives up moves on to the
// next. Every minimum keeps the multiset of what entries hold and invocations carry: in the end the entries are the k
// smallest in order. WGSL has no 64-bit atomics: they are an extension of naga's.

//# include shared/fragment
//# include shared/word64
//# include shared/emit

struct Pixel {
    entries: array<atomic<u64>, K>,
}

@group(0) @binding(1) var<storage, read_write> pixels: array<Pixel>;

// What an empty entry holds: farther than any record.
const CLEARED: u64 = 0xFFFFFFFFFFFFFFFFlu;

fn clear(pixel: u32) {
    for (var i = 0u; i < K; i++) {
        atomicStore(&pixels[pixel].entries[i], CLEARED);
    }
}

fn store(fragment: Fragment) -> u32 {
    let own = word_of(key_of(fragment));
    var carried = own;
    for (var i = 0u; i < K; i++) {
        carried = max(carried, atomicMin(&pixels[fragment.pixel].entries[i], carried));
        if carried == CLEARED {
            return KEPT;
        }
    }
    return select(EVICTED, CULLED, carried == own);
}

fn resolve(pixel: u32) {
    for (var i = 0u; i < K; i++) {
        let record = atomicLoad(&pixels[pixel].entries[i]);
        if record == CLEARED {
            return;
        }
        emit(key_in(record));
    }
}
