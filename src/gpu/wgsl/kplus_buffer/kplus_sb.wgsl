// k+-buffer with exact memory (Vasilakis, Fudos 2014, section 3.3; K+B-SB), in its correct form.
//
// A bounded count, a prefix sum, and per pixel a max-array or a max-heap in a contiguous range of min(f, k) records. A
// pixel with more than k fragments has a heap if k > 16, and an array otherwise.
//
// A compare-exchange counts to min(f, k + 1): the published test and add overshoots if several invocations pass the
// test together, and a count bounded at k cannot distinguish f = k from f > k. The choice is the lowest bit of the
// range's start. What the lock needs is outside WGSL's guarantees: see parts/lock.

//# include shared/fragment
//# include parts/lock
//# include parts/locked_row
//# include shared/emit

// A compare-exchange fails because another invocation counted, which changes the counter. If the counter did not
// change, it failed spuriously, as WGSL allows, or this lane is a helper of a quad, whose atomics do nothing. That may
// happen this often.
const FUTILE: u32 = 64u;

struct Pixel {
    lock: atomic<u32>,
    counter: atomic<u32>,
    offset: u32,
}

struct Frame {
    blocks: array<atomic<u32>, BLOCKS>,
    groups: array<u32, GROUPS>,
    depth: array<atomic<u32>, BOUNDED_ROOM>,
    data: array<Word>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(2) var<storage, read_write> memory: Frame;

fn clear_frame() {
    clear_sums();
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
    atomicStore(&pixels[pixel].counter, 0u);
}

// The count pass.
fn prepare(fragment: Fragment) {
    var last = EMPTY;
    var futile = 0u;
    while futile < FUTILE {
        let count = atomicLoad(&pixels[fragment.pixel].counter);
        if count > K {
            return;
        }
        futile += u32(count == last);
        last = count;
        if atomicCompareExchangeWeak(&pixels[fragment.pixel].counter, count, count + 1u).exchanged {
            return;
        }
    }
}

// The referencing pass.
fn screen(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    if count > 0u {
        refer(pixel, min(count, K), count > K);
        atomicStore(&pixels[pixel].counter, 0u);
    }
}

fn frame(number: u32, index: u32) {
    sum_up(number, index);
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    let range = range_of(pixel);
    if acquire_count(pixel) == K && fragment.depth > farthest_of(range.start) {
        return CULLED;
    }
    var outcome = STUCK;
    for (var attempt = 0u; outcome == STUCK && attempt < PATIENCE; attempt++) {
        if acquire_lock(pixel) {
            outcome = insert(pixel, range, K, key_of(fragment));
            release_lock(pixel);
        }
    }
    return outcome;
}

fn resolve(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    if count > 0u {
        let first = range_of(pixel).start;
        for (var i = 0u; i < count; i++) {
            emit(settled(first, i));
        }
    }
}
