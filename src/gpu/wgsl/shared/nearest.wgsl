// The K nearest of the records that a pixel has. It takes the place of shared/emit: the records so far are in order,
// each new one goes to its place, and the farthest of more than K goes.

//# include shared/rays

fn emit(key: Key) {
    var carried = key;
    let held = min(ray.count, ray.room);
    for (var i = 0u; i < held; i++) {
        let other = lists[ray.start + i];
        if is_less(carried, other) {
            lists[ray.start + i] = carried;
            carried = other;
        }
    }
    if ray.count < K {
        if ray.count < ray.room {
            lists[ray.start + ray.count] = carried;
        }
        ray.count += 1u;
    }
}
