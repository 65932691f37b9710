//! The `fragloom` command.

use std::process::ExitCode;

use fragloom::catalogue::Catalogue;

fn main() -> ExitCode {
    fragloom::cli::main(&Catalogue::built_in())
}
