// Contiguous ranges: where each pixel's records begin in one array (S-buffer: Vasilakis, Fudos 2012).
//
// A geometry pass has counted the fragments of every pixel. Then a prefix sum over non-empty pixels, in three steps:
//   per pixel       offset = atomicAdd(sum of its block of 8x8 pixels, count)
//   per 64 blocks   their sums become starts; their total is the group's sum
//   once            the groups' sums become starts
// A range begins at group + block + offset.
//
// The method declares the words: a plain `offset` of each of `pixels`, and in `memory` the frame's atomic `blocks` and
// plain `groups`.

// Pixels of a block, and blocks of a group.
const RADIX: u32 = 64u;

// The number of the pass over blocks; the one over groups is next.
const SUM_BLOCKS: u32 = 2u;

struct Range {
    start: u32,
    // The flag given with it.
    flag: bool,
}

fn clear_sums() {
    for (var block = 0u; block < BLOCKS; block++) {
        atomicStore(&memory.blocks[block], 0u);
    }
}

// In the full-screen pass, for a pixel with `count` records, at least one.
fn refer(pixel: u32, count: u32, flag: bool) {
    let offset = atomicAdd(&memory.blocks[pixel / RADIX], count);
    pixels[pixel].offset = (offset << 1u) | u32(flag);
}

fn sum_blocks(group: u32) {
    var start = 0u;
    let first = group * RADIX;
    for (var block = first; block < min(BLOCKS, first + RADIX); block++) {
        let sum = atomicLoad(&memory.blocks[block]);
        atomicStore(&memory.blocks[block], start);
        start += sum;
    }
    memory.groups[group] = start;
}

fn sum_groups() {
    var start = 0u;
    for (var group = 0u; group < GROUPS; group++) {
        let sum = memory.groups[group];
        memory.groups[group] = start;
        start += sum;
    }
}

// An invocation of the passes over the frame's words.
fn sum_up(number: u32, index: u32) {
    if number == SUM_BLOCKS {
        sum_blocks(index);
    } else {
        sum_groups();
    }
}

// Only for pixels that have records.
fn range_of(pixel: u32) -> Range {
    let offset = pixels[pixel].offset;
    let block = atomicLoad(&memory.blocks[pixel / RADIX]);
    let group = memory.groups[pixel / (RADIX * RADIX)];
    return Range(group + block + (offset >> 1u), (offset & 1u) == 1u);
}

// Write a pixel's start where its offset was, in a pass of its own. Only for pixels that have records.
fn place(pixel: u32) {
    let range = range_of(pixel);
    pixels[pixel].offset = (range.start << 1u) | u32(range.flag);
}

// After `place`.
fn placed(pixel: u32) -> Range {
    let offset = pixels[pixel].offset;
    return Range(offset >> 1u, (offset & 1u) == 1u);
}
