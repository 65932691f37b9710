//! Contracts: what a method promises, as data.

use serde::Serialize;

use super::bound::Bound;
use crate::fragment::{Data, depth_of};
use crate::memory::{Inputs, Layout};
use crate::num::depth::Format;
use crate::raster::Record;

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
    /// What runs between clear and resolve.
    pub program: Program,
    /// Words of 4 bytes per pixel: a sum of products of numbers and of k (`-k`) and n (slots: the largest depth
    /// complexity, or `-k`).
    pub words: &'static str,
    /// Words of 4 bytes for the frame: as above, with F (fragments of a geometry pass), S (the sum of min(f, k) over
    /// pixels), P (pixels), G (blocks of 64 pixels), H (64 such blocks), Q (pages), C (cells of the hash table) and B
    /// (blocks of 8x8 pixels in the picture).
    pub frame_words: &'static str,
    /// Words per pixel as its paper counts them, where it does: without what only our form needs.
    pub published_words: Option<&'static str>,
    /// What a pixel holds after resolve.
    pub keeps: Keeps,
    /// Whether fragments of a pixel that are wholly alike, in depth and data, are all kept; else one of them is.
    pub identical: bool,
    /// Whether an invocation may end with a fragment of another pixel: what is dropped is known for the frame only, and
    /// where anything was, the accounting compares lists.
    pub crosses: bool,
    /// Whether it does not depend on arrival either what finds no room.
    pub settled_overflow: bool,
    /// Under which condition that equals the exact answer.
    pub exact_when: &'static str,
    /// Whether the result may depend on the order in which fragments arrive.
    pub arrival_dependent: bool,
    /// Whether it may depend on how concurrent invocations interleave, even for a given order of arrival: fragments
    /// may be lost, doubled or torn, and the run is judged against the generated multiset.
    pub racy: bool,
    /// Whether, racy or not, the depths that it keeps are the exact ones, and every record is a fragment's: only which
    /// of several fragments of equal depth stands for them may vary.
    pub right_depths: bool,
    /// Whether its invocations cannot say what became of their fragments: the accounting compares lists instead.
    pub judged: bool,
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
    /// Bits of the depth word that it has room for.
    pub depth_bits: u32,
    /// The data word that it needs; `None` where any will do.
    pub data: Option<Data>,
    /// `-k` if it is not given; `None` where the method takes none or measures the scene. Where a method keeps all, it
    /// bounds what a round keeps.
    pub default_k: Option<u32>,
    /// The largest `-k`.
    pub max_k: u32,
    /// The most pixels, with those of tiles that the image's edge cuts.
    pub max_pixels: u32,
    /// What it must know of the scene before memory is allocated.
    pub demand: Demand,
    /// Fragments for which one index of its pool is, if it has one.
    pub page: u32,
    /// Whether it needs the ordered interlock: each fragment then knows its rank among its pixel's, in API order.
    pub interlock: bool,
    /// The text of its source file, by `include_str!`: from it, a check knows which operations there are to be reached.
    #[serde(skip)]
    pub source: &'static str,
}

/// What runs between clear and resolve: passes in this order, each behind a barrier.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Program {
    /// The passes; the last is the store pass.
    pub passes: &'static [Pass],
    /// The barrier before resolve.
    pub before_resolve: Barrier,
    /// Whether passes and resolve are repeated as long as a pixel asks for it ([`super::Scheme::again`]).
    pub repeats: bool,
}

/// One pass: a queue of invocations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Pass {
    /// What it is for, in a word.
    pub name: &'static str,
    /// What its invocations are.
    pub kind: PassKind,
    /// The barrier before it.
    pub before: Barrier,
}

/// What a pass's invocations are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PassKind {
    /// The store pass: one per fragment, and what becomes of it is accounted for.
    Store,
    /// An earlier geometry pass: one per fragment.
    Prepare,
    /// A full-screen pass: one per pixel.
    Screen,
    /// A pass over the frame's own words: as many as the scheme says.
    Frame,
}

