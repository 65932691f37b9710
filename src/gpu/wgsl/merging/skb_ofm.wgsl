// Merging on arrival: a k+-buffer whose records are slabs ("Fragment merging with z-thickness", 2021; S-KB with
// order-independent merging).
//
// Under its pixel's lock, a fragment is merged with every record that its slab overlaps; these become one. If there is
// none, it becomes a record of its own. The last of the k records is the tail: where the others are taken, the farthest
// goes into it, or the fragment itself. What the lock needs is outside WGSL's guarantees: see parts/lock.

//# include shared/fragment
//# include parts/lock
//# include parts/merged

struct Pixel {
    lock: atomic<u32>,
    count: u32,
    // The farthest depth of k - 1 records; EMPTY or AGAIN while there are fewer.
    bound: u32,
    near: array<u32, K>,
    depth: array<u32, K>,
}

// The sums of k records: pairs, as they need no 64-bit arithmetic. Of a record of one fragment, the last pair is its
// colour word and 1, and the others are not read.
struct Sums {
    words: array<vec2<u32>, 2u * K>,
    last: array<vec2<u32>, K>,
}

// The records besides the tail, which is the last one.
const TAIL: u32 = K - 1u;

// No record.
const NONE: u32 = 0xFFFFFFFFu;

// While there is room again: something may be in the tail.
const AGAIN: u32 = EMPTY - 1u;

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(1) var<storage, read_write> sums: array<Sums>;

fn record_at(pixel: u32, i: u32) -> Merged {
    let last = sums[pixel].last[i];
    if last.y == 1u {
        return alone(pixels[pixel].near[i], pixels[pixel].depth[i], last.x);
    }
    return Merged(
        pixels[pixel].near[i],
        pixels[pixel].depth[i],
        sums[pixel].words[2u * i],
        sums[pixel].words[2u * i + 1u],
        last,
    );
}

fn put(pixel: u32, i: u32, record: Merged) {
    pixels[pixel].near[i] = record.near;
    pixels[pixel].depth[i] = record.depth;
    sums[pixel].words[2u * i] = record.rg;
    sums[pixel].words[2u * i + 1u] = record.ba;
    var last = record.log;
    if last.y == 1u {
        last.x = word_of_record(record);
    }
    sums[pixel].last[i] = last;
}

fn has_tail(pixel: u32) -> bool {
    return any(sums[pixel].last[TAIL] != vec2<u32>(0u));
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
    pixels[pixel].count = 0u;
    pixels[pixel].bound = EMPTY;
    sums[pixel].last[TAIL] = vec2<u32>(0u);
}

// Whether a slab overlaps any of the first records. A surface overlaps nothing.
fn overlaps(pixel: u32, count: u32, near: u32, depth: u32) -> bool {
    if near == depth {
        return false;
    }
    for (var i = 0u; i < count; i++) {
        let far = pixels[pixel].depth[i];
        if far > near && max(pixels[pixel].near[i], near) < min(far, depth) {
            return true;
        }
    }
    return false;
}

fn into_tail(pixel: u32, record: Merged) {
    var tail = record;
    if has_tail(pixel) {
        tail = joined(record_at(pixel, TAIL), record);
    }
    put(pixel, TAIL, tail);
}

// Under the lock.
fn insert(pixel: u32, own: Merged, data: u32) {
    let bound = pixels[pixel].bound;
    if K == 1u || (own.near >= bound && own.depth > bound) {
        into_tail(pixel, own);
        return;
    }
    var count = pixels[pixel].count;
    // The farthest counts only where there is no room left, now or after this fragment.
    let fills = count + 1u >= TAIL;
    // Most fragments lie apart, and there is room: they take a short way.
    if count < TAIL && bound == EMPTY && !overlaps(pixel, count, own.near, own.depth) {
        pixels[pixel].near[count] = own.near;
        pixels[pixel].depth[count] = own.depth;
        // What cannot be seen has no colour, as in the sums.
        sums[pixel].last[count] = vec2<u32>(select(data, 0u, data < 0x1000000u), 1u);
        pixels[pixel].count = count + 1u;
        if fills {
            var farthest = own.depth;
            for (var i = 0u; i < count; i++) {
                farthest = max(farthest, pixels[pixel].depth[i]);
            }
            pixels[pixel].bound = farthest;
        }
        return;
    }
    var record = own;
    var place = NONE;
    // The farthest record and its depth, and the depth of the next but one.
    var farthest = NONE;
    var first = 0u;
    var second = 0u;
    var i = 0u;
    while i < count {
        let depth = pixels[pixel].depth[i];
        if depth > own.near && max(pixels[pixel].near[i], own.near) < min(depth, own.depth) {
            record = joined(record_at(pixel, i), record);
            if place == NONE {
                place = i;
                i += 1u;
            } else {
                // Two records become one: the last takes the free place, and is looked at next.
                count -= 1u;
                if i < count {
                    put(pixel, i, record_at(pixel, count));
                }
            }
            continue;
        }
        var farther = farthest == NONE || depth > first;
        if !farther && depth == first {
            farther = is_nearer(record_at(pixel, farthest), record_at(pixel, i));
        }
        if farther {
            farthest = i;
            second = first;
            first = depth;
        } else {
            second = max(second, depth);
        }
        i += 1u;
    }
    if place == NONE && count < TAIL {
        if bound != EMPTY && has_tail(pixel) && own.depth > pixels[pixel].near[TAIL] {
            into_tail(pixel, own);
            return;
        }
        place = count;
        count += 1u;
    } else if place == NONE {
        let last = record_at(pixel, farthest);
        if !is_nearer(own, last) {
            into_tail(pixel, own);
            return;
        }
        into_tail(pixel, last);
        place = farthest;
        first = second;
    }
    put(pixel, place, record);
    pixels[pixel].count = count;
    if count == TAIL {
        pixels[pixel].bound = max(first, record.depth);
    } else if bound != EMPTY {
        pixels[pixel].bound = AGAIN;
    }
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    var outcome = STUCK;
    for (var attempt = 0u; outcome == STUCK && attempt < PATIENCE; attempt++) {
        if acquire_lock(pixel) {
            insert(pixel, alone(fragment.extra, fragment.depth, fragment.data), fragment.data);
            outcome = KEPT;
            release_lock(pixel);
        }
    }
    return outcome;
}

fn resolve(pixel: u32) {
    let count = min(pixels[pixel].count, TAIL);
    for (var i = 0u; i < count; i++) {
        emit_merged(record_at(pixel, i));
    }
    if has_tail(pixel) {
        emit_merged(record_at(pixel, TAIL));
    }
}
