// How kb_ll reaches its nodes in a form where all words are atomic: relaxed loads and stores, which nothing orders.

struct Frame {
    taken: atomic<u32>,
    links: array<atomic<u32>, GENERATED_ROOM>,
    depth: array<atomic<u32>, GENERATED_ROOM>,
    data: array<atomic<u32>>,
}

@group(0) @binding(2) var<storage, read_write> nodes: Frame;

fn key_of_node(node: u32) -> Key {
    return Key(atomicLoad(&nodes.data[node]), atomicLoad(&nodes.depth[node]));
}

// The same after a barrier.
fn settled_key(node: u32) -> Key {
    return Key(atomicLoad(&nodes.data[node]), atomicLoad(&nodes.depth[node]));
}

fn set_key(node: u32, key: Key) {
    atomicStore(&nodes.depth[node], key.y);
    atomicStore(&nodes.data[node], key.x);
}

fn acquire_link(node: u32) -> u32 {
    return atomicLoad(&nodes.links[node]);
}

fn set_link(node: u32, next: u32) {
    atomicStore(&nodes.links[node], next);
}

// The number of a node that is complete.
fn complete(pixel: u32, node: u32) -> u32 {
    return node;
}
