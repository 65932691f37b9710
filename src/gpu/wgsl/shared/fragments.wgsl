// The fragments of a geometry pass on the compute path, in the order in which the host wants them.
@group(1) @binding(0) var<storage, read_write> fragments: array<Fragment>;
