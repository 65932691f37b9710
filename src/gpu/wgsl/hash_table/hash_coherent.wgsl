// Coherent hashing with explicit keys (García, Lefebvre, Hornus, Lasram 2011), for fragments.
//
// A record is age 8 | key 24 | node 32, from the upper bits to the lower; the key is the pixel, and the node holds the
// fragment. All fragments of a pixel have its key, and stand anywhere on its walk. A displaced record is identified by
// its key, and takes its node with it. WGSL has no 64-bit atomics: they are an extension of naga's.

//# include shared/fragment
//# include shared/word64
//# include parts/table
//# include shared/emit

const KEY: u32 = 0xFFFFFFu;

struct Frame {
    largest: array<atomic<u32>, LARGEST>,
    taken: atomic<u32>,
}

@group(0) @binding(2) var<storage, read_write> memory: Frame;
@group(0) @binding(3) var<storage, read_write> words: Words;

struct Words {
    cells: array<atomic<u64>, CELLS>,
    nodes: array<u64>,
}

fn pack(age: u32, pixel: u32, node: u32) -> u64 {
    return (u64((age << 24u) | pixel) << 32u) | u64(node);
}

fn age_in(record: u64) -> u32 {
    return u32(record >> 56u);
}

fn pixel_in(record: u64) -> u32 {
    return u32(record >> 32u) & KEY;
}

fn node_in(record: u64) -> u32 {
    return u32(record & 0xFFFFFFFFlu);
}

fn clear_frame() {
    atomicStore(&memory.taken, 0u);
}

fn clear(pixel: u32) {}

fn frame(number: u32, index: u32) {
    let first = index * CLEARED;
    let end = first + CLEARED;
    for (var i = first; i < min(end, CELLS); i++) {
        atomicStore(&words.cells[i], 0lu);
    }
    for (var i = max(first, CELLS); i < min(end, CELLS + LARGEST); i++) {
        atomicStore(&memory.largest[i - CELLS], 0u);
    }
}

fn store(fragment: Fragment) -> u32 {
    var node = atomicAdd(&memory.taken, 1u);
    if node >= GENERATED {
        return POOL;
    }
    words.nodes[node] = word_of(key_of(fragment));
    var pixel = fragment.pixel;
    var age = 1u;
    while age <= AGES {
        let place = begin_of(pixel);
        let record = pack(age, pixel, node);
        let old = atomicMax(&words.cells[index_of(cell_of(place, age))], record);
        if old < record {
            atomicMax(&memory.largest[block_of(place)], age);
            if old == 0lu {
                return KEPT;
            }
            pixel = pixel_in(old);
            age = age_in(old);
            node = node_in(old);
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
        let record = atomicLoad(&words.cells[index_of(cell_of(place, age))]);
        if age_in(record) == age && pixel_in(record) == pixel {
            emit(key_in(words.nodes[node_in(record)]));
        }
        if age_in(record) < age {
            return;
        }
    }
}
