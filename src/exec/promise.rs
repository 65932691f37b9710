//! What a pixel must hold: the one place that says it, for whoever compares (references, the explorer, devices, tests).

use super::{Instance, Method};
use crate::memory::Inputs;
use crate::scheme::bound::Bound;
use crate::scheme::{Contract, Held, HeldKind};

/// What a method is held to, pixel by pixel.
#[derive(Clone)]
pub struct Promise<'a> {
    contract: &'static Contract,
    holds: HeldKind,
    instance: Option<&'a dyn Instance>,
    inputs: &'a Inputs,
    bound: Bound,
}

impl<'a> Promise<'a> {
    /// Of a method with an instance (but for the oracle), the words of its inputs, and how many of each pixel's nearest
    /// fragments it is held to ([`Contract::bound`]).
    #[must_use]
    pub fn new(
        method: Method,
        instance: Option<&'a dyn Instance>,
        inputs: &'a Inputs,
        bound: Bound,
    ) -> Self {
        Self { contract: method.contract(), holds: method.holds(), instance, inputs, bound }
    }

    /// What the pixel in this place of the storage must hold, where room and arrival have no say; `generated` are all its
    /// fragments in canonical order. `None` if the method says nothing of what it approximates.
    #[must_use]
    pub fn pixel(&self, pixel: u32, generated: &[u64]) -> Option<Held> {
        let own = self.instance.and_then(|i| i.expected(self.inputs, pixel, generated));
        if let Some(mut held) = own {
            held.sort();
            return Some(held);
        }
        if self.holds != HeldKind::Fragments || self.contract.keeps.is_approximate() {
            return None;
        }
        let mut keys = generated.to_vec();
        self.contract.keep(&mut keys, self.bound.at(pixel as usize));
        Some(Held::Keys(keys))
    }
}
