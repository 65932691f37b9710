// The numbering of pixels in memory: tile after tile, in a tile 8x8 block after block, in a block row by row.

const BLOCK_EDGE: u32 = 8u;

// The storage place of a pixel of the picture.
fn pixel_at(place: vec2<u32>) -> u32 {
    let tile = place.y / TILE * COLUMNS + place.x / TILE;
    let inside = place % TILE;
    let block = inside.y / BLOCK_EDGE * (TILE / BLOCK_EDGE) + inside.x / BLOCK_EDGE;
    let bit = inside.y % BLOCK_EDGE * BLOCK_EDGE + inside.x % BLOCK_EDGE;
    return tile * TILE * TILE + block * BLOCK_EDGE * BLOCK_EDGE + bit;
}

// The pixel at a storage place; it may lie outside of the picture, in a tile that its edge cuts.
fn place_of(pixel: u32) -> vec2<u32> {
    let tile = pixel / (TILE * TILE);
    let block = pixel % (TILE * TILE) / (BLOCK_EDGE * BLOCK_EDGE);
    let bit = pixel % (BLOCK_EDGE * BLOCK_EDGE);
    let blocks = TILE / BLOCK_EDGE;
    return vec2<u32>(
        tile % COLUMNS * TILE + block % blocks * BLOCK_EDGE + bit % BLOCK_EDGE,
        tile / COLUMNS * TILE + block / blocks * BLOCK_EDGE + bit / BLOCK_EDGE,
    );
}
