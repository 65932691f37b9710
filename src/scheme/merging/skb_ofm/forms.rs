//! The forms: the right one, those of the paper and of its authors' shaders, and faults that can be built in.

use super::{Kind, Tail};
use crate::scheme::Contract;
use crate::scheme::contract::{Dependence, Form, Overflow};
use crate::scheme::merging::merging;
use crate::scheme::merging::sums::{Bytes, Floats, Integers};
use crate::scheme::parts::lock;

const CONTRACT: Contract = Contract {
    title: "k+-buffer that merges overlapping slabs on arrival, with a tail",
    section: "3.2.2, 3.3.2, 4.1.2, 4.2",
    words: "8k + 3",
    published_words: Some("4k + 1"),
    exact_when: "k >= f(p) and no slabs overlap",
    dependence: Dependence::Arrival,
    ties: "canonical among surfaces of equal depth; slabs of equal depth are merged",
    overflow: Overflow::Never("the farthest record is mixed into the tail, the last record"),
    needs: lock::NEEDS,
    wgsl: lock::WGSL,
    source: include_str!("../skb_ofm.rs"),
    ..merging("skb+ofm")
};

const fn fault(name: &'static str, title: &'static str) -> Contract {
    Contract { name, title, form: Form::Mutation, ..CONTRACT }
}

macro_rules! kinds {
    ($($(#[$doc:meta])* $name:ident: $mix:ty, $contract:expr $(, $const:ident: $type:ty = $value:expr)*;)*) => {$(
        $(#[$doc])*
        #[derive(Debug)]
        pub struct $name;

        impl Kind for $name {
            const CONTRACT: Contract = $contract;
            type Mix = $mix;
            $(const $const: $type = $value;)*
        }
    )*};
}

kinds! {
    /// The method.
    Exact: Integers, CONTRACT;
    /// As published.
    Published: Floats, Contract {
        name: "skb+ofm@published",
        title: "as published: colour and opacity by the recurrence, in single precision",
        form: Form::Published,
        ..CONTRACT
    };
    /// As in the authors' shaders.
    Released: Bytes, Contract {
        name: "skb+ofm@released",
        title: "as the authors' shaders: one overlap, four bytes, a far plane at 100",
        section: "the authors' shaders",
        form: Form::Published,
        ..CONTRACT
    }, FIRST_ONLY: bool = true, FAR: Option<f64> = Some(100.0);
    /// The tail is mixed outside of the critical section.
    TailOutside: Integers, fault(
        "skb+ofm@M10", "Fault M10: the tail is mixed after the lock is released"
    ), TAIL: Tail = Tail::Outside;
    /// Nothing is evicted into the tail.
    NotEvicting: Integers, fault(
        "skb+ofm@M10-arrival", "Fault M10: what arrives is mixed into the tail, near or far"
    ), TAIL: Tail = Tail::NotEvicting;
    /// Four bytes in mid-stream.
    EightBits: Bytes, fault(
        "skb+ofm@M15", "Fault M15: colour and opacity are rounded to 8 bits at every merge"
    );
    /// Only the first record that overlaps is joined.
    FirstOnly: Integers, fault(
        "skb+ofm@first-overlap", "Fault first-overlap: only the first record that overlaps is joined"
    ), FIRST_ONLY: bool = true;
    /// Slabs that touch are merged.
    Closed: Integers, fault(
        "skb+ofm@closed", "Fault closed: slabs that only touch are merged"
    ), CLOSED: bool = true;
}
