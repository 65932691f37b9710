// How kb_ll reaches its nodes: keys are plain, links atomic.

struct Frame {
    taken: atomic<u32>,
    links: array<atomic<u32>>,
}

@group(0) @binding(2) var<storage, read_write> nodes: Frame;
@group(0) @binding(3) var<storage, read_write> keys: array<Key>;

fn key_of_node(node: u32) -> Key {
    return keys[node];
}

fn settled_key(node: u32) -> Key {
    return keys[node];
}

fn set_key(node: u32, key: Key) {
    keys[node] = key;
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
