//! Which fragments of a pixel are blended, and in which order.

use crate::judge::answer::{Entry, Facts};
use crate::num::depth::Format;

/// A selection and an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(in crate::judge) enum Fragments {
    /// All, or the k nearest, sorted by depth.
    #[default]
    Right,
    /// All, whatever k is.
    All,
    /// The nearest so many.
    Nearest(u32),
    /// Those that were submitted first, so many, sorted by depth.
    First(u32),
    /// Back to front taken for front to back.
    Reversed,
    /// Each over those that were submitted before.
    Submitted,
    /// Each under those that were submitted before.
    SubmittedUnder,
    /// Triangles as wholes, the nearest middle in front.
    Triangles,
    /// Objects as wholes, the nearest middle in front; within an object, each over those submitted before.
    Objects,
    /// In the order of submission, but those that lie behind one that was drawn before are left out: the depth buffer is
    /// written.
    DepthWritten {
        /// What is at the same depth is drawn, too.
        or_equal: bool,
    },
    /// The farthest one alone.
    Farthest,
    /// Where depths are equal, the first submitted is in front.
    TiesFirst,
    /// Where depths are equal, the last submitted is in front.
    TiesLast,
    /// Without those of back faces.
    NoBacks,
    /// Without those of front faces.
    NoFronts,
    /// Without those on the near plane.
    NoNear,
    /// Without those on the far plane.
    NoFar,
}

/// What arranging needs to know.
#[derive(Clone, Copy)]
pub(in crate::judge) struct Scope<'a> {
    /// Fragments kept per pixel, the nearest.
    pub(in crate::judge) k: Option<u32>,
    /// By triangle.
    pub(in crate::judge) facts: &'a [Facts],
    /// Of depth words.
    pub(in crate::judge) format: Format,
}

impl Fragments {
    /// Put `list`, which is sorted, into this order, front to back.
    pub(in crate::judge) fn arrange(self, scope: Scope<'_>, list: &mut Vec<Entry>) {
        let fact = |entry: &Entry| scope.facts[entry.triangle as usize];
        match self {
            Self::Right | Self::All | Self::Nearest(_) => {}
            Self::First(n) => {
                list.sort_by_key(|entry| entry.triangle);
                list.truncate(n as usize);
                list.sort_unstable();
            }
            Self::Reversed => {
                list.truncate(scope.most());
                list.reverse();
            }
            Self::Submitted => list.sort_by_key(|entry| !entry.triangle),
            Self::SubmittedUnder => list.sort_by_key(|entry| entry.triangle),
            Self::Triangles => list.sort_by(|a, b| {
                let middles = fact(a).middle.total_cmp(&fact(b).middle);
                middles.then(b.triangle.cmp(&a.triangle))
            }),
            Self::Objects => list.sort_by(|a, b| {
                let middles = fact(a).object.total_cmp(&fact(b).object);
                middles.then(b.triangle.cmp(&a.triangle))
            }),
            Self::DepthWritten { or_equal } => {
                list.sort_by_key(|entry| entry.triangle);
                let mut nearest = u32::MAX;
                list.retain(|entry| {
                    let passes = entry.depth < nearest || or_equal && entry.depth == nearest;
                    nearest = nearest.min(entry.depth);
                    passes
                });
                list.reverse();
            }
            Self::Farthest => {
                let last = list.len().saturating_sub(1);
                list.drain(..last);
            }
            Self::TiesFirst => list.sort_by_key(|entry| (entry.depth, entry.triangle)),
            Self::TiesLast => list.sort_by_key(|entry| (entry.depth, !entry.triangle)),
            Self::NoBacks => list.retain(|entry| !fact(entry).back),
            Self::NoFronts => list.retain(|entry| fact(entry).back),
            Self::NoNear => list.retain(|entry| entry.depth > scope.format.encode(0)),
            Self::NoFar => {
                let farthest = scope.format.encode(crate::num::depth::FARTHEST);
                list.retain(|entry| entry.depth < farthest);
            }
        }
        match self {
            Self::NoBacks | Self::NoFronts | Self::NoNear | Self::NoFar => {
                list.truncate(scope.most());
            }
            _ => list.truncate(self.most(scope)),
        }
    }

    /// Of a list in the order in which fragments are blended, how many are kept.
    pub(in crate::judge) fn most(self, scope: Scope<'_>) -> usize {
        match self {
            Self::Nearest(n) => n as usize,
            Self::Right | Self::TiesFirst | Self::TiesLast => scope.most(),
            _ => usize::MAX,
        }
    }

    /// Whether a sorted list is in the order in which fragments are blended.
    pub(in crate::judge) fn is_sorted(self) -> bool {
        matches!(self, Self::Right | Self::All | Self::Nearest(_))
    }

    /// In words, after "as if"; empty if right.
    pub(super) fn name(self) -> String {
        let text = match self {
            Self::Right => "",
            Self::All => "all fragments were kept, and not the k nearest",
            Self::Nearest(1) => "the nearest fragment alone were kept",
            Self::Nearest(n) => return format!("the {n} nearest fragments were kept"),
            Self::First(1) => "the fragment submitted first were kept alone",
            Self::First(n) => return format!("the {n} fragments submitted first were kept"),
            Self::Reversed => "back to front were taken for front to back",
            Self::Submitted => "fragments were blended in the order of submission, unsorted",
            Self::SubmittedUnder => "fragments were blended in the reverse order of submission",
            Self::Triangles => "whole triangles were sorted by the depth of their middle",
            Self::Objects => "whole objects were sorted by the depth of their middle",
            Self::DepthWritten { or_equal: false } => "the depth buffer were written (test: less)",
            Self::DepthWritten { or_equal: true } => {
                "the depth buffer were written (test: less or equal)"
            }
            Self::Farthest => "the farthest fragment alone were kept",
            Self::TiesFirst => "at equal depths, the first submitted were in front",
            Self::TiesLast => "at equal depths, the last submitted were in front",
            Self::NoBacks => "back faces were left out",
            Self::NoFronts => "front faces were left out",
            Self::NoNear => "fragments on the near plane were left out",
            Self::NoFar => "fragments on the far plane were left out",
        };
        text.to_owned()
    }
}

impl Scope<'_> {
    /// k as a length.
    fn most(&self) -> usize {
        self.k.map_or(usize::MAX, |k| k as usize)
    }
}
