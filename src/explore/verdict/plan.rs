//! What is checked of a method, and how far.

use crate::explore::memory::model::{MemoryModel, Profile};
use crate::explore::search::progress::Progress;
use crate::scheme::Contract;

/// What to check, and how far.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Fragments, from 1 up to this; `None` is 4 under sequential consistency and 3 otherwise, and for methods that
    /// add up an approximation.
    pub fragments: Option<u32>,
    /// The k to try, for methods that take one.
    pub ks: Vec<u32>,
    /// Memory models.
    pub memory: Vec<MemoryModel>,
    /// Progress models under which invocations must end; `None` is the model that the method may rely on, and weak
    /// fairness.
    pub progress: Option<Vec<Progress>>,
    /// Whether invocations must end also as lanes of one warp.
    pub simt: bool,
    /// Helper invocations next to the first fragments.
    pub helpers: u32,
    /// Random runs of instances with more fragments; 0 for none.
    pub runs: u64,
    /// The seed of the first of them.
    pub seed: u64,
}

impl Default for Plan {
    fn default() -> Self {
        Self {
            fragments: None,
            ks: vec![1, 2, 3],
            memory: vec![MemoryModel::Sequential, MemoryModel::Relaxed(Profile::Vulkan)],
            progress: None,
            simt: true,
            helpers: 0,
            runs: 400,
            seed: 0,
        }
    }
}

/// The most fragments that instances have under relaxed memory, however many are requested: states grow fast.
pub const MOST_RELAXED: u32 = 4;

/// The most fragments for progress and reconvergence: three suffice for a lasso.
pub const MOST_PROGRESS: u32 = 3;

/// Whether it adds up an approximation: many operations, of which few interact. Nodes that depend on arrival take
/// turns, and need one fragment more to show it.
fn sums(contract: &Contract) -> bool {
    let nodes = contract.is_arrival_dependent() && contract.default_k.is_some();
    contract.keeps.is_approximate() && !nodes
}

impl Plan {
    /// Progress models for a method. Most methods need invocations that have begun to be scheduled again. A method that
    /// relies on the ordered interlock also needs those before them, which is what the interlock guarantees.
    #[must_use]
    pub fn progress_of(&self, contract: &Contract) -> Vec<Progress> {
        let begun = if contract.is_interlocked() { Progress::Lobe } else { Progress::Obe };
        self.progress.clone().unwrap_or_else(|| vec![begun, Progress::Fair])
    }

    /// Fragments under a memory model.
    #[must_use]
    pub fn fragments_under(&self, contract: &Contract, memory: MemoryModel) -> u32 {
        match (self.fragments, memory) {
            // Every update of a cell is a message: a table has many states.
            (n, MemoryModel::Relaxed(_)) if contract.crosses() => n.unwrap_or(2).min(2),
            (None, MemoryModel::Sequential) if sums(contract) => 3,
            (None, MemoryModel::Sequential) => 4,
            (None, MemoryModel::Relaxed(_)) => 3,
            (Some(n), MemoryModel::Sequential) => n,
            (Some(n), MemoryModel::Relaxed(_)) => n.min(MOST_RELAXED),
        }
    }
}
