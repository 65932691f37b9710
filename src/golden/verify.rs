//! Drawing again, and telling apart what changed.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use super::draw::{Asked, Draw, Drawn};
use super::manifest::{Entry, Hashes, Manifest, inputs};
use super::outcome::{Apart, Outcome, Status};
use super::partition::Partition;
use super::record::recorded;
use super::report::{Report, Shown};
use super::{PROGRAM, Work, crew, save};
use crate::error::{Error, Result};
use crate::exec::clock::Stopwatch;
use crate::image::{Image, difference, png};
use crate::report::files::Staged;
use crate::scene::MAX_SIZE;

/// What is verified, and what is done about it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Settings<'a> {
    /// Only entries whose name has this in it.
    pub filter: Option<&'a str>,
    /// Only entries of this part.
    pub partition: Option<Partition>,
    /// Write what is different into the manifest.
    pub bless: bool,
    /// Where the pictures that differ are written, with their heat maps; `None` is beside the golden picture.
    pub maps: Option<&'a Path>,
}

/// What one entry gave.
struct Found {
    outcome: Outcome,
    /// What the manifest is to say.
    blessed: Option<(Entry, Option<Staged>)>,
}

/// Draw what a manifest says, and compare. With `settings.bless`, what differs is rewritten, and only that.
///
/// # Errors
/// A file that cannot be written. What is wrong with one entry is in its outcome.
pub fn verify(
    manifest: &mut Manifest,
    draw: &dyn Draw,
    settings: &Settings<'_>,
    work: &Work<'_>,
) -> Result<Report> {
    let chosen: Vec<&Entry> = manifest.entries().iter().filter(|e| settings.chooses(e)).collect();
    let mut report = Report {
        filter: settings.filter.map(str::to_owned),
        partition: settings.partition.map(|part| part.to_string()),
        ..Report::new(manifest, &chosen)
    };
    let hashes = Hashes::default();
    let judge = Judge { manifest, draw, settings, hashes: &hashes, shown: work.shown };
    let found =
        crew::all(chosen.len(), work, |number, threads| judge.entry(chosen[number], threads));
    let cancelled = found.iter().any(Option::is_none);
    let mut blessed = Vec::new();
    for found in found.into_iter().flatten() {
        let Found { mut outcome, blessed: new } = found?;
        if let Some(new) = new.filter(|_| !cancelled) {
            outcome.status = Status::Blessed;
            blessed.push(new);
        }
        report.add(outcome);
    }
    if !blessed.is_empty() {
        let mut pictures = Vec::new();
        for (entry, picture) in blessed {
            manifest.replace(entry);
            pictures.extend(picture);
        }
        save::commit(manifest, pictures)?;
    }
    Ok(report)
}

impl Settings<'_> {
    /// Whether an entry is verified.
    #[must_use]
    pub fn chooses(&self, entry: &Entry) -> bool {
        self.filter.is_none_or(|text| entry.name.contains(text))
            && self.partition.is_none_or(|part| part.has(&entry.name))
    }
}

struct Judge<'a> {
    manifest: &'a Manifest,
    draw: &'a dyn Draw,
    settings: &'a Settings<'a>,
    hashes: &'a Hashes,
    shown: &'a (dyn Fn(&str, Shown) + Sync),
}

