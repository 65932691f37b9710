//! What executors keep from one frame to the next: storage, and room for results.

use std::sync::Mutex;

use super::frame::TileOutput;
use super::table::{Left, TableWords};
use crate::memory::Layout;
use crate::memory::arena::{Owned, Shared};
use crate::memory::layout::Sizes;
use crate::memory::reuse::Reuse;
use crate::raster::Room;
use crate::scheme::Readback;

/// Storage and room that are not in use. By default nothing is kept, since no other frame follows.
#[derive(Debug, Default)]
pub struct Kit {
    /// Whether another frame follows.
    keeps: bool,
    /// Words of memory.
    pub memory: Reuse,
    /// Primitives and bins.
    pub front: Room,
    /// Of the frame before, how large records are and how many pixels have them.
    sizes: Mutex<Option<([Sizes; 2], usize)>>,
    /// Results that were consumed, by tile.
    tiles: Mutex<Vec<TileOutput>>,
}

impl Kit {
    /// For several frames, one after another.
    #[must_use]
    pub fn of_several() -> Self {
        Self { keeps: true, front: Room::of_several(), ..Self::default() }
    }

    /// A frame begins. If its words are of other sizes than those of the frame before, that frame's are given back, so
    /// that storage of no more than one frame is kept.
    pub fn begin(&self, layout: &Layout, pixels: usize) {
        let own = Some(([layout.per_pixel(), layout.per_frame()], pixels));
        if let Ok(mut sizes) = self.sizes.lock()
            && *sizes != own
        {
            *sizes = own;
            self.memory.forget();
        }
    }

    /// Keep words that many threads shared.
    pub fn keep_shared(&self, shared: Shared) {
        if self.keeps {
            self.memory.keep_shared(shared);
        }
    }

    /// The table in a frame's words; if there is none, the words are kept.
    #[must_use]
    pub fn left(&self, readback: Option<Readback>, global: Shared) -> Option<Left> {
        match readback {
            Some(readback) => Some(Left::There(readback, global)),
            None => {
                self.keep_shared(global);
                None
            }
        }
    }

    /// Read a table back, and keep its words.
    #[must_use]
    pub fn read(&self, left: Left) -> TableWords {
        match left {
            Left::Read(words) => words,
            Left::There(readback, global) => {
                let words = TableWords::new(&readback, &global);
                self.keep_shared(global);
                words
            }
        }
    }

    /// Keep words that one thread owned.
    pub fn keep_owned(&self, owned: Owned) {
        if self.keeps {
            self.memory.keep_owned(owned);
        }
    }

    /// Room for the results of a tile: empty, with the capacity of the frame before.
    #[must_use]
    pub fn tile(&self, index: usize) -> TileOutput {
        let mut tiles = match self.tiles.lock() {
            Ok(tiles) => tiles,
            Err(_) => return TileOutput::default(),
        };
        tiles.get_mut(index).map(std::mem::take).unwrap_or_default()
    }

    /// Keep the room of all tiles for the next frame.
    pub fn keep(&self, used: Vec<TileOutput>) {
        if self.keeps
            && !used.is_empty()
            && let Ok(mut tiles) = self.tiles.lock()
        {
            *tiles = used.into_iter().map(TileOutput::emptied).collect();
        }
    }
}
