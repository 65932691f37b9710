//! Files that are judged.

use std::fs;
use std::path::Path;

use crate::error::{Error, Result};
use crate::image::foreign::Foreign;
use crate::judge::dump::Dump;
use crate::num::npy::{Array, members};
use crate::render::Options;
use crate::scene::MAX_SIZE;

/// What a file holds.
#[derive(Debug)]
pub(super) enum Input {
    Picture(Foreign),
    Dump(Dump),
}

/// Read a file, in the format that its first bytes tell; CSV by its ending. Depths become words of the format of
/// `options`.
///
/// # Errors
/// It cannot be read, or what is wrong with it.
pub(super) fn read(path: &Path, options: &Options) -> Result<Input> {
    let place = path.display().to_string();
    let wrong = |problem: String| Error::new(&place[..], problem);
    let bytes = fs::read(path).map_err(|error| wrong(error.to_string()))?;
    parse(&bytes, path, options).map_err(wrong)
}

fn parse(bytes: &[u8], path: &Path, options: &Options) -> std::result::Result<Input, String> {
    let format = options.record().depth;
    if bytes.starts_with(b"PK") {
        let members = members(bytes, options.max_memory)?;
        if Dump::is_npz(&members) {
            return Ok(Input::Dump(Dump::of_npz(&members, format)?));
        }
        let [(name, array)] = &members[..] else {
            let names: Vec<&str> = members.iter().map(|(name, _)| &name[..]).collect();
            return Err(format!(
                "must have one array, a picture, or offsets, depth, data, width and height, which \
                 are fragments; it has {} ({})",
                names.len(),
                names.join(", ")
            ));
        };
        let of_array = |array: &Array<'_>| Foreign::of_array(array, MAX_SIZE);
        let picture = Array::of(array).and_then(|array| of_array(&array));
        return picture.map(Input::Picture).map_err(|problem| format!("{name}: {problem}"));
    }
    let ending = path.extension().unwrap_or_default();
    if ending.eq_ignore_ascii_case("csv") {
        let text = std::str::from_utf8(bytes).map_err(|_| "must be text in UTF-8")?;
        return Ok(Input::Dump(Dump::of_csv(text, format)?));
    }
    let picture = Foreign::parse(bytes, MAX_SIZE);
    let others = |problem: String| match problem.starts_with("must be PNG") {
        true => format!("{problem} (pictures), .npz or .csv (fragments)"),
        false => problem,
    };
    picture.map(Input::Picture).map_err(others)
}
