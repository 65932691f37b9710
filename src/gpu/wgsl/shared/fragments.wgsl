// The fragments of a geometry pass on the compute path, in the order that the host chose.
@group(1) @binding(0) var<storage, read_write> fragments: array<Fragment>;
