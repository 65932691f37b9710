// Stochastic transparency (Enderton, Sintorn, Shirley, Luebke 2010), with the exact alpha: a fragment covers a share of
// its pixel's samples, opaquely; and the transmittance of all fragments is a sum of logarithms.
//
// Which samples a fragment covers is a hash of its triangle, its pixel and the seed, in integers: the same bits as in the
// simulator. A sample keeps its nearest fragment by a 64-bit atomic minimum. WGSL has none: it is an extension of
// naga's. The sum of logarithms needs no 64-bit addition: it is two words with a carry.
//
// Resolve emits the pixel's words, and the host takes the colour from them.

//# include shared/fragment
//# include shared/word64
//# include shared/emit
//# include shared/grid
//# include approximate/random
//# include approximate/table

struct Pixel {
    nearest: array<atomic<u64>, SAMPLES>,
    // The sum of -log2(1 - a), 32 bits after the point; the highest bit is set by an opaque fragment.
    passing: array<atomic<u32>, 2>,
}

@group(0) @binding(1) var<storage, read_write> pixels: array<Pixel>;

// A sample that no fragment covers.
const NONE: u64 = 0xFFFFFFFFFFFFFFFFlu;

// The stream of the random numbers.
const STREAM: u32 = 0x5A3Bu;

const OPAQUE: u32 = 0x80000000u;

fn clear(pixel: u32) {
    for (var i = 0u; i < SAMPLES; i++) {
        atomicStore(&pixels[pixel].nearest[i], NONE);
    }
    atomicStore(&pixels[pixel].passing[0], 0u);
    atomicStore(&pixels[pixel].passing[1], 0u);
}

// Where the random numbers of a fragment begin.
fn base_of(fragment: Fragment) -> Wide {
    let place = place_of(fragment.pixel);
    let stream = mix64(wide_add(mix64(Wide(SEED_LOW, SEED_HIGH)), Wide(STREAM, 0u)));
    let of_pixel = mix64(wide_add(stream, Wide(place.x, place.y)));
    return mix64(wide_add(mix64(of_pixel), Wide(fragment.extra, 0u)));
}

fn add_passing(pixel: u32, alpha: u32) {
    if alpha == 255u {
        atomicOr(&pixels[pixel].passing[1], OPAQUE);
        return;
    }
    let term = number_of(alpha);
    let old = atomicAdd(&pixels[pixel].passing[0], term.x);
    // An addition that wraps the lower word adds 1 to the upper one. The order does not matter: in the end, the sum is right.
    let upper = term.y + u32(old + term.x < old);
    if upper > 0u {
        atomicAdd(&pixels[pixel].passing[1], upper);
    }
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    let alpha = fragment.data >> 24u;
    let base = base_of(fragment);
    let covered = SAMPLES * alpha;
    var left = covered / 255u + u32(below(mix64(base), 255u) < covered % 255u);
    let own = word_of(key_of(fragment));
    // Every set of that size is as likely as every other (Knuth, TAOCP 2, 3.4.2, algorithm S).
    for (var i = 0u; i < SAMPLES; i++) {
        if below(mix64(wide_add(base, Wide(i + 1u, 0u))), SAMPLES - i) < left {
            atomicMin(&pixels[pixel].nearest[i], own);
            left -= 1u;
        }
    }
    add_passing(pixel, alpha);
    return MERGED;
}

fn resolve(pixel: u32) {
    for (var i = 0u; i < SAMPLES; i++) {
        emit(key_in(atomicLoad(&pixels[pixel].nearest[i])));
    }
    emit(Key(atomicLoad(&pixels[pixel].passing[0]), atomicLoad(&pixels[pixel].passing[1])));
}
