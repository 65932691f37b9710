// A bounded row of records behind a pixel's lock, for methods that give each pixel a row of its own length: a max-array,
// or a max-heap for more than ARRAY_UP_TO records where the range's flag says that there are more fragments.
//
// The method declares the words: an atomic `lock` and `counter` of each of `pixels`, and in `memory` the frame's atomic
// `depth`, and `data` of the kind Word.

//# include parts/ranges
//# include parts/max_array
//# include parts/max_heap
//# include parts/array_up_to
//# include reach/frame_rows

fn append(range: Range, k: u32, count: u32, key: Key) {
    if range.flag && k > ARRAY_UP_TO {
        heap_append(range.start, count, key);
    } else {
        array_append(range.start, count, key);
    }
}

fn replace(range: Range, k: u32, key: Key) {
    if range.flag && k > ARRAY_UP_TO {
        heap_replace(range.start, k, key);
    } else {
        array_replace(range.start, k, key);
    }
}

// Read without the lock, before the farthest depth.
fn acquire_count(pixel: u32) -> u32 {
    return atomicLoad(&pixels[pixel].counter);
}

// Under the lock.
fn insert(pixel: u32, range: Range, k: u32, key: Key) -> u32 {
    let count = count_of(pixel);
    if count < k {
        append(range, k, count, key);
        release_count(pixel, count + 1u);
        return KEPT;
    }
    if !is_less(key, entry(range.start, 0u)) {
        return CULLED;
    }
    replace(range, k, key);
    return EVICTED;
}
