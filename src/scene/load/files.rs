//! Reading files, and what a name's ending says of them.

use std::cell::RefCell;
use std::io::Read;
use std::path::{Path, PathBuf};

use super::super::model::MAX_FILE;
use crate::error::{Error, Result};

/// Reads files, and remembers which.
#[derive(Default)]
pub(super) struct Files {
    pub(super) read: RefCell<Vec<PathBuf>>,
}

impl Files {
    /// The bytes of a file, or of stdin (`-`), unpacked if gzip packed them.
    pub(super) fn read(&self, path: &Path) -> Result<Vec<u8>> {
        let place = place(path);
        if is_stdin(path) {
            return unpacked(stdin()?, &place);
        }
        self.note(path);
        unpacked(read_file(path)?, &place)
    }

    /// Remembers a file that is named, read or not.
    pub(super) fn note(&self, path: &Path) {
        self.read.borrow_mut().push(path.to_path_buf());
    }
}

/// The name of a scene that came in on stdin.
pub const STDIN: &str = "stdin";

/// It stands for what comes in on stdin.
pub(super) fn is_stdin(path: &Path) -> bool {
    path == Path::new("-")
}

/// The name of a file in messages.
pub(super) fn place(path: &Path) -> String {
    if is_stdin(path) { STDIN.to_owned() } else { path.display().to_string() }
}

/// The path of a file named in another file.
pub(super) fn beside(path: &Path, name: &str) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).join(name)
}

/// A whole file, which must be a regular one of at most [`MAX_FILE`] bytes.
fn read_file(path: &Path) -> Result<Vec<u8>> {
    let place = place(path);
    let wrong = |error: std::io::Error| Error::new(&place, format!("cannot be read: {error}"));
    let meta = std::fs::metadata(path).map_err(wrong)?;
    if !meta.is_file() {
        return Err(Error::new(place, "must be a file"));
    }
    if meta.len() > MAX_FILE {
        return Err(Error::new(place, format!("size: must be at most {MAX_FILE} bytes")));
    }
    std::fs::read(path).map_err(wrong)
}

fn stdin() -> Result<Vec<u8>> {
    let wrong = |problem: String| Error::new(STDIN, problem);
    let bytes = all(std::io::stdin().lock()).map_err(|error| {
        wrong(error.map_or_else(|| too_large(""), |error| format!("cannot be read: {error}")))
    })?;
    if bytes.is_empty() { Err(wrong("is empty".to_owned())) } else { Ok(bytes) }
}

/// What gzip packed, if it did.
pub(super) fn unpacked(bytes: Vec<u8>, place: &str) -> Result<Vec<u8>> {
    if !bytes.starts_with(b"\x1F\x8B") {
        return Ok(bytes);
    }
    all(flate2::read::MultiGzDecoder::new(&bytes[..])).map_err(|error| {
        let broken = |_| "gzip: the compressed data are broken".to_owned();
        Error::new(place, error.map_or_else(|| too_large(", unpacked"), broken))
    })
}

/// All bytes, at most [`MAX_FILE`]; no error where there are more.
pub(super) fn all(from: impl Read) -> std::result::Result<Vec<u8>, Option<std::io::Error>> {
    let mut whole = Vec::new();
    from.take(MAX_FILE + 1).read_to_end(&mut whole).map_err(Some)?;
    if whole.len() as u64 > MAX_FILE { Err(None) } else { Ok(whole) }
}

pub(super) fn too_large(when: &str) -> String {
    format!("size: must be at most {MAX_FILE} bytes{when}")
}
