//! What a pixel must hold: the one place that says so, for every comparison (references, the explorer, devices, tests).

use super::{Instance, Method};
use crate::fragment::Fragment;
use crate::memory::Inputs;
use crate::scheme::bound::Bound;
use crate::scheme::{Contract, Held, HeldKind, Keeps};

/// How many of each pixel's nearest fragments a method is held to, with the given k and inputs, for so many storage
/// pixels. `counts` tells how many fragments each has; it is asked only where that matters.
#[must_use]
pub fn bound(
    method: Method,
    instance: Option<&dyn Instance>,
    k: Option<u32>,
    inputs: &Inputs,
    pixels: u32,
    counts: impl FnOnce() -> Vec<u32>,
) -> Bound {
    let contract = method.contract();
    match (contract.keeps, instance) {
        (Keeps::NearestChosen, Some(instance)) => {
            Bound::PerPixel(instance.chosen(inputs, &counts()))
        }
        (Keeps::NearestBy(name), Some(instance)) => {
            let declared = instance.layout().inputs();
            match declared.iter().position(|input| input.name == name) {
                Some(input) => {
                    Bound::PerPixel((0..pixels).map(|p| inputs.word(input, p)).collect())
                }
                None => Bound::All,
            }
        }
        _ => Bound::of(contract.reference_k(k)),
    }
}

/// What a method must give, pixel by pixel.
#[derive(Clone)]
pub struct Promise<'a> {
    contract: &'static Contract,
    holds: HeldKind,
    instance: Option<&'a dyn Instance>,
    inputs: &'a Inputs,
    bound: Bound,
}

impl<'a> Promise<'a> {
    /// For a method with an instance (all but the oracle): the words of its inputs, and how many of each pixel's
    /// nearest fragments it must keep ([`bound`]).
    #[must_use]
    pub fn new(
        method: Method,
        instance: Option<&'a dyn Instance>,
        inputs: &'a Inputs,
        bound: Bound,
    ) -> Self {
        Self { contract: method.contract(), holds: method.holds(), instance, inputs, bound }
    }

    /// What the pixel in this place of the storage must hold, where room and arrival do not matter; `generated` are all
    /// its fragments in canonical order. `None` if the method does not specify what it approximates.
    #[must_use]
    pub fn pixel(&self, pixel: u32, generated: &[Fragment]) -> Option<Held> {
        let own = self.instance.and_then(|i| i.expected(self.inputs, pixel, generated));
        if let Some(mut held) = own {
            held.sort();
            return Some(held);
        }
        if self.holds != HeldKind::Fragments || self.contract.keeps.is_approximate() {
            return None;
        }
        let mut keys: Vec<u64> = generated.iter().map(|f| f.key()).collect();
        self.contract.keep(&mut keys, self.bound.at(pixel as usize));
        Some(Held::Keys(keys))
    }
}
