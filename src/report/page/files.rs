//! The page's own files.

/// The frame, with `{{...}}` where something is put in.
pub(super) const FRAME: &str = include_str!("web/index.html");

/// How it looks.
pub(super) const STYLE: &[&str] = &[
    include_str!("web/page.css"),
    include_str!("web/viewer.css"),
    include_str!("web/timeline.css"),
];

/// What it does: one script, in this order.
pub(super) const SCRIPTS: &[&str] = &[
    include_str!("web/elements.js"),
    include_str!("web/table.js"),
    include_str!("web/blocks.js"),
    include_str!("web/plot.js"),
    include_str!("web/inspector.js"),
    include_str!("web/viewer.js"),
    include_str!("web/timeline.js"),
    include_str!("web/page.js"),
];
