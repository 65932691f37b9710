//! The built-in faults, as data: mistakes of shaders in the wild, and the variants of methods here that make the same
//! mistakes, so that checks can be shown to find them.
//!
//! M1 to M19 were seen in public code. Faults with a name instead of a number are controls of our own.

use serde::Serialize;

/// A fault, and the methods that have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Mutation {
    /// M1 to M19, or a name.
    pub id: &'static str,
    /// One line.
    pub text: &'static str,
    /// The methods of the catalogue that have it.
    pub variants: &'static [&'static str],
    /// Why no method has it, if none does.
    pub absent: Option<&'static str>,
}

pub(crate) const fn built_in(
    id: &'static str,
    text: &'static str,
    variants: &'static [&'static str],
) -> Mutation {
    Mutation { id, text, variants, absent: None }
}

const fn absent(id: &'static str, text: &'static str, why: &'static str) -> Mutation {
    Mutation { id, text, variants: &[], absent: Some(why) }
}

/// All of them, numbered ones first.
pub const MUTATIONS: &[Mutation] = &[
    built_in(
        "M1",
        "unlock by a plain or relaxed store, without a barrier",
        &["kplus-array@M1", "kplus-array@M1-relaxed", "kplus-heap@M1", "ab-ll-paged@M1"],
    ),
    built_in(
        "M2",
        "lock or unlock by a relaxed read-modify-write",
        &["kplus-array@M2", "kplus-array@M2-acquire"],
    ),
    built_in("M3", "a spin cap that drops the fragment silently", &["kplus-array@M3"]),
    built_in("M4", "a time-out that frees a lock it does not own", &["kplus-array@M4"]),
    built_in(
        "M5",
        "clearing the pixel outside the lock when the counter is 0",
        &["kplus-array@M5"],
    ),
    built_in(
        "M6",
        "an early-out that reads counter, then farthest, in no order with their writes",
        &["kplus-array@M6", "kplus-array@M6-early-count", "kplus-heap@M6"],
    ),
    built_in(
        "M7",
        "resolve sorts the first N of a list instead of the nearest N",
        &["kb-ab-ll@M7"],
    ),
    built_in("M8", "overflow drops by arrival", &["kplus-heap@M8"]),
    built_in("M9", "equal depth stops the insertion", &["kplus-array@M9", "kplus-heap@M9"]),
    built_in(
        "M10",
        "the tail is blended outside the critical section, or without evicting",
        &["skb+ofm@M10", "skb+ofm@M10-arrival"],
    ),
    built_in(
        "M11",
        "a node is published before it is written (equivalent if no invocation reads it: ab-ll)",
        &["ab-ll@M11", "ab-ll-double@M11", "kb-ll@M11"],
    ),
    absent(
        "M12",
        "a switch between ordered and unordered that is not connected",
        "needs an ordered form: no such method yet",
    ),
    built_in("M13", "the age field overflows", &["ha64@M13"]),
    built_in(
        "M14",
        "a bound test with <= for <",
        &["ab-array@M14", "ab-ll@M14", "s-buffer@M14", "ab-ll-paged@M14"],
    ),
    built_in("M15", "a merge quantised to 8 bits in mid-stream", &["dfb+sfm@M15", "skb+ofm@M15"]),
    built_in(
        "M16",
        "depth computed by two formulas in two passes",
        &["kb-mdt32@M16", "ab-ll-bucket@M16"],
    ),
    built_in(
        "M17",
        "a missing barrier between clear, store and resolve",
        &[
            "kplus-array@M17",
            "kplus-array@M17-resolve",
            "s-buffer@M17",
            "ab-ll-bucket@M17",
            "ha64@M17",
            "k-variable@M17",
        ],
    ),
    built_in(
        "M18",
        "the far plane is rejected by the initial value 1.0",
        &["z-buffer@M18", "kb-mdt64@M18"],
    ),
    built_in("M19", "an unbounded spin under lockstep", &["kplus-array@M19"]),
    built_in("one-test", "no second cull test inside the lock", &["kplus-array@one-test"]),
    built_in(
        "root-first",
        "the farthest entry is overwritten before the new farthest is found",
        &["kplus-array@root-first", "kplus-heap@root-first"],
    ),
    built_in(
        "published-fixed-unlock",
        "the published form with only the lock repaired",
        &["kplus-array@published-fixed-unlock"],
    ),
    built_in(
        "plain-counter",
        "a counter raised by a load and a store",
        &["ab-array@plain-counter"],
    ),
    built_in("no-lock", "slot and page taken without the lock", &["ab-ll-paged@no-lock"]),
    built_in("open-end", "the far end of a range in no bucket", &["ab-ll-bucket@open-end"]),
    built_in(
        "relaxed",
        "a node published by an operation that orders nothing",
        &["ab-ll-double@relaxed", "kb-ll@relaxed"],
    ),
    built_in("plain-head", "a head replaced by a load and a store", &["ab-ll@plain-head"]),
    built_in(
        "load-store",
        "a load, a comparison and a store for an atomic minimum or maximum",
        &["z-buffer@load-store", "kb-mdt64@load-store", "ha64@load-store"],
    ),
    built_in("plain-count", "a count pass of loads and stores", &["s-buffer@plain-count"]),
    built_in(
        "leaves-early",
        "the interlock is left before the entries are written",
        &["kb-ps@leaves-early"],
    ),
    built_in(
        "not-strict",
        "peeling with <= for <: the last layer is emitted again and again",
        &["depth-peel@not-strict"],
    ),
    built_in(
        "near-plane",
        "the first layer must lie strictly behind depth 0",
        &["depth-peel@near-plane"],
    ),
    built_in(
        "middle-twice",
        "the layer where both ends of dual peeling meet is emitted twice",
        &["depth-peel-dual@middle-twice"],
    ),
    built_in(
        "cut",
        "identical fragments that a round has no room for are forgotten",
        &["kplus-multi@cut"],
    ),
    built_in(
        "unverified",
        "a pass without synchronisation, and none that verifies it",
        &["kb-multi@unverified"],
    ),
    built_in("no-reinsert", "a record displaced from its cell is forgotten", &["ha64@no-reinsert"]),
    built_in("max-age", "the largest age of a block is not updated", &["ha64@max-age"]),
    built_in(
        "offset",
        "an evicted record's pixel is computed with the evicting record's offset",
        &["ha64@offset"],
    ),
    built_in(
        "area",
        "a table of as many cells as there are pixels, but narrower than the screen",
        &["ha64@area"],
    ),
    built_in("no-depth", "records are compared without depth", &["ha64@no-depth"]),
    built_in(
        "rounded",
        "shares of a budget are rounded to the nearest: their sum exceeds it",
        &["k-variable@rounded"],
    ),
    built_in(
        "float-quotient",
        "shares of a budget are quotients of floats over a sum of rounded ones",
        &["k-variable@float-quotient"],
    ),
    built_in(
        "stale-count",
        "the fragments of one frame are counted for the next",
        &["k-variable@stale-count"],
    ),
    built_in(
        "near-end",
        "a bound is the near end of its interval instead of the far end",
        &["occupancy@near-end"],
    ),
    built_in("one-too-near", "a bound is one interval too near", &["occupancy@one-too-near"]),
    built_in("ends-early", "the walk over set bits ends one too early", &["occupancy@ends-early"]),
    built_in(
        "first-overlap",
        "a slab is merged with the first record that it overlaps, and not with the others",
        &["skb+ofm@first-overlap"],
    ),
    built_in("closed", "slabs that only touch are merged", &["dfb+sfm@closed", "skb+ofm@closed"]),
    built_in(
        "front-beta",
        "beta counts for the front part of a slab alone",
        &["dfb+sfm@front-beta"],
    ),
    built_in("squared", "shares of a slab's thickness are squared", &["dfb+sfm@squared"]),
    built_in("mixed-tail", "a sorted tail is mixed, not put behind", &["dfb+sfm@mixed-tail"]),
    built_in(
        "constant-weight",
        "a constant weight is left in: colours are gathered without regard to depth",
        &["wboit@constant-weight"],
    ),
    built_in(
        "premultiplied-twice",
        "a colour is multiplied by its opacity twice",
        &["wboit@premultiplied-twice"],
    ),
    built_in("eight-bits", "a transmittance is accumulated in 8 bits", &["wboit@eight-bits"]),
    built_in("opacity-sum", "opacities of merged nodes are added", &["mlab@opacity-sum"]),
    built_in("farther-depth", "a merged node keeps the farther depth", &["mlab@farther-depth"]),
    built_in("tail-alpha", "the opacity is left out of the tail's colour", &["hybrid@tail-alpha"]),
    built_in(
        "same-samples",
        "all fragments of a pixel draw the same random numbers",
        &["stochastic@same-samples"],
    ),
    built_in(
        "braces",
        "early culling with the age raised at the end of every iteration, as listed",
        &["ha64-cull@braces"],
    ),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::Catalogue;
    use crate::scheme::{Contract, Form};

    fn faulty() -> Vec<&'static Contract> {
        Catalogue::built_in().contracts().filter(|c| c.form == Form::Mutation).collect()
    }

    #[test]
    fn every_fault_of_the_catalogue_belongs_to_one_mutation() {
        for contract in faulty() {
            let of: Vec<_> =
                MUTATIONS.iter().filter(|m| m.variants.contains(&contract.name)).collect();
            assert_eq!(of.len(), 1, "{}: {of:?}", contract.name);
            let said = format!("Fault {}: ", of[0].id);
            assert!(contract.title.starts_with(&said), "{}: {}", contract.name, contract.title);
        }
    }

    #[test]
    fn every_variant_exists() {
        let names: Vec<_> = faulty().into_iter().map(|c| c.name).collect();
        for mutation in MUTATIONS {
            let unknown = mutation.variants.iter().find(|name| !names.contains(name));
            assert_eq!(unknown, None, "{}", mutation.id);
        }
    }

    #[test]
    fn names_begin_with_their_mutation() {
        for mutation in MUTATIONS {
            for name in mutation.variants {
                let fault = name.split('@').nth(1).expect("a fault");
                let rest = fault.strip_prefix(mutation.id);
                assert!(rest.is_some_and(|r| r.is_empty() || r.starts_with('-')), "{name}");
            }
        }
    }

    #[test]
    fn the_numbered_ones_are_all_there_and_absence_has_a_reason() {
        for (number, mutation) in (1..=19).zip(MUTATIONS) {
            assert_eq!(mutation.id, format!("M{number}"));
        }
        assert!(MUTATIONS.iter().all(|m| m.variants.is_empty() == m.absent.is_some()));
    }
}
