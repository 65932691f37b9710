//! Faults that can be built into the HA-buffer. Each is one change of the correct form; the numbers are those of
//! [`crate::catalogue::faults`].

use super::{Bits64, CLEAR, CONTRACT, Contract, PROGRAM, Variant};
use crate::scheme::program::{Barrier, Pass, Program};

/// M13: the age is cut to its field, so that it begins again.
#[derive(Debug)]
pub enum AgeOverflows {}

impl Variant<Bits64> for AgeOverflows {
    const CONTRACT: Contract = CONTRACT.fault(
        "ha64@M13",
        "Fault M13: the age is cut to its field and begins again",
        "no age limit is met",
    );
    const LIMITED: bool = false;
}

/// No invocation waits for the clear pass.
#[derive(Debug)]
pub enum NoBarrier {}

impl Variant<Bits64> for NoBarrier {
    const CONTRACT: Contract = Contract {
        program: Program { passes: &[CLEAR, Pass::store(Barrier::Missing)], ..PROGRAM },
        ..CONTRACT.fault(
            "ha64@M17",
            "Fault M17: no barrier between clear and store",
            "no store begins before the table is clear",
        )
    };
}

/// A displaced record is forgotten.
#[derive(Debug)]
pub enum NotReinserted {}

impl Variant<Bits64> for NotReinserted {
    const CONTRACT: Contract = CONTRACT.fault(
        "ha64@no-reinsert",
        "Fault no-reinsert: a record displaced from a cell is forgotten",
        "no record is displaced",
    );
    const REINSERTS: bool = false;
}

/// The largest age of the block is not updated.
#[derive(Debug)]
pub enum AgeUntold {}

impl Variant<Bits64> for AgeUntold {
    const CONTRACT: Contract =
        CONTRACT.fault("ha64@max-age", "Fault max-age: the largest age is not updated", "never");
    const TELLS_AGE: bool = false;
}

/// The pixel of an evicted record is computed with the offset of the evicting record's age.
#[derive(Debug)]
pub enum OffsetReused {}

impl Variant<Bits64> for OffsetReused {
    const CONTRACT: Contract = CONTRACT.fault(
        "ha64@offset",
        "Fault offset: an evicted record's pixel is computed with the evicting record's offset",
        "no record is displaced",
    );
    const OWN_OFFSET: bool = false;
}

/// A load, a comparison and a store instead of the atomic maximum.
#[derive(Debug)]
pub enum LoadStore {}

impl Variant<Bits64> for LoadStore {
    const CONTRACT: Contract = CONTRACT.fault(
        "ha64@load-store",
        "Fault load-store: a load, a comparison and a store for the atomic maximum",
        "no two invocations overlap",
    );
    const ATOMIC: bool = false;
}

/// Records are compared by age and data, without depth.
#[derive(Debug)]
pub enum NoDepth {}

impl Variant<Bits64> for NoDepth {
    const CONTRACT: Contract = CONTRACT.fault(
        "ha64@no-depth",
        "Fault no-depth: records are compared by age and data, without depth",
        "where lists are sorted after all",
    );
    const BY_DEPTH: bool = false;
}

/// The table has as many cells as there are pixels, as the paper asks for, but is narrower than the screen.
#[derive(Debug)]
pub enum Area {}

impl Variant<Bits64> for Area {
    const CONTRACT: Contract = CONTRACT.fault(
        "ha64@area",
        "Fault area: a table of as many cells as there are pixels, and narrower than the screen",
        "no two pixels fold onto each other",
    );
    const COVERS: bool = false;
}
