//! Methods and their contracts.

pub mod contract;

pub use contract::{Contract, Form, Keeps, contracts};
