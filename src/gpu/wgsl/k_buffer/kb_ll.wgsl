// k-buffer in a depth-sorted linked list per pixel (Yu, Yang, Hensley, Harada, Yu 2012; KB-LL).
//
// A fragment walks its pixel's list from the front. Behind k nodes it is culled; otherwise its node goes before the
// first that is farther, by a compare-exchange on its predecessor's link. Nodes never leave the list, they only fall
// behind the k-th, where resolve does not look: so an invocation that loses a compare-exchange goes on from where it
// is.
//
// Walkers read nodes while others insert, and a node is complete before the compare-exchange that publishes it. WGSL
// does not guarantee that they see it complete: its atomics are relaxed, and keys are plain words.

//# include shared/fragment
//# include parts/list
//# include reach/nodes
//# include shared/emit

// A compare-exchange fails because another invocation got in, which changes the link. If the link did not change, it
// failed spuriously, as WGSL allows, or this lane is a helper of a quad, whose atomics do nothing. That may happen this
// often.
const FUTILE: u32 = 64u;

struct Pixel {
    head: atomic<u32>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;

fn clear_frame() {
    atomicStore(&nodes.taken, 0u);
}

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].head, NONE);
}

// The node behind `previous`, or the first one if that is NONE.
fn acquire_next(pixel: u32, previous: u32) -> u32 {
    if previous == NONE {
        return atomicLoad(&pixels[pixel].head);
    }
    return acquire_link(previous);
}

// Put the node `own` between `previous` and `next`, if they are still neighbours.
fn release_own(pixel: u32, previous: u32, next: u32, own: u32) -> bool {
    if previous == NONE {
        return atomicCompareExchangeWeak(&pixels[pixel].head, next, own).exchanged;
    }
    return atomicCompareExchangeWeak(&nodes.links[previous], next, own).exchanged;
}

fn store(fragment: Fragment) -> u32 {
    let key = key_of(fragment);
    var previous = NONE;
    var nearer = 0u;
    var own = NONE;
    var failed = false;
    var last = NONE;
    var futile = 0u;
    while futile < FUTILE {
        let next = acquire_next(fragment.pixel, previous);
        futile += u32(failed && next == last);
        failed = false;
        if next != NONE && !is_less(key, key_of_node(next)) {
            previous = next;
            nearer += 1u;
            if nearer == K {
                return CULLED;
            }
        } else {
            if own == NONE {
                own = atomicAdd(&nodes.taken, 1u);
                if own >= GENERATED {
                    return POOL;
                }
                set_key(own, key);
            }
            set_link(own, next);
            if release_own(fragment.pixel, previous, next, complete(fragment.pixel, own)) {
                return KEPT;
            }
            failed = true;
            last = next;
        }
    }
    return STUCK;
}

fn resolve(pixel: u32) {
    var node = atomicLoad(&pixels[pixel].head);
    for (var i = 0u; i < K && node != NONE; i++) {
        emit(settled_key(node));
        node = atomicLoad(&nodes.links[node]);
    }
}
