// The store pass of the dynamic fragment buffer: unlike in the S-buffer, the counter is not zeroed, but counted down
// again, so that a range is filled from its end. A pixel's fragments are sorted in a local array of 1,024 records;
// further fragments of a pixel are dropped by arrival.
//
// The method declares the frame's words, as parts/ranges says.

//# include shared/fragment
//# include parts/ranges

// Records that resolve can sort.
const MOST: u32 = 1024u;

struct Pixel {
    // Fragments counted; then, fragments still to come.
    counter: atomic<u32>,
    // Records of the pixel, for resolve.
    length: u32,
    offset: u32,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;

fn clear_counter(pixel: u32) {
    atomicStore(&pixels[pixel].counter, 0u);
    pixels[pixel].length = 0u;
}

fn count_fragment(pixel: u32) {
    atomicAdd(&pixels[pixel].counter, 1u);
}

fn refer_counted(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    if count > 0u {
        refer(pixel, count, false);
        pixels[pixel].length = count;
    }
}

// Where a fragment is stored, if its outcome is KEPT.
struct Place {
    record: u32,
    outcome: u32,
}

fn next_place(pixel: u32) -> Place {
    let left = atomicSub(&pixels[pixel].counter, 1u);
    let index = left - 1u;
    // The last to arrive find the local array full: the range is filled from its end.
    let place = pixels[pixel].length - left;
    if place >= MOST {
        return Place(0u, OVERFLOW);
    }
    let start = range_of(pixel).start;
    // Avoids the sum of both, which wraps for a fragment that was not counted.
    if index >= BOUNDED - min(start, BOUNDED) {
        return Place(0u, POOL);
    }
    return Place(start + index, KEPT);
}

// The first of a pixel's records, and the end.
fn records_of(pixel: u32) -> vec2<u32> {
    let length = pixels[pixel].length;
    if length == 0u {
        return vec2<u32>(0u);
    }
    let end = range_of(pixel).start + length;
    return vec2<u32>(end - min(length, MOST), min(end, BOUNDED));
}
