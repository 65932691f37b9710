//! `fragloom judge`: pictures that are wrong on purpose, made by code of their own, and what they are called.

mod confusion;
mod files;
#[cfg(feature = "gpu")]
mod hardware;
mod kinds;
mod laws;
mod unforeseen;
mod wrong;

#[path = "../support/command.rs"]
mod command;
#[path = "../support/mod.rs"]
mod support;
