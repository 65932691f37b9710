//! Closed things of glass and metal.

pub(super) mod bottles;
pub(super) mod cubes;
pub(super) mod cuboid;
pub(super) mod discs;
pub(super) mod gears;
pub(super) mod sphere;
