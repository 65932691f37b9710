//! Zipped models: an archive with one model in it, and what that one names.

use std::borrow::Cow;
use std::cell::RefCell;
use std::io::Cursor;
use std::path::{Component, Path, PathBuf};

use zip::ZipArchive;
use zip::result::ZipError;

use super::super::parts::FileFormat;
use super::files::{all, beside, too_large, unpacked};
use crate::error::{Error, Result};

/// An archive in memory.
pub(super) struct Archive<'a> {
    place: &'a str,
    /// By number; those that cannot be read as text are empty.
    names: Vec<String>,
    entries: RefCell<ZipArchive<Cursor<&'a [u8]>>>,
}

impl<'a> Archive<'a> {
    /// `place` names it in messages.
    pub(super) fn new(bytes: &'a [u8], place: &'a str) -> Result<Self> {
        let broken = |_| Error::new(place, "must be a zip archive that is whole");
        let entries = ZipArchive::new(Cursor::new(bytes)).map_err(broken)?;
        let name = |name: std::result::Result<Cow<'_, str>, _>| {
            name.map_or_else(|_: ZipError| String::new(), Cow::into_owned)
        };
        let names = entries.file_names().map(name).collect();
        Ok(Self { place, names, entries: RefCell::new(entries) })
    }

    /// The one model: its name and its format.
    pub(super) fn model(&self) -> Result<(PathBuf, FileFormat)> {
        let model = |name: &String| {
            let path = Path::new(name);
            let hidden = |part: Component<'_>| {
                let part = part.as_os_str().to_string_lossy();
                part == "__MACOSX" || part.starts_with('.')
            };
            let format = FileFormat::of(path)
                .filter(|format| !matches!(format, FileFormat::Zip | FileFormat::Toml))?;
            (!path.components().any(hidden)).then(|| (path.to_path_buf(), format))
        };
        let mut found: Vec<_> = self.names.iter().filter_map(model).collect();
        found.sort_by(|a, b| a.0.cmp(&b.0));
        let wrong = |problem: String| Err(Error::new(self.place, problem));
        match &found[..] {
            [one] => Ok(one.clone()),
            [] => wrong("has no .obj, .gltf, .glb, .ply, .stl or .pcd file in it".to_owned()),
            [(first, _), (second, _), ..] => wrong(format!(
                "has {} models in it, {} and {} among them; unpack it, and give one of them",
                found.len(),
                first.display(),
                second.display()
            )),
        }
    }

    /// The bytes of a file, named as `model` names it.
    pub(super) fn read(&self, model: &Path, name: &str) -> Result<Vec<u8>> {
        let path = tidy(&beside(model, &name.replace('\\', "/")));
        self.file(&path)
    }

    /// The bytes of a file of the archive, unpacked if gzip packed them, too.
    pub(super) fn file(&self, path: &Path) -> Result<Vec<u8>> {
        let place = format!("{}: {}", self.place, path.display());
        let wrong = |problem: &str| Error::new(&place, problem.to_owned());
        let index = self.names.iter().position(|known| tidy(Path::new(known)) == *path);
        let index = index.ok_or_else(|| wrong("is not in the archive"))?;
        let mut entries = self.entries.borrow_mut();
        let entry = entries.by_index(index);
        let entry = entry.map_err(|error| wrong(&format!("cannot be unpacked: {error}")))?;
        let bytes = all(entry).map_err(|error| match error {
            Some(_) => wrong("the compressed data are broken"),
            None => wrong(&too_large(", unpacked")),
        })?;
        unpacked(bytes, &place)
    }
}

/// A path without `.` and `..`.
fn tidy(path: &Path) -> PathBuf {
    let mut tidy = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                tidy.pop();
            }
            Component::Normal(part) => tidy.push(part),
            _ => {}
        }
    }
    tidy
}
