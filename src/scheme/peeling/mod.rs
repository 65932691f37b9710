//! Depth peeling: one layer, two layers or one layer per bucket of depth in each pass over the geometry.

pub mod depth_peel;
pub mod depth_peel_bucket;
pub mod depth_peel_dual;

use super::contract::{Accounting, Contract, Keeps};
use super::program::{Barrier, Pass, Program};

/// A round.
const ROUND: &[Pass] = &[Pass::store(Barrier::Pixel)];

/// What depth peeling has in common: rounds of a store pass, in which no invocation can tell what became of its
/// fragment.
const fn peeled(name: &'static str, keeps: Keeps) -> Contract {
    Contract {
        section: "k+-buffer paper, 2",
        program: Program::repeated(ROUND),
        accounting: Accounting::Judged,
        ..Contract::new(name, keeps)
    }
}
