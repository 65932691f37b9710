//! The image cut into tiles, and the numbering of pixels in memory.
//!
//! Pixel storage is block-linear: tile after tile, in a tile 8x8 block after block, in a block row by row. So a tile
//! owns one contiguous range, a block's per-pixel words share cache lines, and the place of a pixel within its tile
//! is the same whether memory holds one tile or the whole image.

use super::primitive::Rect;
use crate::fragment::{BLOCK, Packet};

/// An image of `width` x `height` pixels in square tiles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub struct Grid {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Tile edge in pixels: 16, 32 or 64.
    pub tile: u32,
}

impl Grid {
    /// Tiles across.
    #[inline]
    #[must_use]
    pub fn columns(&self) -> u32 {
        self.width.div_ceil(self.tile)
    }

    /// Tiles in the image, row by row.
    #[must_use]
    pub fn tiles(&self) -> usize {
        (self.columns() * self.height.div_ceil(self.tile)) as usize
    }

    /// Places for pixels in a tile's storage, also in tiles that the image's edge cuts.
    #[must_use]
    pub fn pixels_per_tile(&self) -> usize {
        (self.tile * self.tile) as usize
    }

    /// Places for pixels in the whole storage.
    #[must_use]
    pub fn storage_pixels(&self) -> usize {
        self.tiles() * self.pixels_per_tile()
    }

    /// All pixels.
    #[must_use]
    pub fn image(&self) -> Rect {
        Rect { x0: 0, y0: 0, x1: self.width, y1: self.height }
    }

    /// The pixels of a tile.
    #[must_use]
    pub fn tile_rect(&self, tile: usize) -> Rect {
        let (column, row) = (tile as u32 % self.columns(), tile as u32 / self.columns());
        let (x0, y0) = (column * self.tile, row * self.tile);
        Rect { x0, y0, x1: x0 + self.tile, y1: y0 + self.tile }.intersect(self.image())
    }

    /// Call `visit` with every tile that a rectangle inside the image touches.
    pub fn tiles_touching(&self, rect: Rect, mut visit: impl FnMut(usize)) {
        for row in rect.y0 / self.tile..=(rect.y1 - 1) / self.tile {
            for column in rect.x0 / self.tile..=(rect.x1 - 1) / self.tile {
                visit((row * self.columns() + column) as usize);
            }
        }
    }

    /// The block of a packet, counted within its tile's storage.
    #[inline]
    #[must_use]
    pub fn local_block(&self, packet: Packet) -> u32 {
        // As in `place`: no division for every packet.
        let edge = self.tile.trailing_zeros() - BLOCK.trailing_zeros();
        let within = (1 << edge) - 1;
        ((u32::from(packet.row) & within) << edge) + (u32::from(packet.column) & within)
    }

    /// The tile of a packet.
    #[inline]
    #[must_use]
    pub fn tile_of(&self, packet: Packet) -> u32 {
        let blocks = self.tile / BLOCK;
        u32::from(packet.row) / blocks * self.columns() + u32::from(packet.column) / blocks
    }

    /// The storage place of a packet's first pixel in whole-image storage.
    #[inline]
    #[must_use]
    pub fn first_pixel(&self, packet: Packet) -> u32 {
        self.tile_of(packet) * self.tile * self.tile + self.local_block(packet) * (BLOCK * BLOCK)
    }

    /// The storage place of pixel (x, y) within its tile.
    #[inline]
    #[must_use]
    pub fn local_pixel(&self, x: u32, y: u32) -> u32 {
        let blocks = self.tile / BLOCK;
        let (column, row) = (x % self.tile / BLOCK, y % self.tile / BLOCK);
        (row * blocks + column) * (BLOCK * BLOCK) + y % BLOCK * BLOCK + x % BLOCK
    }

    /// The storage place of pixel (x, y) in whole-image storage.
    #[inline]
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> u32 {
        let tile = y / self.tile * self.columns() + x / self.tile;
        tile * self.tile * self.tile + self.local_pixel(x, y)
    }

    /// The screen position of a storage place; it may lie outside the image. The inverse of [`Self::pixel`].
    #[inline]
    #[must_use]
    pub fn place(&self, pixel: u32) -> (u32, u32) {
        // Tiles are powers of two: shifts, where a hash table asks for every fragment.
        let (edge, columns) = (self.tile.trailing_zeros(), self.columns());
        let (tile, local) = (pixel >> (2 * edge), pixel & ((1 << (2 * edge)) - 1));
        let (block, bit, blocks) = (local / 64, local % 64, edge - BLOCK.trailing_zeros());
        let (column, row) = (block & ((1 << blocks) - 1), block >> blocks);
        let x = ((tile % columns) << edge) + column * BLOCK + bit % BLOCK;
        let y = ((tile / columns) << edge) + row * BLOCK + bit / BLOCK;
        (x, y)
    }

    /// The screen position of a storage place within a tile; it may lie outside the image.
    #[inline]
    #[must_use]
    pub fn position(&self, tile: usize, local: u32) -> (u32, u32) {
        let blocks = self.tile / BLOCK;
        let (block, bit) = (local / 64, local % 64);
        let corner = self.tile_rect(tile);
        (corner.x0 + block % blocks * BLOCK + bit % 8, corner.y0 + block / blocks * BLOCK + bit / 8)
    }
}
