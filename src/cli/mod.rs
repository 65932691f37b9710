//! The `fragloom` command.
