// Dynamic fragment buffer (Maule, Comba, Torchelsen, Bastos 2012; DFB): count, prefix sum, store into exact ranges.

//# include parts/counted_down
//# include shared/emit

struct Frame {
    blocks: array<atomic<u32>, BLOCKS>,
    groups: array<u32>,
}

@group(0) @binding(2) var<storage, read_write> memory: Frame;
@group(0) @binding(3) var<storage, read_write> records: array<Key>;

fn clear_frame() {
    clear_sums();
}

fn clear(pixel: u32) {
    clear_counter(pixel);
}

fn prepare(fragment: Fragment) {
    count_fragment(fragment.pixel);
}

fn screen(pixel: u32) {
    refer_counted(pixel);
}

fn frame(number: u32, index: u32) {
    sum_up(number, index);
}

fn store(fragment: Fragment) -> u32 {
    let place = next_place(fragment.pixel);
    if place.outcome == KEPT {
        records[place.record] = key_of(fragment);
    }
    return place.outcome;
}

fn resolve(pixel: u32) {
    let ends = records_of(pixel);
    for (var record = ends.x; record < ends.y; record++) {
        emit(records[record]);
    }
}
