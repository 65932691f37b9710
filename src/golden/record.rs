//! Adding entries to a manifest.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use super::draw::{Asked, Draw, Drawn};
use super::manifest::{Entry, Hashes, Manifest, Results, inputs};
use super::{PROGRAM, Work, crew, save};
use crate::error::{Error, Result};
use crate::report::files::Staged;

/// A picture that is to be recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The entry's name.
    pub name: String,
    /// A file, relative to the manifest where it can be, or a built-in scene.
    pub scene: String,
    /// What follows the scene on the command line of `fragloom render`.
    pub options: Vec<String>,
}

/// Draw what is planned, add it to the manifest, and write both; `pictures`: keep the pictures, too. `None` if it was
/// cancelled: then nothing is written.
///
/// # Errors
/// A name that is taken, a picture that cannot be drawn or that may change from run to run, or a file that cannot be
/// written. Nothing is written then, either.
pub fn record(
    manifest: &mut Manifest,
    plans: &[Plan],
    draw: &dyn Draw,
    pictures: bool,
    work: &Work<'_>,
) -> Result<Option<Vec<(Entry, Drawn)>>> {
    check(manifest, plans)?;
    let made = Made::folder(manifest.folder())?;
    let found = recorded_all(manifest, plans, draw, pictures, work);
    if !matches!(found, Ok(Some(_))) {
        made.remove();
    }
    found
}

/// Folders that were made, the innermost first.
struct Made(Vec<PathBuf>);

impl Made {
    /// Make a folder, so that paths through it lead somewhere, with those around it.
    fn folder(folder: &Path) -> Result<Self> {
        let missing = folder.ancestors().filter(|around| !around.as_os_str().is_empty());
        let missing =
            missing.take_while(|around| !around.exists()).map(Path::to_path_buf).collect();
        fs::create_dir_all(folder)
            .map_err(|error| Error::new(folder.display().to_string(), error.to_string()))?;
        Ok(Self(missing))
    }

    /// Remove them again, as far as they are empty.
    fn remove(self) {
        self.0.iter().for_each(|folder| drop(fs::remove_dir(folder)));
    }
}

fn recorded_all(
    manifest: &mut Manifest,
    plans: &[Plan],
    draw: &dyn Draw,
    pictures: bool,
    work: &Work<'_>,
) -> Result<Option<Vec<(Entry, Drawn)>>> {
    if manifest.entries().is_empty() && manifest.keeps_pictures() != pictures {
        manifest.keep_pictures(pictures);
    }
    let hashes = Hashes::default();
    let known: Vec<PathBuf> = {
        let files = manifest.entries().iter().flat_map(|entry| &entry.inputs);
        files.map(|input| manifest.folder().join(&input.file)).collect()
    };
    let found = crew::all(plans.len(), work, |number, threads| {
        let Plan { name, scene, options } = &plans[number];
        let plain = Entry {
            name: name.clone(),
            scene: scene.clone(),
            options: options.clone(),
            results: None,
            picture: None,
            program: None,
            inputs: Vec::new(),
        };
        one(manifest, plain, draw, &hashes, (pictures, threads), &known)
            .map_err(|error| Error::new(name, error.to_string()))
    });
    if found.iter().any(Option::is_none) && !found.iter().flatten().any(Result::is_err) {
        return Ok(None);
    }
    let (mut staged, mut all) = (Vec::new(), Vec::new());
    for found in found.into_iter().flatten() {
        let (entry, drawn, picture) = found?;
        staged.extend(picture);
        manifest.add(entry.clone());
        all.push((entry, drawn));
    }
    save::commit(manifest, staged)?;
    Ok(Some(all))
}

fn check(manifest: &Manifest, plans: &[Plan]) -> Result<()> {
    let mut names = BTreeSet::new();
    for Plan { name, .. } in plans {
        Entry::check_name(name).map_err(|problem| Error::new("--name", problem))?;
        if let Some(old) = manifest.entry(name) {
            let how = "verify --bless records it again; --name gives another name";
            let problem = format!("{:?} is recorded already: {how}", old.name);
            return Err(Error::new(manifest.path().display().to_string(), problem));
        }
        if !names.insert(name.to_ascii_lowercase()) {
            let problem = format!(
                "two pictures would be called {name:?}: record one of them later, under another name"
            );
            return Err(Error::new("--name", problem));
        }
    }
    Ok(())
}

fn one(
    manifest: &Manifest,
    plain: Entry,
    draw: &dyn Draw,
    hashes: &Hashes,
    (pictures, threads): (bool, usize),
    known: &[PathBuf],
) -> Result<(Entry, Drawn, Option<Staged>)> {
    let folder = manifest.folder();
    let asked = Asked { folder, scene: &plain.scene, options: &plain.options, threads };
    let drawn = draw.draw(&asked)?;
    let (entry, picture) = recorded(plain, &drawn, manifest, hashes, pictures, known)?;
    Ok((entry, drawn, picture))
}

/// The entry with what came out, and its picture, written beside its place if `pictures`.
///
/// # Errors
/// A promise that was not kept, a picture that may change from run to run, or a file that cannot be read or written.
pub(super) fn recorded(
    plain: Entry,
    drawn: &Drawn,
    manifest: &Manifest,
    hashes: &Hashes,
    pictures: bool,
    known: &[PathBuf],
) -> Result<(Entry, Option<Staged>)> {
    if let Some(broken) = drawn.violations.first() {
        return Err(Error::new(
            "violation",
            format!("{broken}; nothing golden can be made of that"),
        ));
    }
    if let Some(why) = &drawn.unsteady {
        return Err(Error::new("result", format!("may change from run to run: {why}")));
    }
    let folder = manifest.folder();
    let results = Results {
        generated: drawn.generated,
        kept: drawn.kept,
        fragments_hash: drawn.fragments_hash.clone(),
        image_hash: drawn.image.hash(),
    };
    let picture = pictures.then(|| plain.picture_file());
    let staged = picture.as_ref().map(|picture| {
        let apart = [&drawn.files[..], known].concat();
        save::staged(&folder.join(picture), &drawn.image, &apart)
    });
    let entry = Entry {
        results: Some(results),
        picture,
        program: Some(PROGRAM.to_owned()),
        inputs: inputs(&drawn.files, folder, hashes)?,
        ..plain
    };
    Ok((entry, staged.transpose()?))
}
