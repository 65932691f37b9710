// Counter-based random numbers, as the simulator has them (`num::random`): SplitMix64's finalizer, applied once to every
// word that goes in. 64-bit integers are pairs, as many devices have none.

//# include shared/wide

// The lower half of the product.
fn wide_multiply(a: Wide, b: Wide) -> Wide {
    let low = wide_product(a.x, b.x);
    return Wide(low.x, low.y + a.x * b.y + a.y * b.x);
}

// x ^ (x >> by), for a shift from 1 to 31.
fn wide_fold(x: Wide, by: u32) -> Wide {
    return x ^ Wide((x.x >> by) | (x.y << (32u - by)), x.y >> by);
}

fn mix64(word: Wide) -> Wide {
    var x = wide_add(word, Wide(0x7F4A7C15u, 0x9E3779B9u));
    x = wide_multiply(wide_fold(x, 30u), Wide(0x1CE4E5B9u, 0xBF58476Du));
    x = wide_multiply(wide_fold(x, 27u), Wide(0x133111EBu, 0x94D049BBu));
    return wide_fold(x, 31u);
}

// Random bits as a number below n: the upper 64 of the 96 bits of their product.
fn below(bits: Wide, n: u32) -> u32 {
    let low = wide_product(bits.x, n);
    return wide_add(wide_product(bits.y, n), Wide(low.y, 0u)).y;
}
