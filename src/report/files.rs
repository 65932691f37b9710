//! Output files appear whole or not at all: checked before the work starts, written next to their destination under a
//! temporary name, and renamed when complete. A file that was there keeps its mode; a link is followed, also one whose
//! target does not exist yet; what is no file, like `/dev/null`, is written to.

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
    if path.is_dir() {
        return Err(wrong(option, path, "is a folder, and not the name of a file"));
    }
    let target = followed(path);
    let beyond = self::folder(&target);
    if !beyond.is_dir() {
        let problem = format!("leads to {}, whose folder does not exist", target.display());
        return Err(wrong(option, path, &problem));
    }
    Ok(())
}

/// The most links that lead from one to the next.
const MOST_LINKS: u32 = 40;

/// Where a path leads: the target of a link, also if it does not exist.
fn followed(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&path) {
            Ok(target) => path = folder(&path).join(target),
            Err(_) => break,
        }
    }
    path
}

/// One spelling for a place: links followed, the folder as the system knows it.
fn place(path: &Path) -> PathBuf {
    let path = followed(path);
    match (fs::canonicalize(&path), fs::canonicalize(folder(&path)), path.file_name()) {
        (Ok(known), ..) => known,
        (_, Ok(folder), Some(name)) => folder.join(name),
        _ => path,
    }
}

/// Check that no output is one of these inputs, however both are spelled.
///
/// # Errors
/// The option, the path, and the input.
pub fn check_apart(outputs: &[(&str, &PathBuf)], inputs: &[PathBuf]) -> Result<()> {
    let inputs: Vec<PathBuf> = inputs.iter().map(|input| place(input)).collect();
    for (option, output) in outputs {
        if inputs.contains(&place(output)) {
            let problem = "is an input of this run: it would be overwritten; give another name";
            return Err(wrong(option, output, problem));
        }
    }
    Ok(())
}

/// Check that `path` is a folder, or that one can be made there, with those around it: writing the first file makes it.
///
/// # Errors
/// `option`, the path and what would be right.
pub fn check_folder(option: &str, path: &Path) -> Result<()> {
    if path.is_dir() {
        return Ok(());
    }
    if path.exists() {
        return Err(wrong(option, path, "is a file, and must be a folder"));
    }
    let around =
        path.ancestors().skip(1).map(|p| if p == Path::new("") { Path::new(".") } else { p });
    match around.into_iter().find(|around| around.exists()) {
        Some(around) if around.is_dir() => Ok(()),
        around => {
            let around = around.unwrap_or(path).display();
            Err(wrong(option, path, &format!("cannot be made: {around} is a file")))
        }
    }
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
    let path = followed(path);
    let path = if path.exists() { fs::canonicalize(path)? } else { path };
    let there = fs::metadata(&path).ok();
    if there.as_ref().is_some_and(|there| !there.is_file()) {
        let mut file = fs::OpenOptions::new().write(true).open(&path)?;
        let mut writer = BufWriter::with_capacity(1 << 16, &mut file);
        fill(&mut writer)?;
        return writer.flush();
    }
    let Staged { file, path } = stage(path, fill)?;
    file.persist(path).map_err(|error| error.error)?;
    Ok(())
}

/// A file that is written whole beside its place, and not there yet. Dropped, it leaves nothing behind.
#[derive(Debug)]
pub struct Staged {
    file: NamedTempFile,
    path: PathBuf,
}

impl Staged {
    /// Write these bytes for `path`, making its folder if there is none. A link is followed.
    ///
    /// # Errors
    /// The path and the operating system's reason.
    pub fn new(path: &Path, bytes: &[u8]) -> Result<Self> {
        let wrong = |error: io::Error| Error::new(path.display().to_string(), error.to_string());
        let target = followed(path);
        let target =
            if target.exists() { fs::canonicalize(target).map_err(wrong)? } else { target };
        let staged = stage(target, |file| file.write_all(bytes)).map_err(wrong)?;
        staged.file.as_file().sync_data().map_err(wrong)?;
        Ok(staged)
    }