/// Who waits for whom between two passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Barrier {
    /// Nobody: only a fault leaves a barrier out. The simulated device and the explorer then let the passes overlap.
    Missing,
    /// The invocations of a pixel for those of the same pixel.
    Pixel,
    /// All for all.
    Frame,
}

impl Pass {
    /// The store pass, behind a barrier.
    #[must_use]
    pub const fn store(before: Barrier) -> Self {
        Self { name: "store", kind: PassKind::Store, before }
    }

    /// Another pass, behind a barrier.
    #[must_use]
    pub const fn new(name: &'static str, kind: PassKind, before: Barrier) -> Self {
        Self { name, kind, before }
    }

    /// It runs over the scene's fragments.
    #[must_use]
    pub const fn is_geometry(&self) -> bool {
        matches!(self.kind, PassKind::Store | PassKind::Prepare)
    }
}

impl Program {
    /// A store pass, and nothing else.
    pub const STORE: Self = Self::of(&[Pass::store(Barrier::Pixel)]);

    /// These passes, once.
    #[must_use]
    pub const fn of(passes: &'static [Pass]) -> Self {
        Self { passes, before_resolve: Barrier::Pixel, repeats: false }
    }

    /// These passes, as long as a pixel asks for them.
    #[must_use]
    pub const fn repeated(passes: &'static [Pass]) -> Self {
        Self { repeats: true, ..Self::of(passes) }
    }

    /// Geometry passes of one round.
    #[must_use]
    pub fn geometry(&self) -> u32 {
        self.passes.iter().filter(|pass| pass.is_geometry()).count() as u32
    }

    /// Full-screen passes of one round, clear and resolve among them.
    #[must_use]
    pub fn full_screen(&self) -> u32 {
        2 + self.passes.len() as u32 - self.geometry()
    }

    /// No pixel waits for another: all passes of one pixel may run before those of the next.
    #[must_use]
    pub fn is_local(&self) -> bool {
        let barriers = self.passes.iter().map(|pass| pass.before).chain([self.before_resolve]);
        barriers.max() != Some(Barrier::Frame)
    }

    /// Every barrier is there.
    #[must_use]
    pub const fn is_complete(&self) -> bool {
        let mut pass = 0;
        while pass < self.passes.len() {
            if matches!(self.passes[pass].before, Barrier::Missing) {
                return false;
            }
            pass += 1;
        }
        !matches!(self.before_resolve, Barrier::Missing)
    }
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
    /// The smallest of every depth; of these, the k smallest in canonical order. It differs from the exact answer
    /// where depths are equal, and says so: what is missing is counted as lost, and no violation.
    Layers,
    /// Every fragment while there are free slots, then none.
    FirstArrivals,
    /// Every fragment, but for some of those behind others that let no light through.
    Visible,
    /// Fewer than every fragment, by a fault of what was published: what is missing is counted as lost, and is no violation.
    Some,
    /// The k smallest in canonical order, with a k for each pixel: the words of the input of that name.
    NearestBy(&'static str),
    /// Records that stand for several fragments each: what [`super::Scheme::expected`] says.
    Merged,
    /// Another answer than the exact one: what [`super::Scheme::expected`] says, if it says. Whether it may depend on
    /// arrival is a matter of the contract's other fields, as ever.
    Approximate(Limit),
}

impl Keeps {
    /// It is another answer than the exact one.
    #[must_use]
    pub const fn is_approximate(self) -> bool {
        matches!(self, Self::Approximate(_))
    }
}

/// Where an approximation is exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Limit {
    /// Nowhere in general.
    Nowhere,
    /// Where k is at least the number of a pixel's fragments: its picture is then the exact one.
    EnoughK,
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
    /// How many fragments there are at every pixel, each count bounded by k.
    Bounded,
}

