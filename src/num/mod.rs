//! Numbers that are the same everywhere: 8-bit colour and its rounding, sRGB by table, compositing in 16 bits, depth
//! codes, loops over lanes, counters of bits, counter-based random numbers, bounds of rates, hexadecimal text, and arrays
//! in NumPy files.

pub mod color;
pub mod columns;
pub mod depth;
mod hex;
pub mod lanes;
pub mod npy;
pub mod orders;
pub mod planes;
pub mod random;
pub mod rate;
pub mod ray;
pub mod rays;

pub use hex::hex;
