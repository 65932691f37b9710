// A-buffer in fixed arrays (Liu, Huang, Liu, Wu 2010, FreePipe; Crassin 2010).
//
// An atomic counter per pixel hands out slots. The first that arrive stay; later ones are counted and dropped.

//# include shared/fragment
//# include shared/emit

struct Pixel {
    counter: atomic<u32>,
}

struct Records {
    slots: array<Key, SLOTS_ROOM>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(1) var<storage, read_write> records: array<Records>;

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].counter, 0u);
}

fn store(fragment: Fragment) -> u32 {
    let slot = atomicAdd(&pixels[fragment.pixel].counter, 1u);
    if slot >= SLOTS {
        return OVERFLOW;
    }
    records[fragment.pixel].slots[slot] = key_of(fragment);
    return KEPT;
}

fn resolve(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    for (var slot = 0u; slot < min(count, SLOTS); slot++) {
        emit(records[pixel].slots[slot]);
    }
}