impl Contract {
    /// What most methods have in common: one store pass, nothing asked of the scene, and no dependence on order. The
    /// rest is for the method to say.
    pub const BASE: Self = Self {
        name: "",
        title: "",
        paper: "",
        section: "",
        form: Form::Correct,
        program: Program::STORE,
        words: "0",
        frame_words: "0",
        published_words: None,
        keeps: Keeps::Nearest,
        identical: true,
        crosses: false,
        settled_overflow: false,
        exact_when: "always",
        arrival_dependent: false,
        racy: false,
        right_depths: false,
        judged: false,
        page: 1,
        ties: "canonical: the smaller data word is nearer",
        overflow: "none",
        needs: "",
        wgsl: None,
        depth_format: None,
        depth_bits: 32,
        data: None,
        default_k: Some(8),
        max_k: u32::MAX / 4,
        max_pixels: u32::MAX,
        demand: Demand::Nothing,
        interlock: false,
        source: "",
    };

    /// What keeps all: no `-k`.
    pub const BASE_ALL: Self = Self {
        keeps: Keeps::All,
        ties: "all kept; canonical after resolve",
        default_k: None,
        max_k: u32::MAX,
        ..Self::BASE
    };

    /// The fragments per pixel that the exact reference keeps to be comparable, for a run with the given k.
    #[must_use]
    pub fn reference_k(&self, k: Option<u32>) -> Option<u32> {
        match self.keeps {
            Keeps::All | Keeps::FirstArrivals | Keeps::Visible | Keeps::Some => None,
            Keeps::Merged | Keeps::Approximate(_) => None,
            Keeps::Nearest | Keeps::NearestBy(_) | Keeps::Layers => k.or(self.default_k),
            Keeps::One => Some(1),
        }
    }

    /// How many of each pixel's nearest fragments it is held to, with the given k and inputs, for so many storage pixels.
    #[must_use]
    pub fn bound(&self, k: Option<u32>, layout: &Layout, inputs: &Inputs, pixels: u32) -> Bound {
        let Keeps::NearestBy(name) = self.keeps else { return Bound::of(self.reference_k(k)) };
        match layout.inputs().iter().position(|input| input.name == name) {
            Some(input) => Bound::PerPixel((0..pixels).map(|p| inputs.word(input, p)).collect()),
            None => Bound::All,
        }
    }

    /// The words that it stores of a fragment, where `depth` and `data` are asked for: its own, where it has room for no
    /// others.
    #[must_use]
    pub fn record(&self, depth: Option<Format>, data: Data) -> Record {
        Record {
            depth: depth.or(self.depth_format).unwrap_or_default(),
            data: self.data.unwrap_or(data),
        }
    }

    /// What is kept of a pixel's sorted keys with the given k, where neither room nor arrival has a say.
    pub fn keep(&self, keys: &mut Vec<u64>, k: Option<u32>) {
        if !self.identical {
            keys.dedup();
        }
        if self.keeps == Keeps::Layers {
            keys.dedup_by_key(|key| depth_of(*key));
        }
        keys.truncate(self.reference_k(k).map_or(usize::MAX, |k| k as usize));
    }

    /// The result does not depend on arrival or interleaving.
    #[must_use]
    pub fn order_independent(&self) -> bool {
        !self.arrival_dependent && !self.racy
    }

    /// Whether WGSL guarantees what the method needs; otherwise its results there may be right, and are not owed.
    #[must_use]
    pub fn is_within_wgsl(&self) -> bool {
        self.wgsl.is_none_or(|how| !how.contains("outside WGSL's guarantees"))
    }

    /// A built-in fault of this method, racy as most are.
    #[must_use]
    pub const fn fault(
        self,
        name: &'static str,
        title: &'static str,
        exact_when: &'static str,
    ) -> Self {
        let (form, racy, right_depths) = (Form::Mutation, true, false);
        Self { name, title, exact_when, form, racy, right_depths, ..self }
    }

    /// The name without `@variant`.
    #[must_use]
    pub fn base_name(&self) -> &'static str {
        self.name.split('@').next().unwrap_or(self.name)
    }
}
