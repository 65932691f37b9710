//! One entry of a manifest.

use serde::Deserialize;

/// What was drawn, from what, and what came out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Entry {
    /// Its name, which names its files: letters, digits, `-`, `_`, `+`, `@` and, inside, `.`.
    pub name: String,
    /// A file, relative to the manifest where it can be, or a built-in scene.
    pub scene: String,
    /// What follows the scene on the command line of `fragloom render`.
    pub options: Vec<String>,
    /// What came out, if it was drawn yet.
    pub results: Option<Results>,
    /// The file with the picture, relative to the manifest, if it is kept.
    pub picture: Option<String>,
    /// The version of the program that drew it.
    pub program: Option<String>,
    /// The files that it was drawn from.
    pub inputs: Vec<Input>,
}

/// What came out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Results {
    /// Fragments of one geometry pass.
    pub generated: u64,
    /// Entries of the resolved lists.
    pub kept: u64,
    /// SHA-256 of what the pixels hold, hexadecimal; `None` where the method gives only colours.
    pub fragments_hash: Option<String>,
    /// SHA-256 of the picture, hexadecimal.
    pub image_hash: String,
}

/// A file that a picture was drawn from.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Input {
    /// Relative to the manifest where it can be, with `/` between folders.
    pub file: String,
    /// SHA-256 of its bytes, hexadecimal; `None` if a file names it, and it was not there.
    pub sha256: Option<String>,
}

/// The most letters of a name.
const LONGEST: usize = 120;

/// What `verify` appends to names for its own files.
pub(in crate::golden) const OWN: [&str; 2] = ["difference", "drawn"];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RawEntry {
    name: String,
    scene: String,
    #[serde(default)]
    options: Vec<String>,
    generated: Option<u64>,
    kept: Option<u64>,
    fragments_hash: Option<String>,
    image_hash: Option<String>,
    picture: Option<String>,
    program: Option<String>,
    #[serde(default)]
    inputs: Vec<Input>,
}

impl Entry {
    /// What is wrong with a name, if anything.
    ///
    /// # Errors
    /// What would be right.
    pub fn check_name(name: &str) -> Result<(), String> {
        let letter = |c: char| c.is_ascii_alphanumeric() || "-_+@.".contains(c);
        if name.is_empty() || name.len() > LONGEST || !name.chars().all(letter) {
            return Err(format!(
                "name: {name:?} must be 1 to {LONGEST} of a-z, 0-9, - _ + @ and ."
            ));
        }
        if name.starts_with(['.', '-']) || name.ends_with('.') {
            return Err(format!("name: {name:?} must not begin with . or -, nor end with ."));
        }
        match OWN.iter().find(|own| name.rsplit_once('.').is_some_and(|(_, end)| end == **own)) {
            Some(own) => {
                Err(format!("name: {name:?} must not end in .{own}, as verify's files do"))
            }
            None => Ok(()),
        }
    }

    /// The file of its picture, relative to the manifest.
    #[must_use]
    pub fn picture_file(&self) -> String {
        self.picture.clone().unwrap_or_else(|| format!("{}.png", self.name))
    }
}

impl RawEntry {
    pub(super) fn checked(self) -> Result<Entry, String> {
        Entry::check_name(&self.name)?;
        let named = |problem: &str| format!("{:?}: {problem}", self.name);
        if self.scene.is_empty() || self.scene == "-" {
            return Err(named("scene: must be a file or a built-in scene"));
        }
        let Self { generated, kept, fragments_hash, image_hash, .. } = self;
        let hashes = [&fragments_hash, &image_hash].into_iter().flatten();
        let sums = self.inputs.iter().filter_map(|input| input.sha256.as_ref());
        let is_hash = |h: &&String| h.len() == 64 && h.bytes().all(|b| b.is_ascii_hexdigit());
        if let Some(bad) = hashes.chain(sums).find(|hash| !is_hash(hash)) {
            return Err(named(&format!("{bad:?} must be a SHA-256: 64 hexadecimal digits")));
        }
        let results = match (generated, kept, image_hash) {
            (Some(generated), Some(kept), Some(image_hash)) => {
                Some(Results { generated, kept, fragments_hash, image_hash })
            }
            (None, None, None) if fragments_hash.is_none() => None,
            _ => {
                let all = "generated, kept and image_hash: must be given together, or none of them";
                return Err(named(all));
            }
        };
        let Self { name, scene, options, picture, program, inputs, .. } = self;
        Ok(Entry { name, scene, options, results, picture, program, inputs })
    }
}
