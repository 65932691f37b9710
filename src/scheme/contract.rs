//! Contracts: what a method promises, as data.

use serde::Serialize;

use super::program::Program;
use crate::fragment::{Data, depth_of};
use crate::num::depth::Format;
use crate::raster::Record;

/// What a method promises.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
    /// Words of 4 bytes per pixel: a sum of products of numbers and of k (`-k`), n (slots: the largest depth complexity,
    /// or `-k`), d (words of an occupancy mask), m (moments) and s (samples).
    pub words: &'static str,
    /// Words of 4 bytes for the frame: as above, with F (fragments of a geometry pass), S (the sum of min(f, k) over
    /// pixels), M (records to divide among pixels), P (pixels), G (blocks of 64 pixels), H (64 such blocks), Q (pages), C (cells of the hash table) and B
    /// (blocks of 8x8 pixels in the picture).
    pub frame_words: &'static str,
    /// Words per pixel as its paper counts them, where it does: without what only our form needs.
    pub published_words: Option<&'static str>,
    /// What a pixel holds after resolve.
    pub keeps: Keeps,
    /// How many it keeps of a pixel's fragments that are wholly alike.
    pub alike: Alike,
    /// Under which condition that equals the exact answer.
    pub exact_when: &'static str,
    /// What the result may depend on.
    pub dependence: Dependence,
    /// How it is known what became of a fragment.
    pub accounting: Accounting,
    /// What happens to fragments of equal depth.
    pub ties: &'static str,
    /// What happens when there is no room.
    pub overflow: Overflow,
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
    /// The most pixels, including those of tiles that the image's edge cuts.
    pub max_pixels: u32,
    /// What it must know of the scene before memory is allocated.
    pub demand: Demand,
    /// Fragments per index of its pool, if it has one.
    pub page: u32,
    /// What its invocations know of a fragment besides depth and data.
    pub extra: Extra,
    /// The text of its source file, by `include_str!`, if it is at hand: random runs try the whole numbers in it as depths
    /// and data words.
    pub source: &'static str,
}

/// How many are kept of a pixel's fragments that are wholly alike, in depth and data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alike {
    /// All of them.
    Each,
    /// One of them; the others are counted as duplicates.
    Once,
}

/// What a result may depend on, besides the fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dependence {
    /// Nothing.
    Nothing,
    /// The order in which fragments arrive.
    Arrival,
    /// How concurrent invocations interleave, even for a given order of arrival: fragments may be lost, doubled or
    /// torn, and a run is judged against the generated multiset.
    Interleaving,
    /// Both.
    ArrivalAndInterleaving,
    /// Both, but only in which of several fragments of equal depth stands for them: the depths that are kept are the
    /// exact ones, and every record is a fragment's.
    Ties,
}

impl Dependence {
    /// It may depend on the order of arrival.
    #[must_use]
    pub const fn on_arrival(self) -> bool {
        matches!(self, Self::Arrival | Self::ArrivalAndInterleaving | Self::Ties)
    }

    /// It may depend on how invocations interleave.
    #[must_use]
    pub const fn on_interleaving(self) -> bool {
        matches!(self, Self::Interleaving | Self::ArrivalAndInterleaving | Self::Ties)
    }

    /// The same dependence, and also on how invocations interleave.
    #[must_use]
    pub const fn racy(self) -> Self {
        if self.on_arrival() { Self::ArrivalAndInterleaving } else { Self::Interleaving }
    }
}

/// How it is known what became of a fragment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Accounting {
    /// Its own invocation reports it.
    Reported,
    /// Invocations cannot tell: the accounting compares lists.
    Judged,
    /// An invocation may end with a fragment of another pixel: what is dropped is known for the frame only, and where
    /// anything was, the accounting compares lists.
    Crossing,
}

/// What happens when there is no room, with the words that describe it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overflow {
    /// There is room for all that the method promises to keep.
    Never(&'static str),
    /// What finds no room is dropped and counted; what that is may depend on arrival.
    Drops(&'static str),
    /// As above, but what finds no room is settled by the fragments alone.
    Settled(&'static str),
}

impl Overflow {
    /// The description.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Never(text) | Self::Drops(text) | Self::Settled(text) => text,
        }
    }
}

