// Multi-layer alpha blending (Salvi, Vaidyanathan 2014): k nodes in depth order; where one too many comes, the last two
// become one, which keeps the nearer depth.
//
// A node is a fragment, and the light of what was put behind it since. Under its pixel's lock a fragment is compared and
// swapped from the front; what is left over goes behind the last node. All of it is integers. What the lock needs is
// outside WGSL's guarantees: see parts/lock.
//
// Resolve emits the pixel's words, and the host takes the colour from them.

//# include shared/fragment
//# include shared/emit
//# include parts/lock
//# include approximate/ray

struct Pixel {
    lock: atomic<u32>,
    count: u32,
    depth: array<u32, K>,
    data: array<u32, K>,
}

// What is behind each node: pairs, as they need no 64-bit arithmetic.
struct Behind {
    words: array<vec2<u32>, K>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(1) var<storage, read_write> behind: array<Behind>;

struct Node {
    key: Key,
    behind: Light,
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].lock, FREE);
    pixels[pixel].count = 0u;
}

fn node_at(pixel: u32, i: u32) -> Node {
    let key = Key(pixels[pixel].data[i], pixels[pixel].depth[i]);
    return Node(key, light_of(behind[pixel].words[i]));
}

fn put(pixel: u32, i: u32, node: Node) {
    pixels[pixel].depth[i] = node.key.y;
    pixels[pixel].data[i] = node.key.x;
    behind[pixel].words[i] = word_of_light(node.behind);
}

// A node with the next one behind it.
fn merged(node: Node, next: Node) -> Node {
    return Node(node.key, through(over(node.behind, next.key.x), next.behind));
}

// Under the lock.
fn insert(pixel: u32, key: Key) -> u32 {
    let count = pixels[pixel].count;
    var carried = Node(key, no_light());
    var last = carried;
    for (var i = 0u; i < count; i++) {
        let node = node_at(pixel, i);
        last = node;
        if is_less(carried.key, node.key) {
            last = carried;
            // The last of k nodes is written when it is merged.
            if i + 1u < K {
                put(pixel, i, carried);
            }
            carried = node;
        }
    }
    if count < K {
        put(pixel, count, carried);
        pixels[pixel].count = count + 1u;
        return KEPT;
    }
    put(pixel, K - 1u, merged(last, carried));
    return MERGED;
}

fn store(fragment: Fragment) -> u32 {
    let pixel = fragment.pixel;
    var outcome = STUCK;
    for (var attempt = 0u; outcome == STUCK && attempt < PATIENCE; attempt++) {
        if acquire_lock(pixel) {
            outcome = insert(pixel, key_of(fragment));
            release_lock(pixel);
        }
    }
    return outcome;
}

// A depth, or behind them a data word; 0 of a node that there is not.
fn word_at(pixel: u32, i: u32) -> u32 {
    if i % K >= pixels[pixel].count {
        return 0u;
    }
    if i < K {
        return pixels[pixel].depth[i];
    }
    return pixels[pixel].data[i - K];
}

fn resolve(pixel: u32) {
    let count = pixels[pixel].count;
    for (var i = 0u; i < K; i++) {
        if i < count {
            emit(behind[pixel].words[i]);
        } else {
            emit(Key(0u));
        }
    }
    emit(Key(atomicLoad(&pixels[pixel].lock), count));
    for (var i = 0u; i < 2u * K; i += 2u) {
        emit(Key(word_at(pixel, i), word_at(pixel, i + 1u)));
    }
}
