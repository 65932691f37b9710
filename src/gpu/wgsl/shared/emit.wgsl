// A method calls `emit` for each of a pixel's records, in any order.

//# include shared/rays

fn emit(key: Key) {
    if ray.count < ray.room {
        lists[ray.start + ray.count] = key;
    }
    ray.count += 1u;
}
