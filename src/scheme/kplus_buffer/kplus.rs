//! k+-buffer with the published choice of structure (Vasilakis, Fudos 2014, section 3.2): a max-array for k <= 16, a
//! max-heap above.

use super::kplus_array::KPlusArray;
use super::kplus_heap::{self, KPlusHeap};
use super::kplus_sb::ARRAY_UP_TO;
use crate::fragment::Fragment;
use crate::memory::{Inside, Layout, Memory, Snapshot};
use crate::scheme::{Config, Contract, Keys, Moment, Outcome, Scheme};

/// The method: one of both.
#[derive(Debug)]
pub enum KPlus {
    /// For small k.
    Array(KPlusArray),
    /// For large k.
    Heap(KPlusHeap<kplus_heap::Correct>),
}

impl Scheme for KPlus {
    const CONTRACT: Contract = Contract {
        name: "kplus",
        title: "k+-buffer: max-array for k <= 16, max-heap above",
        section: "3.1, 3.2 (K+B)",
        source: <KPlusArray>::CONTRACT.source,
        ..<KPlusHeap<kplus_heap::Correct> as Scheme>::CONTRACT
    };

    type Holds = Keys;

    fn new(config: &Config, layout: &mut Layout) -> Self {
        if config.k.unwrap_or(8) <= ARRAY_UP_TO {
            Self::Array(Scheme::new(config, layout))
        } else {
            Self::Heap(Scheme::new(config, layout))
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        let mem = Inside::<_, Self>::of(mem);
        match self {
            Self::Array(array) => array.clear(mem, pixel).await,
            Self::Heap(heap) => heap.clear(mem, pixel).await,
        }
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let mem = Inside::<_, Self>::of(mem);
        match self {
            Self::Array(array) => mem.part(array.store(mem, fragment)).await,
            Self::Heap(heap) => mem.part(heap.store(mem, fragment)).await,
        }
    }

    fn invariant(&self, words: &Snapshot<'_>, pixel: u32, moment: Moment) -> Result<(), String> {
        match self {
            Self::Array(array) => array.invariant(words, pixel, moment),
            Self::Heap(heap) => heap.invariant(words, pixel, moment),
        }
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let mem = Inside::<_, Self>::of(mem);
        match self {
            Self::Array(array) => array.resolve(mem, pixel, keys).await,
            Self::Heap(heap) => heap.resolve(mem, pixel, keys).await,
        }
    }
}
