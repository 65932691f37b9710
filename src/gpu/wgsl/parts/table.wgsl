// The table of hash schemes: cells in two dimensions, addressed from a pixel by its position and a sequence of offsets
// (García, Lefebvre, Hornus, Lasram 2011; HA-buffer paper, 2.5.1 and 4.1).
//
// At age a, pixel p looks at cell p + offset(a), modulo the table's size on each axis. The table is at least as large
// as the picture on each axis, so that a cell and an age name a pixel. A second table has the largest age of every
// block of 8x8 pixels.

//# include shared/grid

const TABLE: vec2<u32> = vec2<u32>(TABLE_WIDTH, TABLE_HEIGHT);

// Pixels of a block on each side, blocks across, and blocks in all.
const EDGE: u32 = 8u;
const ACROSS: u32 = (WIDTH + EDGE - 1u) / EDGE;
const LARGEST: u32 = ACROSS * ((HEIGHT + EDGE - 1u) / EDGE);

// Words that one invocation of the clear pass clears.
const CLEARED: u32 = 64u;

// The offsets of all ages, two per element, the first for age 1.
@group(0) @binding(4) var<uniform> offsets: array<vec4<u32>, 128>;

// For age 1 or more.
fn offset_of(age: u32) -> vec2<u32> {
    let i = age - 1u;
    let two = offsets[i / 2u];
    return select(two.zw, two.xy, i % 2u == 0u);
}

// Wraps a place that is at most one table size too large on each axis.
fn turn(place: vec2<u32>) -> vec2<u32> {
    return select(place, place - TABLE, place >= TABLE);
}

// Where a pixel's walk begins.
fn begin_of(pixel: u32) -> vec2<u32> {
    return place_of(pixel) % TABLE;
}

// Whether a storage place is a pixel of the picture: tiles cut by its edge have other places.
fn is_seen(pixel: u32) -> bool {
    return all(place_of(pixel) < vec2<u32>(WIDTH, HEIGHT));
}

// The cell at which a walk is at an age.
fn cell_of(place: vec2<u32>, age: u32) -> vec2<u32> {
    return turn(place + offset_of(age));
}

// Where the walk that reaches this cell at this age began.
fn origin_of(cell: vec2<u32>, age: u32) -> vec2<u32> {
    return turn(cell + TABLE - offset_of(age));
}

// The number of a cell's word.
fn index_of(cell: vec2<u32>) -> u32 {
    return cell.y * TABLE_WIDTH + cell.x;
}

// The block that holds this place's largest age.
fn block_of(place: vec2<u32>) -> u32 {
    return place.y / EDGE * ACROSS + place.x / EDGE;
}
