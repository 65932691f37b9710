//! Writing a manifest and its pictures: all are written whole beside their places first; then the pictures take their
//! places, and the manifest does so last. Whatever is interrupted, the manifest that is there is a whole one, and so is
//! every picture.

use std::path::{Path, PathBuf};

use super::manifest::Manifest;
use crate::error::{Error, Result};
use crate::image::{Image, png};
use crate::report::files::{self, Staged};

/// A picture written beside its place.
///
/// # Errors
/// The file cannot be written, or is one of `inputs`.
pub(super) fn staged(path: &PathBuf, image: &Image, inputs: &[PathBuf]) -> Result<Staged> {
    files::check_apart(&[("picture", path)], inputs)?;
    Staged::new(path, &encoded(path, image)?)
}

/// A picture in its place at once.
///
/// # Errors
/// As [`staged`].
pub(super) fn written(path: &PathBuf, image: &Image, inputs: &[PathBuf]) -> Result<()> {
    files::check_apart(&[("picture", path)], inputs)?;
    files::write_bytes(path, &encoded(path, image)?)
}

fn encoded(path: &Path, image: &Image) -> Result<Vec<u8>> {
    png::encode(image).map_err(|error| Error::new(path.display().to_string(), error.to_string()))
}

/// Put the pictures in their places, and then the manifest.
///
/// # Errors
/// A file that cannot be written, or a manifest that something else changed meanwhile.
pub(super) fn commit(manifest: &Manifest, pictures: Vec<Staged>) -> Result<()> {
    commit_step_by_step(manifest, pictures, &mut || Ok(()))
}

/// The same; `before` is asked before every step that can be seen from outside.
fn commit_step_by_step(
    manifest: &Manifest,
    pictures: Vec<Staged>,
    before: &mut dyn FnMut() -> Result<()>,
) -> Result<()> {
    before()?;
    let text = Staged::new(manifest.path(), manifest.text().as_bytes())?;
    manifest.check_unchanged()?;
    for picture in pictures {
        before()?;
        picture.commit()?;
    }
    before()?;
    text.commit()
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    /// Stopped before each of its steps, it leaves the manifest as it was, whole pictures, and nothing beside.
    #[test]
    fn a_commit_can_stop_anywhere() {
        for stop in 0..5 {
            let dir = tempfile::tempdir().unwrap();
            let path = |name: &str| dir.path().join(name);
            fs::write(path("golden.toml"), "format = 1\n").unwrap();
            let [old, new] = [[1; 4], [2; 4]].map(|color| Image::filled(3, 3, color));
            written(&path("a.png"), &old, &[]).unwrap();
            let mut manifest = Manifest::in_folder(dir.path()).unwrap();
            manifest.keep_pictures(false);
            let pictures = ["a.png", "b.png"].map(|name| staged(&path(name), &new, &[]).unwrap());
            let mut steps = 0;
            let mut before = || {
                steps += 1;
                if steps > stop { Err(Error::new("test", "stop")) } else { Ok(()) }
            };
            let done = commit_step_by_step(&manifest, pictures.into(), &mut before);
            assert_eq!(done.is_ok(), stop == 4, "{stop}");
            let text = fs::read_to_string(path("golden.toml")).unwrap();
            assert_eq!(text == "format = 1\n", stop < 4, "{stop}");
            let [is_old, is_new] = [&old, &new].map(|image| png::encode(image).unwrap());
            assert_eq!(
                fs::read(path("a.png")).unwrap(),
                if stop < 2 { is_old } else { is_new.clone() }
            );
            assert_eq!(fs::read(path("b.png")).ok(), (stop >= 3).then_some(is_new), "{stop}");
            let names = fs::read_dir(dir.path()).unwrap().count();
            assert_eq!(names, if stop < 3 { 2 } else { 3 }, "nothing is left beside");
        }
    }

    #[test]
    fn what_is_changed_meanwhile_is_left_alone() {
        let dir = tempfile::tempdir().unwrap();
        let manifest = Manifest::in_folder(dir.path()).unwrap();
        fs::write(manifest.path(), "format = 1 # mine\n").unwrap();
        let error = commit(&manifest, Vec::new()).unwrap_err();
        assert!(error.problem().contains("meanwhile"), "{error}");
        assert_eq!(fs::read_to_string(manifest.path()).unwrap(), "format = 1 # mine\n");
    }

    #[test]
    fn an_input_is_never_overwritten() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("texture.png");
        fs::write(&path, "input").unwrap();
        let image = Image::filled(1, 1, [0; 4]);
        let inputs = std::slice::from_ref(&path);
        assert!(staged(&path, &image, inputs).is_err() && written(&path, &image, inputs).is_err());
        assert_eq!(fs::read(&path).unwrap(), b"input");
    }
}
