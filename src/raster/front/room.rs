//! Room for primitives that is used again, so that the system need not hand out zeroed pages for every frame.

use std::sync::Mutex;

use super::super::place::Vertex;
use super::bins::Row;
use super::part::Part;

/// What front ends have left, emptied. By default nothing is kept, since no other frame follows.
#[derive(Debug, Default)]
pub struct Room {
    keeps: bool,
    parts: Mutex<Shelf<Part>>,
    rows: Mutex<Shelf<Row>>,
    vertices: Mutex<Shelf<Vec<Vertex>>>,
}

/// Things to use again. The last that is put there is taken first.
#[derive(Debug)]
struct Shelf<T> {
    things: Vec<T>,
    /// The fewest things since it was tidied: so many at its bottom were not used.
    fewest: usize,
}

impl Room {
    /// For several frames, one after another.
    #[must_use]
    pub fn of_several() -> Self {
        Self { keeps: true, ..Self::default() }
    }

    /// An empty part.
    pub(super) fn part(&self) -> Part {
        take(&self.parts)
    }

    /// An empty row of bins.
    pub(super) fn row(&self) -> Row {
        take(&self.rows)
    }

    /// No vertices.
    pub(super) fn vertices(&self) -> Vec<Vertex> {
        take(&self.vertices)
    }

    pub(super) fn keep_parts(&self, parts: Vec<Part>) {
        self.keep(&self.parts, parts.into_iter().map(Part::emptied));
    }

    pub(super) fn keep_rows(&self, rows: Vec<Row>) {
        self.keep(&self.rows, rows.into_iter().map(Row::emptied));
    }

    pub(super) fn keep_vertices(&self, mut vertices: Vec<Vertex>) {
        vertices.clear();
        self.keep(&self.vertices, [vertices]);
    }

    /// A frame is over: give back what it did not use, so that no more is kept than one frame takes.
    pub(super) fn tidy(&self) {
        tidy(&self.parts);
        tidy(&self.rows);
        tidy(&self.vertices);
    }

    fn keep<T>(&self, shelf: &Mutex<Shelf<T>>, used: impl IntoIterator<Item = T>) {
        if self.keeps
            && let Ok(mut shelf) = shelf.lock()
        {
            shelf.things.extend(used);
        }
    }
}

impl<T> Default for Shelf<T> {
    fn default() -> Self {
        Self { things: Vec::new(), fewest: 0 }
    }
}

fn take<T: Default>(shelf: &Mutex<Shelf<T>>) -> T {
    let Ok(mut shelf) = shelf.lock() else { return T::default() };
    let taken = shelf.things.pop();
    shelf.fewest = shelf.fewest.min(shelf.things.len());
    taken.unwrap_or_default()
}

fn tidy<T>(shelf: &Mutex<Shelf<T>>) {
    if let Ok(mut shelf) = shelf.lock() {
        let unused = shelf.fewest;
        shelf.things.drain(..unused);
        shelf.fewest = shelf.things.len();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_frame_did_not_use_is_given_back() {
        let room = Room::of_several();
        let frame = |count: usize| {
            let taken: Vec<_> = (0..count).map(|_| room.vertices()).collect();
            let used = taken.iter().filter(|vertices| vertices.capacity() > 0).count();
            for mut vertices in taken {
                vertices.reserve(8);
                room.keep_vertices(vertices);
            }
            room.tidy();
            used
        };
        assert_eq!([frame(3), frame(2), frame(3), frame(3)], [0, 2, 2, 3]);
        let room = Room::default();
        room.keep_vertices(Vec::with_capacity(8));
        assert_eq!(room.vertices().capacity(), 0, "no other frame follows");
    }
}
