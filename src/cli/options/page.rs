//! A page for browsers as an output.

use std::ffi::OsStr;
use std::path::Path;

use crate::error::{Error, Result};
use crate::report::files;
use crate::report::page::Page;

/// Check that a page can be written at `path`: a file whose name ends in `.html`, or something that is no file.
///
/// # Errors
/// `option`, the path and what would be right.
pub(in crate::cli) fn check(option: &str, path: &Path) -> Result<()> {
    let special = path.exists() && !path.is_file() && !path.is_dir();
    let ending = path.extension().map(OsStr::to_ascii_lowercase);
    if !special && ending.is_none_or(|ending| ending != "html" && ending != "htm") {
        return Err(Error::new(option, format!("{} must end in .html", path.display())));
    }
    files::check_output(option, path)
}

/// Write a page, whole or not at all.
///
/// # Errors
/// The path and the operating system's reason.
pub(in crate::cli) fn write(path: &Path, page: &Page) -> Result<()> {
    files::write(path, |file| page.write(file))
}
