//! Output files appear whole or not at all: checked before the work starts, written next to their destination under a
//! temporary name, and renamed when complete.

use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// Check that a file can be written at `path`: its folder exists, and nothing but a file is in its place.
///
/// # Errors
/// `option`, the path and what would be right.
pub fn check_output(option: &str, path: &Path) -> Result<()> {
    if path.file_name().is_none() {
        return Err(wrong(option, path, "is not the name of a file"));
    }
    let folder = folder(path);
    if !folder.is_dir() {
        let problem = format!("cannot be written: the folder {} does not exist", folder.display());
        return Err(wrong(option, path, &problem));
    }
    if path.exists() && !path.is_file() {
        return Err(wrong(option, path, "exists and is not a regular file"));
    }
    Ok(())
}

/// Check that `path` is a folder that exists.
///
/// # Errors
/// `option`, the path and what would be right.
pub fn check_folder(option: &str, path: &Path) -> Result<()> {
    if path.is_dir() { Ok(()) } else { Err(wrong(option, path, "must be a folder that exists")) }
}

/// Write `path` with what `fill` produces; on any error nothing is left behind, and the old file stays.
///
/// # Errors
/// The path and the operating system's reason.
pub fn write<F>(path: &Path, fill: F) -> Result<()>
where
    F: FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
{
    try_write(path, fill).map_err(|error| Error::new(path.display().to_string(), error.to_string()))
}

/// Write `path` with these bytes, with the same guarantee as [`write()`].
///
/// # Errors
/// The path and the operating system's reason.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    write(path, |file| file.write_all(bytes))
}

fn try_write<F>(path: &Path, fill: F) -> io::Result<()>
where
    F: FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
{
    // A link keeps pointing where it did: its target is replaced.
    let path = if path.exists() { fs::canonicalize(path)? } else { path.to_path_buf() };
    let mut file = temporary(folder(&path))?;
    let mut writer = BufWriter::with_capacity(1 << 16, file.as_file_mut());
    fill(&mut writer)?;
    writer.flush()?;
    drop(writer);
    file.as_file_mut().rewind()?;
    file.persist(&path).map_err(|error| error.error)?;
    Ok(())
}

/// A temporary file with an ordinary file's permissions: tempfile's own are private to the user.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".fragloom-");
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder)
}

/// The folder a path lies in; a bare name lies in the current one.
fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

fn wrong(option: &str, path: &Path, problem: &str) -> Error {
    Error::new(option, format!("{} {problem}", path.display()))
}

/// Check that no two outputs share one path, as typed.
///
/// # Errors
/// Both options and the path.
pub fn check_distinct(outputs: &[(&str, &PathBuf)]) -> Result<()> {
    for (i, (option, path)) in outputs.iter().enumerate() {
        if let Some((other, _)) = outputs[..i].iter().find(|(_, earlier)| earlier == path) {
            return Err(wrong(option, path, &format!("is also what {other} writes")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_file_is_replaced_whole() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out");
        write_bytes(&path, b"a long first version").unwrap();
        write_bytes(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(names(dir.path()), ["out"]);
    }

    #[test]
    fn a_failure_leaves_what_was_there() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("out");
        write_bytes(&path, b"before").unwrap();
        let result = write(&path, |file| {
            file.write_all(b"half")?;
            Err(io::Error::other("the disk is full"))
        });
        assert_eq!(result.unwrap_err().problem(), "the disk is full");
        assert_eq!(fs::read(&path).unwrap(), b"before");
        assert_eq!(names(dir.path()), ["out"]);
    }

    #[test]
    fn places_are_checked() {
        let dir = tempfile::tempdir().unwrap();
        let inside = dir.path().join("out");
        assert!(check_output("-o", &inside).is_ok());
        assert!(check_output("-o", Path::new("bare-name")).is_ok());
        assert!(check_output("-o", &dir.path().join("missing/out")).is_err());
        assert!(check_output("-o", dir.path()).is_err());
        assert!(check_output("-o", Path::new("..")).is_err());
        assert!(check_folder("-o", dir.path()).is_ok() && check_folder("-o", &inside).is_err());
        let other = dir.path().join("other");
        assert!(check_distinct(&[("-o", &inside), ("--stats", &other)]).is_ok());
        assert!(check_distinct(&[("-o", &inside), ("--stats", &inside)]).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_refused() {
        let dir = tempfile::tempdir().unwrap();
        let [target, link] = ["target", "link"].map(|name| dir.path().join(name));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_bytes(&link, b"new").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert!(link.is_symlink());
        assert!(check_output("--stats", Path::new("/dev/null")).is_err());
    }
}
