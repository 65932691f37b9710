//! Numbers that are the same everywhere: 8-bit colour and its rounding, sRGB by table, depth codes and
//! counter-based random numbers.

pub mod color;
pub mod depth;
pub mod random;
