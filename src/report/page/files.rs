//! The page's own files.

/// The frame, with `{{...}}` where something is put in.
pub(super) const FRAME: &str = include_str!("index.html");

/// How it looks.
pub(super) const STYLE: &[&str] =
    &[include_str!("page.css"), include_str!("viewer.css"), include_str!("timeline.css")];

/// What it does: one script, in this order.
pub(super) const SCRIPTS: &[&str] = &[
    include_str!("elements.js"),
    include_str!("table.js"),
    include_str!("blocks.js"),
    include_str!("plot.js"),
    include_str!("inspector.js"),
    include_str!("viewer.js"),
    include_str!("timeline.js"),
    include_str!("page.js"),
];
