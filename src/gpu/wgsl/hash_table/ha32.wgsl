// HA-buffer of depths alone (Lefebvre, Hornus, Lasram 2013, section 4.1.3): for layered depth images and voxels.
//
// As `ha64`, with records of age and depth only, which 32-bit atomics can hold. Fragments of a pixel with equal depths
// are equal, and one of them is kept.

//# include shared/fragment
//# include parts/table
//# include shared/emit

// The largest depth of 24 bits.
const FAR: u32 = 0xFFFFFFu;

struct Frame {
    cells: array<atomic<u32>, CELLS>,
    largest: array<atomic<u32>>,
}

@group(0) @binding(2) var<storage, read_write> memory: Frame;

// Age 8 | reversed depth 24, from the upper bits to the lower. 0 is empty.
fn pack(age: u32, key: Key) -> u32 {
    return (age << 24u) | (FAR - key.y);
}

fn age_of(record: u32) -> u32 {
    return record >> 24u;
}

fn key_in(record: u32) -> Key {
    return Key(0u, FAR - (record & FAR));
}

fn clear(pixel: u32) {}

fn frame(number: u32, index: u32) {
    let first = index * CLEARED;
    let end = first + CLEARED;
    for (var i = first; i < min(end, CELLS); i++) {
        atomicStore(&memory.cells[i], 0u);
    }
    for (var i = max(first, CELLS); i < min(end, CELLS + LARGEST); i++) {
        atomicStore(&memory.largest[i - CELLS], 0u);
    }
}

fn store(fragment: Fragment) -> u32 {
    var place = begin_of(fragment.pixel);
    var own = key_of(fragment);
    var age = 1u;
    while age <= AGES {
        let record = pack(age, own);
        let cell = cell_of(place, age);
        let old = atomicMax(&memory.cells[index_of(cell)], record);
        if old == record {
            return DUPLICATE;
        }
        if old < record {
            atomicMax(&memory.largest[block_of(place)], age);
            if old == 0u {
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
    let last = min(atomicLoad(&memory.largest[block_of(place)]), AGES);
    for (var age = 1u; age <= last; age++) {
        let record = atomicLoad(&memory.cells[index_of(cell_of(place, age))]);
        if age_of(record) == age {
            emit(key_in(record));
        }
        // A walk ends at the first record that is younger than it.
        if age_of(record) < age {
            return;
        }
    }
}
