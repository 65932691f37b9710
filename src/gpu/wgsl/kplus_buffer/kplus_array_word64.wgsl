// The max-array of the k+-buffer with a record in one 64-bit word: no lock is left, and no counter.
//
// A fragment looks at all k entries. If it is nearer than the farthest, it takes that one's place by a compare-exchange;
// if another was there first, it looks again. Entries only become nearer, so that a stale value is only too far: nothing
// need be ordered, and nothing waits. WGSL has no 64-bit atomics: they are an extension of naga's.

//# include shared/fragment
//# include shared/word64
//# include shared/emit

struct Pixel {
    entries: array<atomic<u64>, K>,
}

@group(0) @binding(1) var<storage, read_write> pixels: array<Pixel>;

// What an empty entry holds: farther than any record.
const CLEARED: u64 = 0xFFFFFFFFFFFFFFFFlu;

// A compare-exchange fails because another invocation got in, which changes the entry. If the entry did not change, it
// failed spuriously, as WGSL allows, or this lane is a helper of a quad, whose atomics do nothing. That may happen this
// often.
const FUTILE: u32 = 64u;

fn clear(pixel: u32) {
    for (var i = 0u; i < K; i++) {
        atomicStore(&pixels[pixel].entries[i], CLEARED);
    }
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    let own = word_of(key_of(fragment));
    var last = 0lu;
    var at = K;
    var futile = 0u;
    while futile < FUTILE {
        var place = 0u;
        var farthest = 0lu;
        for (var i = 0u; i < K && farthest != CLEARED; i++) {
            let entry = atomicLoad(&pixels[pixel].entries[i]);
            if entry > farthest {
                place = i;
                farthest = entry;
            }
        }
        if farthest <= own {
            return CULLED;
        }
        futile += u32(farthest == last && place == at);
        last = farthest;
        at = place;
        if atomicCompareExchangeWeak(&pixels[pixel].entries[place], farthest, own).exchanged {
            return select(EVICTED, KEPT, farthest == CLEARED);
        }
    }
    return STUCK;
}

fn resolve(pixel: u32) {
    for (var i = 0u; i < K; i++) {
        let entry = atomicLoad(&pixels[pixel].entries[i]);
        if entry != CLEARED {
            emit(key_in(entry));
        }
    }
}
