// Records of merged slabs: sums of whole numbers, which do not depend on the order in which fragments come in. A slab
// reaches from its depth towards the eye, to its near end. Every sum stops at its largest value instead of wrapping.

//# include shared/emit

struct Merged {
    // The depth words of its ends.
    near: u32,
    depth: u32,
    // Two sums each, the first in the lower half: of a r and a g, of a b and a, and of -log2(1 - a) and 1. The bytes of
    // a fragment's colour word are r, g, b and a.
    rg: vec2<u32>,
    ba: vec2<u32>,
    log: vec2<u32>,
}

// -log2(1 - a) of every opacity byte, four to a vector, with 24 bits after the point.
@group(0) @binding(4) var<uniform> logarithms: array<vec4<u32>, 64>;

// A fragment's slab.
fn alone(near: u32, depth: u32, data: u32) -> Merged {
    let a = data >> 24u;
    let rg = vec2<u32>(data & 0xFFu, (data >> 8u) & 0xFFu);
    let ba = vec2<u32>((data >> 16u) & 0xFFu, 1u);
    return Merged(near, depth, a * rg, a * ba, vec2<u32>(logarithms[a / 4u][a % 4u], 1u));
}

fn saturating_add(a: vec2<u32>, b: vec2<u32>) -> vec2<u32> {
    let sum = a + b;
    return select(sum, vec2<u32>(0xFFFFFFFFu), sum < a);
}

// Both as one.
fn joined(a: Merged, b: Merged) -> Merged {
    return Merged(
        min(a.near, b.near),
        max(a.depth, b.depth),
        saturating_add(a.rg, b.rg),
        saturating_add(a.ba, b.ba),
        saturating_add(a.log, b.log),
    );
}

// The colour word of a record of one fragment, to distinguish what is farther at equal depth; of others, all ones.
fn word_of_record(record: Merged) -> u32 {
    let a = record.ba.y;
    if record.log.y != 1u {
        return 0xFFFFFFFFu;
    }
    if a == 0u {
        return 0u;
    }
    let rg = record.rg / a;
    return rg.x | (rg.y << 8u) | ((record.ba.x / a) << 16u) | (a << 24u);
}

// What comes first is nearer: by depth, then by colour word, then by the near end.
fn is_nearer(a: Merged, b: Merged) -> bool {
    if a.depth != b.depth {
        return a.depth < b.depth;
    }
    let words = vec2<u32>(word_of_record(a), word_of_record(b));
    return words.x < words.y || (words.x == words.y && a.near < b.near);
}

// A record leaves as four words: its ends, and its sums.
fn emit_merged(record: Merged) {
    emit(Key(record.near, record.depth));
    emit(record.rg);
    emit(record.ba);
    emit(record.log);
}
