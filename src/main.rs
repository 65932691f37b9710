//! The `fragloom` command.

fn main() {}
