// Merging in resolve: a dynamic fragment buffer with the near end of every slab ("Fragment merging with z-thickness",
// 2021; the components of the overlap are ours).
//
// Slabs that overlap, or are linked by others that do, are one component. Resolve gives the nearest k - 1 components,
// and the rest as a tail. It sorts a pixel's records in place: thick slabs by their near ends, and behind them the
// surfaces, which overlap nothing. Components of thick slabs then come out one after another, each behind the one
// before; so do surfaces; and the nearer of both is next.

//# include parts/counted_down
//# include parts/merged

struct Frame {
    blocks: array<atomic<u32>, BLOCKS>,
    groups: array<u32, GROUPS>,
    near: array<u32>,
}

@group(0) @binding(2) var<storage, read_write> memory: Frame;
@group(0) @binding(3) var<storage, read_write> records: array<Key>;

fn clear_frame() {
    clear_sums();
}

fn clear(pixel: u32) {
    clear_counter(pixel);
}

fn prepare(fragment: Fragment) {
    count_fragment(fragment.pixel);
}

fn screen(pixel: u32) {
    refer_counted(pixel);
}

fn frame(number: u32, index: u32) {
    sum_up(number, index);
}

fn store(fragment: Fragment) -> u32 {
    let place = next_place(fragment.pixel);
    if place.outcome == KEPT {
        records[place.record] = key_of(fragment);
        memory.near[place.record] = fragment.extra;
    }
    return place.outcome;
}

struct Slab {
    key: Key,
    near: u32,
}

fn slab_at(record: u32) -> Slab {
    return Slab(records[record], memory.near[record]);
}

fn put_slab(record: u32, slab: Slab) {
    records[record] = slab.key;
    memory.near[record] = slab.near;
}

fn is_thick(slab: Slab) -> bool {
    return slab.near < slab.key.y;
}

fn is_before(a: Slab, b: Slab) -> bool {
    if is_thick(a) != is_thick(b) {
        return is_thick(a);
    }
    if is_thick(a) && a.near != b.near {
        return a.near < b.near;
    }
    return is_less(a.key, b.key);
}

// Shell sort of the records from `begin` up to `end`.
fn sort_slabs(begin: u32, end: u32) {
    for (var gap = (end - begin) / 2u; gap > 0u; gap /= 2u) {
        for (var i = begin + gap; i < end; i++) {
            let slab = slab_at(i);
            var place = i;
            while place >= begin + gap && is_before(slab, slab_at(place - gap)) {
                put_slab(place, slab_at(place - gap));
                place -= gap;
            }
            put_slab(place, slab);
        }
    }
}

fn alone_at(record: u32) -> Merged {
    let slab = slab_at(record);
    return alone(slab.near, slab.key.y, slab.key.x);
}

fn resolve(pixel: u32) {
    let ends = records_of(pixel);
    sort_slabs(ends.x, ends.y);
    var middle = ends.x;
    while middle < ends.y && is_thick(slab_at(middle)) {
        middle += 1u;
    }
    var thick = ends.x;
    var surface = middle;
    var emitted = 0u;
    var tail: Merged;
    while thick < middle || surface < ends.y {
        var next: Merged;
        var behind = thick;
        if thick < middle {
            next = alone_at(thick);
            for (behind += 1u; behind < middle && memory.near[behind] < next.depth; behind++) {
                next = joined(next, alone_at(behind));
            }
        }
        if thick == middle || (surface < ends.y && is_nearer(alone_at(surface), next)) {
            next = alone_at(surface);
            surface += 1u;
        } else {
            thick = behind;
        }
        if emitted < K - 1u {
            emit_merged(next);
        } else if emitted == K - 1u {
            tail = next;
        } else {
            tail = joined(tail, next);
        }
        emitted += 1u;
    }
    if emitted >= K {
        emit_merged(tail);
    }
}
