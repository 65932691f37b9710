//! Closed things of glass and metal.

pub(super) mod bottles;
pub(super) mod cubes;
pub(super) mod cuboid;
pub(super) mod gears;
pub(super) mod sphere;
pub(super) mod surfels;
