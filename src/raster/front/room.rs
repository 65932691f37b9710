//! Room for primitives that is used again, so that the system need not hand out zeroed pages for every frame.

use std::sync::Mutex;

use super::super::place::Vertex;
use super::bins::Row;
use super::part::Part;

/// What front ends have left, emptied. By default nothing is kept, since no other frame follows.
#[derive(Debug, Default)]
pub struct Room {
    keeps: bool,
    parts: Mutex<Vec<Part>>,
    rows: Mutex<Vec<Row>>,
    vertices: Mutex<Vec<Vec<Vertex>>>,
}

impl Room {
    /// For several frames, one after another.
    #[must_use]
    pub fn of_several() -> Self {
        Self { keeps: true, ..Self::default() }
    }

    /// An empty part.
    pub(super) fn part(&self) -> Part {
        taken(&self.parts)
    }

    /// An empty row of bins.
    pub(super) fn row(&self) -> Row {
        taken(&self.rows)
    }

    /// No vertices.
    pub(super) fn vertices(&self) -> Vec<Vertex> {
        taken(&self.vertices)
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

    /// The last in is the first out, so what was taken first must be kept last.
    fn keep<T>(&self, shelf: &Mutex<Vec<T>>, used: impl IntoIterator<Item = T>) {
        if self.keeps
            && let Ok(mut shelf) = shelf.lock()
        {
            shelf.extend(used);
        }
    }
}

fn taken<T: Default>(shelf: &Mutex<Vec<T>>) -> T {
    shelf.lock().ok().and_then(|mut shelf| shelf.pop()).unwrap_or_default()
}
