//! The `fragloom` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    fragloom::cli::main()
}
