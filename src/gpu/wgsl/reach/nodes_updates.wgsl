// How kb_ll reaches its nodes in a form where every access to one is an update: see reach/updates.
//
// Heads are read by loads: a head that is stale is a node behind the first, from which a walk finds no node too many.

//# include reach/updates

struct Frame {
    taken: atomic<u32>,
    links: array<atomic<u32>, GENERATED_ROOM>,
    depth: array<atomic<u32>, GENERATED_ROOM>,
    data: array<atomic<u32>>,
}

@group(0) @binding(2) var<storage, read_write> nodes: Frame;

fn key_of_node(node: u32) -> Key {
    return Key(got(atomicOr(&nodes.data[node], 0u)), got(atomicOr(&nodes.depth[node], 0u)));
}

// The same after a barrier.
fn settled_key(node: u32) -> Key {
    return Key(atomicLoad(&nodes.data[node]), atomicLoad(&nodes.depth[node]));
}

fn set_key(node: u32, key: Key) {
    got(atomicExchange(&nodes.depth[node], key.y));
    got(atomicExchange(&nodes.data[node], key.x));
}

fn acquire_link(node: u32) -> u32 {
    return got(atomicOr(&nodes.links[node], 0u));
}

fn set_link(node: u32, next: u32) {
    got(atomicExchange(&nodes.links[node], next));
}

// The number of a node that is complete.
fn complete(pixel: u32, node: u32) -> u32 {
    return node | (given & never(pixel));
}
