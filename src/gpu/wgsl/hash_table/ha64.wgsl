// HA-buffer (Lefebvre, Hornus, Lasram 2013): all fragments of a frame in one hash table, sorted as they are inserted.
//
// A fragment walks its pixel's cells, age by age, and an atomic maximum puts its record where that is larger than what
// is there. Records have the age in their upper bits, so that the older wins (Robin Hood); then the depth, reversed, so
// that of two fragments of one pixel the nearer wins. An invocation that displaces a record goes on to insert it: the
// record's cell and age name its pixel. So an invocation may end with another pixel's fragment.
//
// Resolve takes every age up to the largest; the paper's listing stops before it. WGSL has no 64-bit atomics: they are
// an extension of naga's.

//# include shared/fragment
//# include parts/table
//# include parts/alike
//# include shared/emit

// The largest depth of 24 bits.
const FAR: u32 = 0xFFFFFFu;

@group(0) @binding(2) var<storage, read_write> largest: array<atomic<u32>>;
@group(0) @binding(3) var<storage, read_write> cells: array<atomic<u64>>;

// Age 8 | reversed depth 24 | data 32, from the upper bits to the lower. 0 is empty.
fn pack(age: u32, key: Key) -> u64 {
    let upper = (age << 24u) | (FAR - key.y);
    return (u64(upper) << 32u) | u64(key.x);
}

fn age_of(record: u64) -> u32 {
    return u32(record >> 56u);
}

fn key_in(record: u64) -> Key {
    let upper = u32(record >> 32u);
    return Key(u32(record & 0xFFFFFFFFlu), FAR - (upper & FAR));
}

fn clear(pixel: u32) {}

fn frame(number: u32, index: u32) {
    let first = index * CLEARED;
    let end = first + CLEARED;
    for (var i = first; i < min(end, CELLS); i++) {
        atomicStore(&cells[i], 0lu);
    }
    for (var i = max(first, CELLS); i < min(end, CELLS + LARGEST); i++) {
        atomicStore(&largest[i - CELLS], 0u);
    }
}

fn store(fragment: Fragment) -> u32 {
    var place = begin_of(fragment.pixel);
    var own = key_of(fragment);
    var age = 1u;
    while age <= AGES {
        let record = pack(age, own);
        let cell = cell_of(place, age);
        let old = atomicMax(&cells[index_of(cell)], record);
        if ONE_OF_ALIKE && old == record {
            return DUPLICATE;
        }
        if old < record {
            atomicMax(&largest[block_of(place)], age);
            if old == 0lu {
                return KEPT;
            }
            age = age_of(old);
            place = origin_of(cell, age);
            own = key_in(old);
        }
        age += 1u;
    }
    return AGE;
}

fn resolve(pixel: u32) {
    if !is_seen(pixel) {
        return;
    }
    let place = begin_of(pixel);
    let last = min(atomicLoad(&largest[block_of(place)]), AGES);
    for (var age = 1u; age <= last; age++) {
        let record = atomicLoad(&cells[index_of(cell_of(place, age))]);
        if age_of(record) == age {
            emit(key_in(record));
        }
        // A walk ends at the first record that is younger than it.
        if age_of(record) < age {
            return;
        }
    }
}
