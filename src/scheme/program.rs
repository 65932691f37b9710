//! Programs: the passes that run between clear and resolve, and the barriers between them.

use serde::Serialize;

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

/// Which invocations wait for which between two passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Barrier {
    /// None: only a fault leaves a barrier out. The simulated device and the explorer then let the passes overlap.
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