impl Judge<'_> {
    /// One entry, with its time.
    fn entry(&self, entry: &Entry, threads: usize) -> Result<Found> {
        let mut watch = Stopwatch::start();
        let mut found = self.judged(entry, threads)?;
        watch.lap("all");
        found.outcome.seconds = watch.seconds().values().sum();
        Ok(found)
    }

    fn judged(&self, entry: &Entry, threads: usize) -> Result<Found> {
        let plain = |status, why: String| {
            Ok(Found { outcome: Outcome::new(&entry.name, status, why), blessed: None })
        };
        let changes = match self.changes(entry) {
            Ok(changes) => changes,
            Err(error) => return plain(Status::Error, error.to_string()),
        };
        let gone: Vec<&str> =
            changes.iter().filter(|change| change.gone).map(|change| change.file).collect();
        if !gone.is_empty() {
            let mut found = plain(Status::Missing, format!("{} is not there", gone.join(", ")))?;
            found.outcome.inputs = gone.into_iter().map(str::to_owned).collect();
            return Ok(found);
        }
        let inputs: Vec<String> = changes.iter().map(|change| change.file.to_owned()).collect();
        let changed = changes.iter().map(Change::text).collect::<Vec<_>>().join("; ");
        let folder = self.manifest.folder();
        let asked = Asked { folder, scene: &entry.scene, options: &entry.options, threads };
        let drawn = match self.draw.draw(&asked) {
            Ok(drawn) => drawn,
            Err(error) => {
                // A file that changed so much is not called the program's error.
                let mut found = match changed.is_empty() {
                    true => plain(Status::Error, error.to_string())?,
                    false => plain(
                        Status::InputChanged,
                        format!("{changed}; it cannot be drawn: {error}"),
                    )?,
                };
                found.outcome.inputs = inputs;
                return Ok(found);
            }
        };
        let mut outcome = self.compared(entry, &drawn)?;
        outcome.inputs = inputs;
        // A file that the scene did not name before.
        if outcome.inputs.is_empty() {
            outcome.inputs = self.added(entry, &drawn)?;
        }
        self.blame(entry, &mut outcome, &changed);
        let blessed = match outcome.status.is_clean() || !self.settings.bless {
            true => None,
            false => match self.blessed(entry, &drawn) {
                Ok(blessed) => Some(blessed),
                Err(error) => {
                    outcome.status = Status::Error;
                    outcome.why = format!("{}; not blessed: {error}", outcome.why);
                    None
                }
            },
        };
        Ok(Found { outcome, blessed })
    }

    /// The recorded files that are not as they were.
    fn changes<'e>(&self, entry: &'e Entry) -> Result<Vec<Change<'e>>> {
        let mut changes = Vec::new();
        for input in &entry.inputs {
            let now = self.hashes.of(&self.manifest.folder().join(&input.file))?;
            if now != input.sha256 {
                let (gone, new) = (now.is_none(), input.sha256.is_none());
                changes.push(Change { file: &input.file, gone, new });
            }
        }
        Ok(changes)
    }

    /// Files that were read now, and are not recorded.
    fn added(&self, entry: &Entry, drawn: &Drawn) -> Result<Vec<String>> {
        if entry.results.is_none() {
            return Ok(Vec::new());
        }
        let now = inputs(&drawn.files, self.manifest.folder(), self.hashes)?;
        let known = |file: &String| entry.inputs.iter().any(|input| input.file == *file);
        Ok(now.into_iter().map(|input| input.file).filter(|file| !known(file)).collect())
    }

    /// Compare what was drawn with what is recorded, and write the maps; who is to blame comes later.
    fn compared(&self, entry: &Entry, drawn: &Drawn) -> Result<Outcome> {
        let outcome = |status, why: String| Outcome::new(&entry.name, status, why);
        let Some(results) = &entry.results else {
            let why = "nothing is recorded of it yet: verify --bless records it";
            return Ok(outcome(Status::Missing, why.to_owned()));
        };
        let image_hash = drawn.image.hash();
        let same = [
            ("generated", results.generated == drawn.generated),
            ("kept", results.kept == drawn.kept),
            ("fragments_hash", results.fragments_hash == drawn.fragments_hash),
            ("image_hash", results.image_hash == image_hash),
        ];
        let wrong: Vec<String> =
            same.iter().filter(|(_, same)| !same).map(|(name, _)| (*name).to_owned()).collect();
        let golden = self.golden(entry, &results.image_hash);
        let mut found = match (&golden, wrong.is_empty(), drawn.violations.first()) {
            (Err(why), _, _) => outcome(Status::Missing, why.clone()),
            (Ok(_), true, None) => outcome(Status::Same, String::new()),
            (Ok(_), _, Some(violation)) => outcome(Status::Different, violation.clone()),
            (Ok(_), false, None) => outcome(Status::Different, String::new()),
        };
        if wrong.contains(&"image_hash".to_owned()) {
            let golden = golden.ok().flatten();
            self.show(entry, golden.as_ref(), drawn, &mut found)?;
            (self.shown)(&entry.name, Shown { golden, drawn: drawn.image.clone() });
        } else if !wrong.is_empty() {
            append(
                &mut found.why,
                &format!("the picture is the same, but not {}", wrong.join(", ")),
            );
        }
        found.results = wrong;
        Ok(found)
    }

    /// The golden picture, if it is kept; or why it is not what the manifest says.
    fn golden(&self, entry: &Entry, hash: &str) -> std::result::Result<Option<Image>, String> {
        let Some(picture) = &entry.picture else { return Ok(None) };
        let path = self.manifest.folder().join(picture);
        let place = path.display();
        let file = File::open(&path).map_err(|_| format!("{place} is not there"))?;
        let image = png::decode(BufReader::new(file), MAX_SIZE);
        let image = image.map_err(|problem| format!("{place} {problem}"))?;
        if image.hash() == hash {
            return Ok(Some(image));
        }
        Err(format!("{place} is not the picture that was recorded"))
    }

    /// Say how far the picture is from the golden one, and write it with the map.
    fn show(
        &self,
        entry: &Entry,
        golden: Option<&Image>,
        drawn: &Drawn,
        outcome: &mut Outcome,
    ) -> Result<()> {
        let beside = self.manifest.folder().join(entry.picture_file());
        let beside = beside.parent().unwrap_or(Path::new(".")).to_path_buf();
        // What is blessed takes the golden picture's place, and needs no copy.
        let folder = match (self.settings.maps, golden) {
            (Some(folder), _) => Some(folder.to_path_buf()),
            (None, Some(_)) if !self.settings.bless => Some(beside),
            _ => None,
        };
        let write = |kind: &str, image: &Image| {
            let Some(folder) = &folder else { return Ok(None) };
            let path = folder.join(format!("{}.{kind}.png", entry.name));
            let known = entry.inputs.iter().map(|input| self.manifest.folder().join(&input.file));
            let apart: Vec<PathBuf> = known.chain(drawn.files.iter().cloned()).collect();
            save::written(&path, image, &apart)?;
            Ok::<_, Error>(Some(path.display().to_string()))
        };
        let file = write("drawn", &drawn.image)?;
        let apart = golden.map(|golden| Apart::of(golden, &drawn.image));
        match (golden, apart) {
            (Some(golden), Some(Ok(Some(apart)))) => {
                append(&mut outcome.why, &apart.text());
                outcome.difference = Some(apart);
                outcome.map = write("difference", &difference::heat_map(golden, &drawn.image)?)?;
                if let Some(map) = &outcome.map {
                    append(&mut outcome.why, &format!("map: {map}"));
                }
            }
            (Some(golden), _) => {
                let Image { width, height, .. } = drawn.image;
                let old = format!("{}x{}", golden.width, golden.height);
                append(&mut outcome.why, &format!("the picture is {width}x{height}, not {old}"));
            }
            (None, _) => {
                append(&mut outcome.why, "the picture is another one");
                if let Some(file) = file {
                    append(&mut outcome.why, &format!("drawn now: {file}"));
                }
            }
        }
        Ok(())
    }

    /// Whose doing it is, if anything is not as recorded: that of files, of another program, or of neither.
    fn blame(&self, entry: &Entry, outcome: &mut Outcome, changed: &str) {
        if matches!(outcome.status, Status::Missing | Status::Error) {
            return;
        }
        let program = entry.program.as_deref().unwrap_or("an unknown version");
        if !outcome.inputs.is_empty() {
            let files = match changed.is_empty() {
                false => changed.to_owned(),
                true => {
                    let were = if outcome.inputs.len() == 1 { "was" } else { "were" };
                    format!("{} {were} not among its files", outcome.inputs.join(", "))
                }
            };
            let same = outcome.status == Status::Same;
            let rest = if same { "what is drawn is the same" } else { &outcome.why };
            outcome.why = format!("{files}; {rest}");
            outcome.status = Status::InputChanged;
        } else if outcome.status == Status::Different && program != PROGRAM {
            outcome.why = format!("recorded by {program}, and this is {PROGRAM}; {}", outcome.why);
            outcome.status = Status::ProgramChanged;
        }
    }

    /// What the manifest is to say of it, with its picture.
    fn blessed(&self, entry: &Entry, drawn: &Drawn) -> Result<(Entry, Option<Staged>)> {
        let pictures = match &entry.results {
            Some(_) => entry.picture.is_some(),
            None => entry.picture.is_some() || self.manifest.keeps_pictures(),
        };
        let known: Vec<PathBuf> = {
            let files = self.manifest.entries().iter().flat_map(|entry| &entry.inputs);
            files.map(|input| self.manifest.folder().join(&input.file)).collect()
        };
        recorded(entry.clone(), drawn, self.manifest, self.hashes, pictures, &known)
    }
}

/// A recorded file that is not as it was.
struct Change<'a> {
    file: &'a str,
    gone: bool,
    new: bool,
}

impl Change<'_> {
    fn text(&self) -> String {
        format!("{} {}", self.file, if self.new { "was not there before" } else { "has changed" })
    }
}

fn append(text: &mut String, more: &str) {
    if !text.is_empty() {
        text.push_str("; ");
    }
    text.push_str(more);
}
