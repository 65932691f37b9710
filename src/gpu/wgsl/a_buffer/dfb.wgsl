// Dynamic fragment buffer (Maule, Comba, Torchelsen, Bastos 2012; DFB): count, prefix sum, store into exact ranges.
//
// Unlike in the S-buffer, the counter is not zeroed, but counted down again: the store pass fills a range from its end.
// A pixel's fragments are sorted in a local array of 1,024 records; further fragments of a pixel are dropped by
// arrival.

//# include shared/fragment
//# include parts/ranges
//# include shared/emit

// Records that resolve can sort.
const MOST: u32 = 1024u;

struct Pixel {
    // Fragments counted; then, fragments still to come.
    counter: atomic<u32>,
    // Records of the pixel, for resolve.
    length: u32,
    offset: u32,
}

struct Frame {
    blocks: array<atomic<u32>, BLOCKS>,
    groups: array<u32>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(2) var<storage, read_write> memory: Frame;
@group(0) @binding(3) var<storage, read_write> records: array<Key>;

fn clear_frame() {
    clear_sums();
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].counter, 0u);
    pixels[pixel].length = 0u;
}

fn prepare(fragment: Fragment) {
    atomicAdd(&pixels[fragment.pixel].counter, 1u);
}

fn screen(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    if count > 0u {
        refer(pixel, count, false);
        pixels[pixel].length = count;
    }
}

fn frame(number: u32, index: u32) {
    sum_up(number, index);
}

fn store(fragment: Fragment) -> u32 {
    let left = atomicSub(&pixels[fragment.pixel].counter, 1u);
    let index = left - 1u;
    // The last to arrive find the local array full: the range is filled from its end.
    let place = pixels[fragment.pixel].length - left;
    if place >= MOST {
        return OVERFLOW;
    }
    let start = range_of(fragment.pixel).start;
    // Avoids the sum of both, which wraps for a fragment that was not counted.
    if index >= BOUNDED - min(start, BOUNDED) {
        return POOL;
    }
    records[start + index] = key_of(fragment);
    return KEPT;
}

fn resolve(pixel: u32) {
    let length = pixels[pixel].length;
    if length > 0u {
        let end = range_of(pixel).start + length;
        for (var record = end - min(length, MOST); record < min(end, BOUNDED); record++) {
            emit(records[record]);
        }
    }
}
