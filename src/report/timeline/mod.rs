//! Timelines for people: as a drawing, and as a page that is stepped through.

mod drawing;
pub mod page;
mod rows;

pub use self::drawing::{MOST_STEPS, picture, svg};
pub use self::page::page;
