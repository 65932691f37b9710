//# include pass/raster

// Invocations that gave up waiting, for a lock or for a compare-exchange: the host reruns them on the compute path.
struct GivenUp {
    count: atomic<u32>,
    fragments: array<Fragment>,
}

@group(1) @binding(0) var<storage, read_write> given_up: GivenUp;

@fragment
fn store_raster(corner: Corner) {
    var fragment = fragment_of(corner);
    fragment.outcome = store(fragment);
    if fragment.outcome == STUCK {
        let place = atomicAdd(&given_up.count, 1u);
        if place < arrayLength(&given_up.fragments) {
            given_up.fragments[place] = fragment;
        }
    }
}
