//! The manifest: a TOML file that people read and write, too. What changes in it changes line by line; comments stay.

mod edit;
mod entry;
mod inputs;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use sha2::{Digest, Sha256};
use toml_edit::DocumentMut;

use self::entry::RawEntry;
pub use self::entry::{Entry, Input, Results};
pub use self::inputs::relative;
pub(super) use self::inputs::{Hashes, inputs};
use crate::error::{Error, Result};
use crate::num::hex;

/// The name of a manifest in its folder.
pub const MANIFEST: &str = "golden.toml";

/// The format that is written and read.
pub(super) const FORMAT: u32 = 1;

/// The beginning of a new manifest.
const HEAD: &str = "\
# Golden pictures: written by `fragloom golden record`, compared by `fragloom golden verify`.
format = 1
";

/// A manifest, with its text.
#[derive(Clone, Debug)]
pub struct Manifest {
    path: PathBuf,
    /// As it was read; `None` if it is new.
    was: Option<String>,
    text: DocumentMut,
    entries: Vec<Entry>,
    pictures: bool,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    format: u32,
    pictures: Option<bool>,
    #[serde(default)]
    entry: Vec<RawEntry>,
}

impl Manifest {
    /// The manifest in a folder, or at a file's path.
    ///
    /// # Errors
    /// No such file, or what is wrong with it.
    pub fn read(path: &Path) -> Result<Self> {
        let path = if path.is_dir() { path.join(MANIFEST) } else { path.to_path_buf() };
        let text = fs::read_to_string(&path).map_err(|error| {
            let problem = format!("cannot be read: {error}; fragloom golden record makes one");
            Error::new(path.display().to_string(), problem)
        })?;
        Self::parse(path, text)
    }

    /// The manifest in a folder, or a new one without entries that is not written yet.
    ///
    /// # Errors
    /// What is wrong with the one that is there.
    pub fn in_folder(folder: &Path) -> Result<Self> {
        let path = folder.join(MANIFEST);
        match path.exists() {
            true => Self::read(&path),
            false => Ok(Self { was: None, ..Self::parse(path, HEAD.to_owned())? }),
        }
    }

    fn parse(path: PathBuf, text: String) -> Result<Self> {
        let place = path.display().to_string();
        let wrong = |problem: String| Error::new(&place, problem);
        let parsed = toml::from_str(&text);
        let Raw { format, pictures, entry } = parsed.map_err(|error: toml::de::Error| {
            let line = 1 + text[..error.span().map_or(0, |span| span.start)].matches('\n').count();
            wrong(format!("line {line}: {}", error.message().lines().next().unwrap_or_default()))
        })?;
        if format != FORMAT {
            return Err(wrong(format!(
                "format: {format} is not known; this program reads {FORMAT}"
            )));
        }
        let entries: Vec<Entry> = entry
            .into_iter()
            .enumerate()
            .map(|(i, raw)| raw.checked().map_err(|problem| wrong(format!("entry {i}: {problem}"))))
            .collect::<Result<_>>()?;
        let mut names = BTreeSet::new();
        for Entry { name, .. } in &entries {
            if !names.insert(name.to_ascii_lowercase()) {
                let problem = format!("entry {name:?}: name: is taken; case does not count");
                return Err(wrong(problem));
            }
        }
        let document = edit::parse(&text).map_err(wrong)?;
        let pictures = pictures.unwrap_or(true);
        Ok(Self { path, was: Some(text), text: document, entries, pictures })
    }

    /// Where it is, or will be.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The folder that its paths are relative to.
    #[must_use]
    pub fn folder(&self) -> &Path {
        match self.path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        }
    }

    /// What it says of each picture, in its order.
    #[must_use]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// The entry of that name; case does not count, as in names of files on some systems.
    #[must_use]
    pub fn entry(&self, name: &str) -> Option<&Entry> {
        self.entries.iter().find(|entry| entry.name.eq_ignore_ascii_case(name))
    }

    /// Whether pictures are kept of new entries (`pictures` in the file).
    #[must_use]
    pub fn keeps_pictures(&self) -> bool {
        self.pictures
    }

    /// SHA-256 of the file as it was read, hexadecimal.
    #[must_use]
    pub fn sha256(&self) -> String {
        hex(&Sha256::digest(self.was.as_deref().unwrap_or_default().as_bytes()))
    }

    /// The file that it should be.
    #[must_use]
    pub fn text(&self) -> String {
        self.text.to_string()
    }

    /// Say whether pictures are kept of new entries.
    pub(super) fn keep_pictures(&mut self, keep: bool) {
        self.pictures = keep;
        self.text["pictures"] = toml_edit::value(keep);
    }

    /// Add an entry at the end.
    pub(super) fn add(&mut self, entry: Entry) {
        edit::add(&mut self.text, &entry);
        self.entries.push(entry);
    }

    /// Replace the entry of the same name; lines that say the same stay as they are.
    pub(super) fn replace(&mut self, entry: Entry) {
        let Some(place) = self.entries.iter().position(|old| old.name == entry.name) else {
            return;
        };
        edit::replace(&mut self.text, place, &self.entries[place], &entry);
        self.entries[place] = entry;
    }

    /// Check that the file is still what was read.
    ///
    /// # Errors
    /// It is not.
    pub(super) fn check_unchanged(&self) -> Result<()> {
        if fs::read_to_string(&self.path).ok() == self.was {
            return Ok(());
        }
        let problem =
            "was changed by something else meanwhile, and is left as it is now; run again";
        Err(Error::new(self.path.display().to_string(), problem))
    }
}

#[cfg(test)]
mod tests;
