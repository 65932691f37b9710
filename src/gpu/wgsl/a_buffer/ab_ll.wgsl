// A-buffer in per-pixel linked lists (Yang, Hensley, Grün, Thibieroz 2010).
//
// A counter hands out nodes; an exchange on the pixel's head publishes a node, whose link is written afterwards. That
// is harmless: no invocation reads a node before the barrier.

//# include shared/fragment
//# include parts/list
//# include shared/emit

struct Pixel {
    head: atomic<u32>,
}

struct Frame {
    taken: atomic<u32>,
    links: array<u32>,
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
    nodes.links[node] = atomicExchange(&pixels[fragment.pixel].head, node);
    return KEPT;
}

fn resolve(pixel: u32) {
    var node = atomicLoad(&pixels[pixel].head);
    // No list is longer: one that memory has made a ring of must not hold the device up.
    for (var left = GENERATED; node != NONE && left > 0u; left--) {
        emit(keys[node]);
        node = nodes.links[node];
    }
}
