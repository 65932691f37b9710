// A-buffer in per-pixel linked lists of pages (Crassin 2010; LL-Paged).
//
// A page holds four fragments, so that a pixel asks the frame's counter a quarter as often and its fragments lie
// together. Slots are handed out under a lock per pixel. The record itself is written after the lock is free again: its
// slot belongs to no other invocation, and none reads it before the barrier. Counter and page are read by the lock's
// next holder; WGSL's relaxed atomics do not guarantee that it sees them: see parts/lock.

//# include shared/fragment
//# include parts/list
//# include parts/lock
//# include reach/pages
//# include shared/emit

// Fragments of a page.
const PAGE: u32 = 4u;

// Words of a page: which page comes next, then depth and data of each fragment.
const WORDS: u32 = 1u + 2u * PAGE;

struct Pixel {
    lock: atomic<u32>,
    counter: Word,
    page: Word,
}

struct Frame {
    taken: atomic<u32>,
    pages: array<u32>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(2) var<storage, read_write> memory: Frame;

// The first word of a page.
fn first_of(page: u32) -> u32 {
    return WORDS * page;
}

// The first word of a record of a page.
fn record_of(page: u32, slot: u32) -> u32 {
    return first_of(page) + 1u + 2u * slot;
}

fn clear_frame() {
    atomicStore(&memory.taken, 0u);
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
    empty(pixel);
}

// Under the lock: the first word of a record for one more fragment, or NONE if there is no page for it.
fn take(pixel: u32) -> u32 {
    let count = count_of(pixel);
    var page = page_of(pixel);
    if count % PAGE == 0u {
        let last = page;
        page = atomicAdd(&memory.taken, 1u);
        if page >= PAGES {
            return NONE;
        }
        memory.pages[first_of(page)] = last;
        set_page(pixel, page);
    }
    set_count(pixel, count + 1u);
    return record_of(page, count % PAGE);
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    var outcome = STUCK;
    for (var attempt = 0u; outcome == STUCK && attempt < PATIENCE; attempt++) {
        if acquire_lock(pixel) {
            let record = take(pixel);
            release_lock(pixel);
            outcome = POOL;
            if record != NONE {
                memory.pages[record] = fragment.depth;
                memory.pages[record + 1u] = fragment.data;
                outcome = KEPT;
            }
        }
    }
    return outcome;
}

fn resolve(pixel: u32) {
    // No pixel has more: a count that memory has made up must not hold the device up.
    var left = min(settled_count(pixel), GENERATED);
    var page = settled_page(pixel);
    // Only the current page can be partly full.
    while left > 0u && page != NONE {
        let full = (left - 1u) % PAGE + 1u;
        for (var slot = 0u; slot < full; slot++) {
            let record = record_of(page, slot);
            emit(Key(memory.pages[record + 1u], memory.pages[record]));
        }
        left -= full;
        page = memory.pages[first_of(page)];
    }
}
