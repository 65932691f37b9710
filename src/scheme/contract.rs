//! Contracts: what a method promises, as data.

use serde::Serialize;

use crate::num::depth::Format;

/// What a method promises.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Contract {
    /// The name on the command line, with `@variant` if any.
    pub name: &'static str,
    /// One line.
    pub title: &'static str,
    /// Where it was published.
    pub paper: &'static str,
    /// Section, figure or algorithm there.
    pub section: &'static str,
    /// What stands in this file: the correct form, the published one where that differs, or a built-in fault.
    pub form: Form,
    /// Geometry passes.
    pub passes: u32,
    /// Words of 4 bytes per pixel (k: `-k`; n: slots; F: fragments of the frame), as a formula.
    pub words: &'static str,
    /// What a pixel holds after resolve.
    pub keeps: Keeps,
    /// Under which condition that equals the exact answer.
    pub exact_when: &'static str,
    /// Whether the result may depend on the order in which fragments arrive.
    pub arrival_dependent: bool,
    /// Whether it may depend on how concurrent invocations interleave, even for a given order of arrival: fragments
    /// may be lost, doubled or torn, and the run is judged against the generated multiset.
    pub racy: bool,
    /// What happens to fragments of equal depth.
    pub ties: &'static str,
    /// What happens when there is no room.
    pub overflow: &'static str,
    /// Memory orderings and device features it needs.
    pub needs: &'static str,
    /// How WGSL can express it; `None` if it cannot.
    pub wgsl: Option<&'static str>,
    /// The depth word that the paper fixes; `None` where any will do.
    pub depth_format: Option<Format>,
    /// `-k` if it is not given; `None` where the method keeps all or measures the scene.
    pub default_k: Option<u32>,
    /// The largest `-k`.
    pub max_k: u32,
    /// What it must know of the scene before memory is allocated.
    pub demand: Demand,
    /// The barriers between its passes.
    pub barriers: Barriers,
    /// The text of its source file, by `include_str!`: from it, a check knows which operations there are to be reached.
    #[serde(skip)]
    pub source: &'static str,
}

/// Which barriers stand between passes. Only a fault leaves one out; the simulated device and the explorer then let the
/// passes overlap.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Barriers {
    /// Between clear and store.
    pub before_store: bool,
    /// Between store and resolve.
    pub before_resolve: bool,
}

impl Barriers {
    /// As it should be.
    pub const ALL: Self = Self { before_store: true, before_resolve: true };
}

/// Which form of a method this is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// As it must be to keep its promise.
    Correct,
    /// As published, where that differs from the correct form, or where there is no correct form.
    Published,
    /// A built-in fault that a check must find.
    Mutation,
}

/// What a pixel holds after resolve.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Keeps {
    /// Every fragment.
    All,
    /// The k smallest in canonical order.
    Nearest,
    /// The smallest in canonical order.
    One,
    /// Every fragment while there are free slots, then none.
    FirstArrivals,
}

/// What a method must know of the scene before its memory is allocated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Demand {
    /// Nothing.
    Nothing,
    /// How many fragments a geometry pass generates.
    Generated,
    /// The largest number of fragments at a pixel, unless `-k` is given.
    MaxDepthComplexity,
}

impl Contract {
    /// The fragments per pixel that the exact reference keeps to be comparable, for a run with the given k.
    #[must_use]
    pub fn reference_k(&self, k: Option<u32>) -> Option<u32> {
        match self.keeps {
            Keeps::All | Keeps::FirstArrivals => None,
            Keeps::Nearest => k.or(self.default_k),
            Keeps::One => Some(1),
        }
    }

    /// The result does not depend on arrival or interleaving.
    #[must_use]
    pub fn order_independent(&self) -> bool {
        !self.arrival_dependent && !self.racy
    }

    /// A built-in fault of this method, racy as most are.
    #[must_use]
    pub const fn fault(
        self,
        name: &'static str,
        title: &'static str,
        exact_when: &'static str,
    ) -> Self {
        Self { name, title, exact_when, form: Form::Mutation, racy: true, ..self }
    }

    /// The name without `@variant`.
    #[must_use]
    pub fn base_name(&self) -> &'static str {
        self.name.split('@').next().unwrap_or(self.name)
    }
}
