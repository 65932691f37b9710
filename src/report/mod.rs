//! Results for people and for programs: tables, JSON, NumPy files, and writing files whole or not at all.

pub mod contents;
pub mod errors;
pub mod expected;
pub mod files;
pub mod grid;
pub mod inspection;
pub mod json;
pub mod npz;
pub mod page;
pub mod picture;
pub mod stability;
pub mod table;
pub mod text;
pub mod timeline;
pub mod verdicts;
