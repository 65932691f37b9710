//! One pixel of a method on memory of its own: its invocations one after another, in an order of the caller's choice.

use super::Method;
use super::drive::{Pipeline, complete};
use super::interpret::Interpreted;
use super::method::Instance;
use crate::fragment::Fragment;
use crate::memory::arena::{Owned, Shared};
use crate::memory::exclusive::Exclusive;
use crate::memory::{Counters, Inputs};
use crate::scheme::program::PassKind;
use crate::scheme::task::Task;
use crate::scheme::{Config, Held, Outcome};

/// A method, configured for a single pixel.
pub struct OnePixel {
    method: Method,
    instance: Box<dyn Instance>,
    inputs: Inputs,
}

/// What became of a pixel.
#[derive(Clone, Debug)]
pub struct Stored {
    /// What it holds.
    pub held: Held,
    /// What every fragment's invocation reported.
    pub outcomes: Vec<Outcome>,
    /// Operations on memory, in all passes.
    pub counters: Counters,
    /// Accesses outside of the method's words.
    pub outside: u64,
}

impl OnePixel {
    /// A method with this configuration, whose inputs have their defaults. `None` for the oracle, which has no
    /// invocations.
    #[must_use]
    pub fn new(method: Method, config: &Config) -> Option<Self> {
        let instance = method.instance(config)?;
        let inputs = Inputs::defaults(instance.layout());
        Some(Self { method, instance, inputs })
    }

    /// A configuration with room for this many fragments of one pixel.
    #[must_use]
    pub fn config(fragments: usize, k: u32, base: Config) -> Config {
        let n = fragments as u64;
        Config {
            k: Some(k),
            pixels: 1,
            generated: n,
            max_depth_complexity: fragments as u32,
            bounded: n,
            pages: n,
            ..base
        }
    }

    /// Store fragments of pixel 0 in this order, and resolve. What is held is in canonical order.
    ///
    /// # Panics
    /// If the method's code does, or if an invocation waits for another.
    #[must_use]
    pub fn store(&self, fragments: &[Fragment]) -> Stored {
        let scheme = Interpreted { instance: &*self.instance, inputs: &self.inputs };
        let layout = self.instance.layout();
        let pixel = Owned::new(layout.per_pixel(), 1);
        let global = Shared::new(layout.per_frame(), 1);
        let counters = Counters::default();
        let mem = Exclusive::new(&pixel, &global, &self.inputs, &counters);
        let mut outcomes = Vec::new();
        scheme.clear_frame(&mem);
        scheme.clear(&mem, 0..1);
        for (number, pass) in self.method.contract().program.passes.iter().enumerate() {
            match pass.kind {
                PassKind::Prepare => fragments.iter().for_each(|&fragment| {
                    complete(scheme.run(&mem, Task::Prepare(number as u8, fragment)));
                }),
                PassKind::Screen => scheme.screen(&mem, number, 0..1),
                PassKind::Frame => scheme.frame(&mem, number, 0..self.instance.invocations(number)),
                PassKind::Store => {
                    let store = |&fragment| complete(scheme.store(&mem, fragment));
                    outcomes.extend(fragments.iter().map(store));
                }
            }
        }
        let mut held = self.method.holds().empty();
        scheme.resolve(&mem, 0, &mut held);
        held.sort();
        let outside = pixel.outside() + global.outside();
        Stored { held, outcomes, outside, counters }
    }

    /// What the pixel must hold with these fragments, if the method says so.
    #[must_use]
    pub fn expected(&self, fragments: &[Fragment]) -> Option<Held> {
        let mut sorted = fragments.to_vec();
        sorted.sort_unstable();
        let mut held = self.instance.expected(&self.inputs, 0, &sorted)?;
        held.sort();
        Some(held)
    }
}
