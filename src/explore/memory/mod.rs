//! Memory models: what an operation may find.
//!
//! [`model`] defines what every model answers; [`sequential`] and [`relaxed`] are the two models.

pub(super) mod model;
mod relaxed;
mod sequential;

use self::relaxed::Relaxed;
use self::sequential::Sequential;
use crate::memory::Numbering;

use self::model::{Initial, Model};
pub use self::model::{MemoryModel, Profile};

/// Make the model's memory for some initial words. `candidates` are the values that an unwritten word may take.
pub(in crate::explore) fn make(
    model: MemoryModel,
    cells: &Numbering,
    initial: &[Initial],
    candidates: &[u64],
    invocations: usize,
) -> Box<dyn Model> {
    match model {
        MemoryModel::Sequential => Box::new(Sequential::new(cells, initial, candidates)),
        MemoryModel::Relaxed(profile) => {
            Box::new(Relaxed::new(cells, initial, candidates, invocations, profile))
        }
    }
}
