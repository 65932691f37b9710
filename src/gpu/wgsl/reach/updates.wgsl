// What the forms share whose every access under a lock is a read-modify-write (`METHOD@rmw`).
//
// An update reads the value directly before its own in its word's order, however relaxed. So none is stale, if no device
// performs the updates under a lock after the operation that frees it. Nothing in WGSL says so. The value that frees the
// lock, or that publishes a node, is therefore made of what all updates gave: it cannot be known before they are
// performed. `never` is 0, but no compiler sees that.

// What this invocation's updates gave.
var<private> given: u32;

fn got(old: u32) -> u32 {
    given |= old;
    return old;
}

fn never(pixel: u32) -> u32 {
    return 0u - u32(pixel >= arrayLength(&pixels));
}
