// k-buffer with a k for every pixel, by importance (Vasilakis et al. 2017).
//
// Every pixel gets its share of the frame's records by its importance, in a contiguous range, and keeps its nearest
// fragments there as the k+-buffer does: in a max-array, or a max-heap where k > 16 and there are more fragments.
// Importance is in units of 2^-16, so that its sum does not depend on the order. What the lock needs is outside WGSL's
// guarantees: see parts/lock.

//# include pass/number
//# include shared/fragment
//# include shared/wide
//# include parts/lock
//# include parts/locked_row
//# include shared/emit

// An importance of 1.
const ONE: u32 = 65536u;

// Numbers of passes.
const IMPORTANCE: u32 = 1u;
const WEIGHT_BLOCKS: u32 = 2u;
const WEIGHT_GROUPS: u32 = 3u;
const SHARE: u32 = 4u;
const RANGE_BLOCKS: u32 = 5u;

struct Pixel {
    lock: atomic<u32>,
    counter: atomic<u32>,
    // The importance, then k.
    share: u32,
    offset: u32,
}

struct Frame {
    blocks: array<atomic<u32>, BLOCKS>,
    groups: array<u32, GROUPS>,
    weight_blocks: array<atomic<u32>, BLOCKS>,
    weight_groups: array<u32, GROUPS>,
    depth: array<atomic<u32>, RECORDS_ROOM>,
    data: array<Word>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(2) var<storage, read_write> memory: Frame;
// The sum of all importances.
@group(0) @binding(3) var<storage, read_write> total: array<Wide>;
@group(0) @binding(5) var<storage, read> inputs: array<u32>;

fn clear_frame() {
    clear_sums();
    for (var block = 0u; block < BLOCKS; block++) {
        atomicStore(&memory.weight_blocks[block], 0u);
    }
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
    atomicStore(&pixels[pixel].counter, 0u);
}

// The count pass.
fn prepare(fragment: Fragment) {
    atomicAdd(&pixels[fragment.pixel].counter, 1u);
}

fn weight_of(pixel: u32, count: u32) -> u32 {
    if count == 0u {
        return 0u;
    }
    let factor = min(inputs[INPUT_IMPORTANCE + pixel], ONE);
    let layers = ((ONE - ALPHA) * min(count, LAYERS) + LAYERS / 2u) / LAYERS;
    var product = ALPHA + layers;
    if factor < ONE {
        product = (factor * product + ONE / 2u) / ONE;
    }
    let bias = clamp(i32(inputs[INPUT_IMPORTANCE_BIAS + pixel]), -i32(ONE), i32(ONE));
    return u32(max(i32(product) + bias, 0));
}

// The importance pass.
fn weigh(pixel: u32) {
    let weight = weight_of(pixel, atomicLoad(&pixels[pixel].counter));
    pixels[pixel].share = weight;
    if weight > 0u {
        atomicAdd(&memory.weight_blocks[pixel / RADIX], weight);
    }
}

// The pass that computes k. From here on, the counter counts what is stored.
fn divide(pixel: u32) {
    let weight = pixels[pixel].share;
    if weight > 0u {
        let count = atomicLoad(&pixels[pixel].counter);
        let k = wide_quotient(wide_product(weight, RECORDS), total[0]);
        pixels[pixel].share = k;
        if k > 0u {
            refer(pixel, k, count > k);
        }
    }
    atomicStore(&pixels[pixel].counter, 0u);
}

fn screen(pixel: u32) {
    if PASS == IMPORTANCE {
        weigh(pixel);
    } else if PASS == SHARE {
        divide(pixel);
    } else if pixels[pixel].share > 0u {
        place(pixel);
    }
}

fn sum_weight_blocks(group: u32) {
    var sum = 0u;
    let first = group * RADIX;
    for (var block = first; block < min(BLOCKS, first + RADIX); block++) {
        sum += atomicLoad(&memory.weight_blocks[block]);
    }
    memory.weight_groups[group] = sum;
}

fn sum_weight_groups() {
    var sum = Wide(0u);
    for (var group = 0u; group < GROUPS; group++) {
        sum = wide_add(sum, Wide(memory.weight_groups[group], 0u));
    }
    total[0] = sum;
}

fn frame(number: u32, index: u32) {
    if number == WEIGHT_BLOCKS {
        sum_weight_blocks(index);
    } else if number == WEIGHT_GROUPS {
        sum_weight_groups();
    } else if number == RANGE_BLOCKS {
        sum_blocks(index);
    } else {
        sum_groups();
    }
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    let k = pixels[pixel].share;
    if k == 0u {
        return CULLED;
    }
    let range = placed(pixel);
    if acquire_count(pixel) == k && fragment.depth > farthest_of(range.start) {
        return CULLED;
    }
    var outcome = STUCK;
    for (var attempt = 0u; outcome == STUCK && attempt < PATIENCE; attempt++) {
        if acquire_lock(pixel) {
            outcome = insert(pixel, range, k, key_of(fragment));
            release_lock(pixel);
        }
    }
    return outcome;
}

fn resolve(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    if count > 0u {
        let first = placed(pixel).start;
        for (var i = 0u; i < count; i++) {
            emit(settled(first, i));
        }
    }
}
