// S-buffer (Vasilakis, Fudos 2012; SB): count, prefix sum, store into exact contiguous ranges.
//
// A first geometry pass counts every pixel's fragments; sums turn counts into starts; a second one stores, with the
// pixel's counter, zeroed again, as its index. Both passes must generate the same fragments.

//# include shared/fragment
//# include parts/ranges
//# include shared/emit

struct Pixel {
    counter: atomic<u32>,
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
}

fn prepare(fragment: Fragment) {
    atomicAdd(&pixels[fragment.pixel].counter, 1u);
}

fn screen(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    if count > 0u {
        refer(pixel, count, false);
        atomicStore(&pixels[pixel].counter, 0u);
    }
}

fn frame(number: u32, index: u32) {
    sum_up(number, index);
}

fn store(fragment: Fragment) -> u32 {
    let index = atomicAdd(&pixels[fragment.pixel].counter, 1u);
    let record = range_of(fragment.pixel).start + index;
    if record >= GENERATED {
        return POOL;
    }
    records[record] = key_of(fragment);
    return KEPT;
}

fn resolve(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    if count > 0u {
        let start = range_of(pixel).start;
        for (var record = start; record < min(start + count, GENERATED); record++) {
            emit(records[record]);
        }
    }
}
