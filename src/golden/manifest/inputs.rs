//! The files that pictures are drawn from: their hashes, and their paths as a manifest has them.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, ErrorKind, Read};
use std::path::{Component, Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use sha2::{Digest, Sha256};

use super::entry::Input;
use crate::error::{Error, Result};
use crate::num::hex;

/// Bytes read at once.
const CHUNK: usize = 1 << 16;

/// Hashes of files, each computed once.
#[derive(Debug, Default)]
pub(in crate::golden) struct Hashes {
    known: Mutex<BTreeMap<PathBuf, Option<String>>>,
}

impl Hashes {
    /// SHA-256 of a file, hexadecimal; `None` if it is not there.
    ///
    /// # Errors
    /// It is there, and cannot be read.
    pub(in crate::golden) fn of(&self, path: &Path) -> Result<Option<String>> {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned();
        if let Some(known) = known {
            return Ok(known);
        }
        let found = match hash(path) {
            Ok(found) => Some(found),
            Err(error)
                if [ErrorKind::NotFound, ErrorKind::NotADirectory].contains(&error.kind()) =>
            {
                None
            }
            Err(error) => {
                let problem = format!("cannot be read: {error}");
                return Err(Error::new(path.display().to_string(), problem));
            }
        };
        let mut all = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        all.insert(path.to_path_buf(), found.clone());
        Ok(found)
    }
}

fn hash(path: &Path) -> io::Result<String> {
    let (mut file, mut hasher) = (File::open(path)?, Sha256::new());
    let mut chunk = vec![0; CHUNK];
    loop {
        match file.read(&mut chunk)? {
            0 => return Ok(hex(&hasher.finalize())),
            count => hasher.update(&chunk[..count]),
        }
    }
}

/// These files as a manifest in `folder` has them, each once, in their order.
///
/// # Errors
/// One that cannot be read.
pub(in crate::golden) fn inputs(
    files: &[PathBuf],
    folder: &Path,
    hashes: &Hashes,
) -> Result<Vec<Input>> {
    let mut all: Vec<Input> = Vec::new();
    for path in files {
        let file = relative(path, folder);
        if all.iter().all(|input| input.file != file) {
            all.push(Input { file, sha256: hashes.of(path)? });
        }
    }
    Ok(all)
}

/// A path as seen from a folder, with `/` between folders. Where nothing but the root is common to both, it is absolute.
#[must_use]
pub fn relative(path: &Path, folder: &Path) -> String {
    let [path, folder] = [path, folder].map(known);
    let (own, from): (Vec<_>, Vec<_>) =
        (path.components().collect(), folder.components().collect());
    let common = own.iter().zip(&from).take_while(|(a, b)| a == b).count();
    let named = own[..common].iter().any(|part| matches!(part, Component::Normal(_)));
    if !named && path.is_absolute() {
        return slashes(&path);
    }
    let up = from[common..].iter().map(|_| Component::ParentDir);
    slashes(&up.chain(own[common..].iter().copied()).collect::<PathBuf>())
}

/// A path as the system knows it, without links; as far as it exists.
fn known(path: &Path) -> PathBuf {
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    for around in absolute.ancestors() {
        if let (Ok(known), Ok(rest)) =
            (std::fs::canonicalize(around), absolute.strip_prefix(around))
        {
            return if rest.as_os_str().is_empty() { known } else { known.join(rest) };
        }
    }
    absolute
}

fn slashes(path: &Path) -> String {
    let text = path.display().to_string();
    if std::path::MAIN_SEPARATOR == '/' {
        text
    } else {
        text.replace(std::path::MAIN_SEPARATOR, "/")
    }
}