/// What an invocation knows of its fragment besides depth and data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extra {
    /// Nothing.
    Nothing,
    /// Its rank: how many fragments of its pixel come before it in API order. Store invocations enter by the ordered
    /// interlock.
    Rank,
    /// The near end of its slab, as a depth word: the depth itself, or nearer by the thickness.
    Near,
    /// The number of its triangle, in API order.
    Primitive,
}

/// Which form of a method this is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// As it must be to keep its promise.
    Correct,
    /// As published, where that differs from the correct form, or where there is no correct form.
    Published,
    /// The correct form with its words reached in another way, for devices that do not order them
    /// ([`super::parts::lock::reach`]).
    Mended,
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
    /// Fewer than every fragment, by a fault of what was published: what is missing is counted as lost, and is no
    /// violation.
    Some,
    /// The k smallest in canonical order, with a k for each pixel: the words of the input of that name.
    NearestBy(&'static str),
    /// The k smallest in canonical order, with a k for each pixel that the method chooses ([`super::Scheme::chosen`]).
    /// `-k` is their average.
    NearestChosen,
    /// No fragment, but a depth behind which none of the k smallest lies.
    Bound,
    /// Records that stand for several fragments each: what [`super::Scheme::expected`] says.
    Merged,
    /// Another answer than the exact one: what [`super::Scheme::expected`] says, if it says. The contract's other
    /// fields say whether it may depend on arrival.
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
    /// How many records it may divide among the pixels: `-k` for each on average, or what a budget allows.
    Records,
}

impl Contract {
    /// A method of this name that keeps that. All the rest has a default: one store pass, reported outcomes, a result
    /// that depends on nothing but the fragments, nothing asked of the scene; and, by what it keeps, whether it takes
    /// `-k` and what becomes of ties.
    ///
    /// ```
    /// use fragloom::scheme::{Contract, Keeps};
    ///
    /// const CONTRACT: Contract = Contract { words: "2k + 1", ..Contract::new("mine", Keeps::Nearest) };
    /// assert_eq!(CONTRACT.default_k, Some(8));
    /// ```
    #[must_use]
    pub const fn new(name: &'static str, keeps: Keeps) -> Self {
        let (takes_k, all, overflow) = match keeps {
            Keeps::All | Keeps::FirstArrivals | Keeps::Visible | Keeps::Some => {
                (false, true, "none")
            }
            Keeps::One => (false, false, "none"),
            Keeps::NearestBy(_) => (false, false, "the farthest is evicted"),
            Keeps::Nearest | Keeps::NearestChosen | Keeps::Layers => {
                (true, false, "the farthest is evicted")
            }
            Keeps::Bound => (true, false, "none"),
            Keeps::Merged | Keeps::Approximate(Limit::Nowhere) => (false, false, "none"),
            Keeps::Approximate(Limit::EnoughK) => (true, false, "none"),
        };
        Self {
            name,
            title: "",
            paper: "",
            section: "",
            form: Form::Correct,
            program: Program::STORE,
            words: "0",
            frame_words: "0",
            published_words: None,
            keeps,
            alike: Alike::Each,
            exact_when: "always",
            dependence: Dependence::Nothing,
            accounting: Accounting::Reported,
            page: 1,
            ties: if all {
                "all kept; canonical after resolve"
            } else {
                "canonical: the smaller data word is nearer"
            },
            overflow: Overflow::Never(overflow),
            needs: "",
            wgsl: None,
            depth_format: None,
            depth_bits: 32,
            data: None,
            default_k: if takes_k { Some(8) } else { None },
            max_k: if takes_k { u32::MAX / 4 } else { u32::MAX },
            max_pixels: u32::MAX,
            demand: Demand::Nothing,
            extra: Extra::Nothing,
            source: "",
        }
    }

    /// The result may depend on how concurrent invocations interleave.
    #[must_use]
    pub const fn is_racy(&self) -> bool {
        self.dependence.on_interleaving()
    }

    /// The result may depend on the order of arrival.
    #[must_use]
    pub const fn is_arrival_dependent(&self) -> bool {
        self.dependence.on_arrival()
    }

