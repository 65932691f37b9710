//! What the loaders of mesh files share.

mod format;
mod plain;
mod polygon;
mod tally;
mod text;

pub use self::format::FileFormat;
pub(super) use self::plain::plain;
pub(super) use self::polygon::Cutter;
pub(super) use self::tally::Tally;
pub(super) use self::text::{decode, lines, without_mark};
