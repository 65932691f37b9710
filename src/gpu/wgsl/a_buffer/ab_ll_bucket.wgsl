// A-buffer in per-pixel linked lists, one for each of four depth buckets (Vasilakis, Fudos 2013).
//
// A first geometry pass finds each pixel's depth range. The store pass divides the range uniformly, and puts every
// fragment into the list of its bucket: invocations of a pixel contend for four heads instead of one.

//# include shared/fragment
//# include parts/list
//# include parts/buckets
//# include shared/emit

struct Pixel {
    near: atomic<u32>,
    far: atomic<u32>,
    heads: array<atomic<u32>, BUCKETS>,
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
    atomicStore(&pixels[pixel].near, EMPTY);
    atomicStore(&pixels[pixel].far, 0u);
    for (var bucket = 0u; bucket < BUCKETS; bucket++) {
        atomicStore(&pixels[pixel].heads[bucket], NONE);
    }
}

// The depth range.
fn prepare(fragment: Fragment) {
    atomicMin(&pixels[fragment.pixel].near, fragment.depth);
    atomicMax(&pixels[fragment.pixel].far, fragment.depth);
}

fn store(fragment: Fragment) -> u32 {
    let node = atomicAdd(&nodes.taken, 1u);
    if node >= GENERATED {
        return POOL;
    }
    let near = atomicLoad(&pixels[fragment.pixel].near);
    let far = atomicLoad(&pixels[fragment.pixel].far);
    let bucket = bucket_of(fragment.depth, near, far);
    keys[node] = key_of(fragment);
    nodes.links[node] = atomicExchange(&pixels[fragment.pixel].heads[bucket], node);
    return KEPT;
}

fn resolve(pixel: u32) {
    for (var bucket = 0u; bucket < BUCKETS; bucket++) {
        var node = atomicLoad(&pixels[pixel].heads[bucket]);
        for (var i = 0u; i < GENERATED && node < GENERATED; i++) {
            emit(keys[node]);
            node = nodes.links[node];
        }
    }
}
