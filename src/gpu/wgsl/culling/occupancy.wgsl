// Occupancy-based fragment culling (Vasilakis, Fudos 2014): the nearest and the farthest depth of every pixel; a mask of
// the intervals between them that hold a fragment; and the far end of the interval of the k-th set bit.

//# include shared/fragment
//# include shared/wide
//# include shared/emit

struct Pixel {
    near: atomic<u32>,
    far: atomic<u32>,
    mask: array<atomic<u32>, MASK_WORDS>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(5) var<storage, read> inputs: array<u32>;

const INTERVALS: u32 = 32u * MASK_WORDS;

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].near, EMPTY);
    atomicStore(&pixels[pixel].far, 0u);
    for (var word = 0u; word < MASK_WORDS; word++) {
        atomicStore(&pixels[pixel].mask[word], 0u);
    }
}

// The range pass.
fn prepare(fragment: Fragment) {
    atomicMin(&pixels[fragment.pixel].near, fragment.depth);
    atomicMax(&pixels[fragment.pixel].far, fragment.depth);
}

// The mask pass.
fn store(fragment: Fragment) -> u32 {
    let near = atomicLoad(&pixels[fragment.pixel].near);
    let far = atomicLoad(&pixels[fragment.pixel].far);
    let range = wide_add(Wide(far - near, 0u), Wide(1u, 0u));
    let interval = wide_quotient(wide_product(fragment.depth - near, INTERVALS), range);
    atomicOr(&pixels[fragment.pixel].mask[interval / 32u], 1u << (interval % 32u));
    return MERGED;
}

// The last depth of an interval.
fn end_of(near: u32, far: u32, interval: u32) -> u32 {
    let next = wide_add(wide_product(interval + 1u, far - near), Wide(interval + 1u, 0u));
    return near + wide_quotient(wide_subtract(next, Wide(1u, 0u)), Wide(INTERVALS, 0u));
}

fn resolve(pixel: u32) {
    let near = atomicLoad(&pixels[pixel].near);
    if near == EMPTY {
        return;
    }
    let far = atomicLoad(&pixels[pixel].far);
    // A pixel's own k; 0 stands for that of all.
    let own = inputs[INPUT_K + pixel];
    var left = select(own, K, own == 0u);
    for (var word = 0u; word < MASK_WORDS; word++) {
        var bits = atomicLoad(&pixels[pixel].mask[word]);
        while bits != 0u {
            left -= 1u;
            if left == 0u {
                emit(Key(0u, end_of(near, far, 32u * word + countTrailingZeros(bits))));
                return;
            }
            bits &= bits - 1u;
        }
    }
}
