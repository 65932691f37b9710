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
    /// `-k` if it is not given; `None` where the method keeps all or measures the scene.
    pub default_k: Option<u32>,
    /// The depth format that the paper fixes; `None` where any will do.
    pub depth_format: Option<Format>,
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
}

/// Stand-ins until the catalogue is here.
#[must_use]
pub fn contracts() -> Vec<&'static Contract> {
    vec![&EXACT, &KPLUS]
}

const EXACT: Contract = Contract {
    name: "exact",
    title: "The sequential reference",
    paper: "-",
    section: "-",
    form: Form::Correct,
    passes: 1,
    words: "2F",
    keeps: Keeps::All,
    exact_when: "always",
    arrival_dependent: false,
    racy: false,
    ties: "canonical",
    overflow: "none",
    needs: "nothing",
    wgsl: None,
    default_k: None,
    depth_format: None,
};

const KPLUS: Contract = Contract {
    name: "kplus-array",
    title: "k+-buffer: spin lock and max-array",
    paper: "Vasilakis, Fudos 2014",
    section: "k+-buffer paper, 4",
    words: "2k + 2",
    keeps: Keeps::Nearest,
    default_k: Some(8),
    ..EXACT
};