    /// Put it in its place at once.
    ///
    /// # Errors
    /// The path and the operating system's reason; what was there stays.
    pub fn commit(self) -> Result<()> {
        let Self { file, path } = self;
        let wrong = |error: io::Error| Error::new(path.display().to_string(), error.to_string());
        file.persist(&path).map_err(|error| wrong(error.error))?;
        Ok(())
    }
}

/// Write what will be at `path`, which is no link.
fn stage<F>(path: PathBuf, fill: F) -> io::Result<Staged>
where
    F: FnOnce(&mut BufWriter<&mut File>) -> io::Result<()>,
{
    if !folder(&path).exists() {
        fs::create_dir_all(folder(&path))?;
    }
    let mut file = temporary(folder(&path))?;
    if let Ok(there) = fs::metadata(&path) {
        file.as_file().set_permissions(there.permissions())?;
    }
    let mut writer = BufWriter::with_capacity(1 << 16, file.as_file_mut());
    fill(&mut writer)?;
    writer.flush()?;
    drop(writer);
    file.as_file_mut().rewind()?;
    Ok(Staged { file, path })
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

/// Check that no two outputs share one place, however they are spelled; what is no file may be shared.
///
/// # Errors
/// Both options and the path.
pub fn check_distinct(outputs: &[(&str, &PathBuf)]) -> Result<()> {
    for (i, (option, path)) in outputs.iter().enumerate() {
        let own = place(path);
        let same = |earlier: &Path| place(earlier) == own && (own.is_file() || !own.exists());
        if let Some((other, _)) = outputs[..i].iter().find(|(_, earlier)| same(earlier)) {
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
        assert!(check_folder("-o", dir.path()).is_ok() && check_folder("-o", &inside).is_ok());
        assert!(check_folder("-o", &dir.path().join("missing/out")).is_ok());
        assert!(check_folder("-o", Path::new("missing")).is_ok());
        let other = dir.path().join("other");
        fs::write(&other, "a file").unwrap();
        assert!(check_folder("-o", &other).is_err());
        assert!(check_folder("-o", &other.join("below")).is_err());
        let dotted = dir.path().join(".").join("out");
        assert!(check_distinct(&[("-o", &inside), ("--stats", &dotted)]).is_err());
        assert!(check_apart(&[("-o", &dotted)], std::slice::from_ref(&inside)).is_err());
        assert!(check_apart(&[("-o", &other)], std::slice::from_ref(&inside)).is_ok());
        assert!(check_distinct(&[("-o", &inside), ("--stats", &other)]).is_ok());
        assert!(check_distinct(&[("-o", &inside), ("--stats", &inside)]).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_are_followed_and_devices_written_to() {
        let dir = tempfile::tempdir().unwrap();
        let [target, link] = ["target", "link"].map(|name| dir.path().join(name));
        fs::write(&target, "old").unwrap();
        std::os::unix::fs::symlink(&target, &link).unwrap();
        write_bytes(&link, b"new").unwrap();
        assert_eq!(fs::read(&target).unwrap(), b"new");
        assert!(link.is_symlink());
        let null = Path::new("/dev/null");
        assert!(check_output("--stats", null).is_ok());
        write_bytes(null, b"gone").unwrap();
        let [dangling, new] = ["dangling", "new"].map(|name| dir.path().join(name));
        std::os::unix::fs::symlink("new", &dangling).unwrap();
        assert!(check_output("-o", &dangling).is_ok());
        write_bytes(&dangling, b"there now").unwrap();
        assert_eq!(fs::read(&new).unwrap(), b"there now");
        assert!(dangling.is_symlink());
        std::os::unix::fs::symlink("no/where", dir.path().join("lost")).unwrap();
        assert!(check_output("-o", &dir.path().join("lost")).is_err());
    }

    #[cfg(unix)]
    #[test]
    fn modes_and_other_names_stay() {
        use std::os::unix::fs::PermissionsExt;
        let dir = tempfile::tempdir().unwrap();
        let [path, other] = ["out", "other"].map(|name| dir.path().join(name));
        fs::write(&path, "old").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o600)).unwrap();
        fs::hard_link(&path, &other).unwrap();
        write_bytes(&path, b"new").unwrap();
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o600);
        assert_eq!(fs::read(&other).unwrap(), b"old");
    }
}
