// A-buffer in doubly linked lists: `ab_ll`, with the way back.
//
// A new node is the first, and says that it has no previous one before it is published. The old head learns of its
// previous afterwards, from the invocation that displaced it. Two invocations write that word, one after the other, and
// WGSL, whose atomics are relaxed, does not guarantee which write lands last.
//
// Resolve walks to the end by `links`, and collects on the way back by `previous`.

//# include shared/fragment
//# include parts/list
//# include shared/emit

struct Pixel {
    head: atomic<u32>,
}

struct Frame {
    taken: atomic<u32>,
    links: array<u32, GENERATED_ROOM>,
    previous: array<u32>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(2) var<storage, read_write> nodes: Frame;
@group(0) @binding(3) var<storage, read_write> keys: array<Key>;

fn clear_frame() {
    atomicStore(&nodes.taken, 0u);
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].head, NONE);
}

fn store(fragment: Fragment) -> u32 {
    let node = atomicAdd(&nodes.taken, 1u);
    if node >= GENERATED {
        return POOL;
    }
    keys[node] = key_of(fragment);
    nodes.previous[node] = NONE;
    let next = atomicExchange(&pixels[fragment.pixel].head, node);
    nodes.links[node] = next;
    if next != NONE {
        nodes.previous[next] = node;
    }
    return KEPT;
}

// What memory holds may lead in a circle, if its order was not kept: neither way is longer than the pool.
fn resolve(pixel: u32) {
    var node = atomicLoad(&pixels[pixel].head);
    var last = NONE;
    for (var i = 0u; i < GENERATED && node < GENERATED; i++) {
        last = node;
        node = nodes.links[node];
    }
    for (var i = 0u; i < GENERATED && last < GENERATED; i++) {
        emit(keys[last]);
        last = nodes.previous[last];
    }
}
