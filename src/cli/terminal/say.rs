//! Output: results to stdout, the rest to stderr. It is no error if the reader has gone away.

use std::io::{self, ErrorKind, Write};

use crate::error::{Error, Result};

/// A whole result.
///
/// # Errors
/// stdout cannot be written, for a reason other than a closed pipe.
pub(in crate::cli) fn result(text: &str) -> Result<()> {
    bytes(text.as_bytes())
}

/// As [`result`], of what is no text.
///
/// # Errors
/// As there.
pub(in crate::cli) fn bytes(bytes: &[u8]) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(bytes).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Error::new("stdout", error.to_string()))
        }
        _ => Ok(()),
    }
}

/// `error: place: problem`.
pub(in crate::cli) fn error(message: &str) {
    line("error", message);
}

/// Something tolerated.
pub(in crate::cli) fn warning(message: &str) {
    line("warning", message);
}

/// Something forbidden that happened.
pub(in crate::cli) fn violation(message: &str) {
    line("violation", message);
}

fn line(kind: &str, message: &str) {
    // There is nowhere left to complain to.
    let _ = writeln!(io::stderr(), "{kind}: {message}");
}
