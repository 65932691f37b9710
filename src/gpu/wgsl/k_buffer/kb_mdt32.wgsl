// Multi depth test with 32-bit atomics, as published (Liu, Huang, Liu, Wu 2010; Maule, Comba, Torchelsen, Bastos 2013;
// KB-MDT): two geometry passes.
//
// The first lowers k depth words by atomic minima, each passing on what it gives up; in the second, every fragment
// looks for its depth among them and writes its data there. Of several fragments with the same depth, each writes into
// every entry that matches: the last one represents all. Depths have 24 bits, which makes equal ones more frequent.

//# include shared/fragment
//# include shared/emit

struct Pixel {
    depth: array<atomic<u32>, K>,
    data: array<atomic<u32>, K>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;

fn clear(pixel: u32) {
    for (var i = 0u; i < K; i++) {
        atomicStore(&pixels[pixel].depth[i], EMPTY);
    }
}

fn prepare(fragment: Fragment) {
    var carried = fragment.depth;
    for (var i = 0u; i < K; i++) {
        carried = max(carried, atomicMin(&pixels[fragment.pixel].depth[i], carried));
        if carried == EMPTY {
            return;
        }
    }
}

fn store(fragment: Fragment) -> u32 {
    var outcome = CULLED;
    for (var i = 0u; i < K; i++) {
        let depth = atomicLoad(&pixels[fragment.pixel].depth[i]);
        if depth > fragment.depth {
            break;
        }
        if depth == fragment.depth {
            atomicStore(&pixels[fragment.pixel].data[i], fragment.data);
            outcome = KEPT;
        }
    }
    return outcome;
}

fn resolve(pixel: u32) {
    for (var i = 0u; i < K; i++) {
        let depth = atomicLoad(&pixels[pixel].depth[i]);
        if depth == EMPTY {
            return;
        }
        emit(Key(atomicLoad(&pixels[pixel].data[i]), depth));
    }
}
