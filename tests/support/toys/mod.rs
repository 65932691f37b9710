//! Schemes of the tests' own, one for each kind of method that the catalogue does not have: they go through the same
//! battery as the built-in ones.
#![allow(dead_code, reason = "each test file uses its own part")]

pub(crate) mod blend;
pub(crate) mod blend_nearest;
pub(crate) mod k_from_image;
#[path = "../../../examples/merge_two.rs"]
#[allow(dead_code, reason = "its main function")]
pub(crate) mod merge_two;

use fragloom::catalogue::Catalogue;
use fragloom::exec::Method;

/// The built-in methods, and these.
pub(crate) fn catalogue() -> Catalogue {
    let toys = [
        Method::of::<merge_two::MergeTwo>(),
        Method::of::<blend::BlendAverage<true>>(),
        Method::of::<blend_nearest::BlendNearest>(),
        Method::of::<k_from_image::KFromImage<true>>(),
    ];
    toys.into_iter().fold(Catalogue::built_in(), |all, toy| all.with(toy).expect("a new name"))
}
