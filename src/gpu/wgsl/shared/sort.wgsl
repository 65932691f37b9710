// Sorting a pixel's records into canonical order, front to back, in place: insertion sort up to 16, and shell sort
// above (k+-buffer paper, section 3.2). Equal records are identical fragments, so any correct sort gives the same list.

//# include shared/fragment
//# include shared/emit

const INSERTION_UP_TO: u32 = 16u;

// One pass over records that are `gap` apart.
fn insertion(start: u32, count: u32, gap: u32) {
    for (var i = gap; i < count; i++) {
        let key = lists[start + i];
        var place = i;
        while place >= gap && is_less(key, lists[start + place - gap]) {
            lists[start + place] = lists[start + place - gap];
            place -= gap;
        }
        lists[start + place] = key;
    }
}

fn sort(start: u32, count: u32) {
    if count > INSERTION_UP_TO {
        // Ciura's gaps; beyond them, each is 9/4 of the one before.
        var gaps = array<u32, 16>(
            1u, 4u, 10u, 23u, 57u, 132u, 301u, 701u,
            1577u, 3548u, 7983u, 17961u, 40412u, 90927u, 204585u, 460316u,
        );
        for (var i = 15u; i > 0u; i--) {
            if gaps[i] < count {
                insertion(start, count, gaps[i]);
            }
        }
    }
    insertion(start, count, 1u);
}
