//! Numbers that are the same everywhere: 8-bit colour and its rounding, sRGB by table, depth codes,
//! counter-based random numbers and hexadecimal text.

pub mod color;
pub mod depth;
mod hex;
pub mod orders;
pub mod planes;
pub mod random;

pub use hex::hex;
