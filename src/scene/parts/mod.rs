//! What the loaders of mesh files share.

mod format;
mod pieces;
mod plain;
mod polygon;
mod tally;
mod text;

pub use self::format::FileFormat;
pub(super) use self::pieces::{PIECE, first, in_order, pieces};
pub(super) use self::plain::plain;
pub(super) use self::polygon::Cutter;
pub(super) use self::tally::Tally;
pub(super) use self::text::{decode, ends_line, first_line, lines, without_mark};