    /// Racy or not, the depths that it keeps are the exact ones, and every record is a fragment's.
    #[must_use]
    pub const fn has_right_depths(&self) -> bool {
        matches!(self.dependence, Dependence::Ties)
    }

    /// An invocation may end with a fragment of another pixel.
    #[must_use]
    pub const fn crosses(&self) -> bool {
        matches!(self.accounting, Accounting::Crossing)
    }

    /// The accounting compares lists, since invocations cannot tell.
    #[must_use]
    pub const fn is_judged(&self) -> bool {
        matches!(self.accounting, Accounting::Judged)
    }

    /// What finds no room is settled by the fragments alone.
    #[must_use]
    pub const fn settles_overflow(&self) -> bool {
        matches!(self.overflow, Overflow::Settled(_))
    }

    /// It keeps all of a pixel's fragments that are wholly alike.
    #[must_use]
    pub const fn keeps_alike(&self) -> bool {
        matches!(self.alike, Alike::Each)
    }

    /// Its storage depends on the scene, so that it can be configured for fewer fragments than there are; and then it
    /// drops some, although it promises them.
    #[must_use]
    pub const fn is_pooled(&self) -> bool {
        let nearest = matches!(self.keeps, Keeps::Nearest | Keeps::NearestChosen);
        !matches!(self.demand, Demand::Nothing) && !nearest
    }

    /// Its storage depends on k, so that a budget of bytes chooses it. Where all fragments are stored and merged later, it
    /// does not.
    #[must_use]
    pub const fn budget_chooses_k(&self) -> bool {
        let stores_all = matches!(self.keeps, Keeps::Merged) && self.is_pooled();
        self.default_k.is_some() && !stores_all
    }

    /// It needs the ordered interlock.
    #[must_use]
    pub const fn is_interlocked(&self) -> bool {
        matches!(self.extra, Extra::Rank)
    }

    /// Its fragments are slabs.
    #[must_use]
    pub const fn has_slabs(&self) -> bool {
        matches!(self.extra, Extra::Near)
    }

    /// What its fragments have besides depth and data is their own, whatever the order of arrival.
    #[must_use]
    pub const fn has_third_word(&self) -> bool {
        matches!(self.extra, Extra::Near | Extra::Primitive)
    }

    /// The fragments per pixel that the exact reference keeps to be comparable, for a run with the given k.
    #[must_use]
    pub fn reference_k(&self, k: Option<u32>) -> Option<u32> {
        match self.keeps {
            Keeps::All | Keeps::FirstArrivals | Keeps::Visible | Keeps::Some => None,
            Keeps::Merged | Keeps::Approximate(_) => None,
            Keeps::NearestChosen => k,
            Keeps::Nearest | Keeps::NearestBy(_) | Keeps::Layers | Keeps::Bound => {
                k.or(self.default_k)
            }
            Keeps::One => Some(1),
        }
    }

    /// The words that it stores of a fragment, if `depth` and `data` are requested: its own, where it has room for no
    /// others.
    #[must_use]
    pub fn record(&self, depth: Option<Format>, data: Data) -> Record {
        Record {
            depth: depth.or(self.depth_format).unwrap_or_default(),
            data: self.data.unwrap_or(data),
        }
    }

    /// What is kept of a pixel's sorted keys with the given k, where neither room nor arrival matters.
    pub fn keep(&self, keys: &mut Vec<u64>, k: Option<u32>) {
        if !self.keeps_alike() {
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
        matches!(self.dependence, Dependence::Nothing)
    }

    /// Whether WGSL guarantees what the method needs; otherwise its results there may be right, but are not guaranteed.
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
        let dependence = self.dependence.racy();
        Self { name, title, exact_when, form: Form::Mutation, dependence, ..self }
    }

    /// This method with its words reached in another way.
    #[must_use]
    pub const fn mended(self, name: &'static str, title: &'static str) -> Self {
        Self { name, title, form: Form::Mended, ..self }
    }

    /// The name without `@variant`.
    #[must_use]
    pub fn base_name(&self) -> &'static str {
        self.name.split('@').next().unwrap_or(self.name)
    }
}
