//! Wavefront OBJ with MTL materials, read leniently: what does not change the surfaces is left out with a warning. Only
//! what a face cannot do without is an error: its corners, as finite numbers.

mod group;
mod mtl;
mod picture;
mod piece;
mod reader;
#[cfg(test)]
mod same;
mod statement;
mod vertices;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use self::mtl::Look;
use self::picture::Pictures;
use self::piece::Piece;
use self::reader::Reader;
use super::model::{GREY, Unplaced};
use super::parts::{PIECE, decode, in_order, pieces};
use super::{Material, Mesh, Model, check};
use crate::error::{Error, Result};

/// The meshes of an OBJ file: one object per group and material. Surfaces without a material are opaque, and grey unless
/// their vertices have colours. `place` names the file in messages; `library` gives the bytes of an MTL file by its
/// name, or `None` where there is no such file (a warning).
///
/// # Errors
/// Names the first bad line and its field.
pub fn parse(
    bytes: &[u8],
    place: &str,
    library: &mut dyn FnMut(&str) -> Option<Vec<u8>>,
) -> Result<Model> {
    let text = decode(bytes);
    let reader = read(&text, &cut(&text, PIECE)).map_err(|problem| Error::new(place, problem))?;
    let (groups, said) = reader.finish();
    if groups.is_empty() {
        let problem = "f: there is no face; it needs at least one";
        return Err(Error::new(place, problem.to_owned() + &said.tally.reasons(|_| true)));
    }
    let (looks, missing) = libraries(&said.libraries, library);
    let mut tally = said.tally;
    let mut model = Model::default();
    // Of two materials of one name, the last counts.
    let mut known: BTreeMap<&str, usize> = BTreeMap::new();
    // What the file does not say must not darken the colours of vertices.
    let plain = if said.colored { [1.0; 3] } else { GREY };
    for look in &looks {
        model.named.extend(look.named.iter().cloned());
        known.insert(&look.name, model.add_material(look.material(plain, &mut tally)));
    }
    let plain = model.add_material(Material::new("default", plain, 1.0));
    let (mut unknown, mut textured) = (BTreeSet::new(), BTreeSet::new());
    let mut pictures = Pictures::new(library);
    for group in groups {
        let name = &said.names[group.material];
        let material = find(&known, name);
        if let Some(look) = material.and_then(|i| looks.get(i)) {
            let used = material.is_some_and(|i| textured.insert(i));
            if used {
                let maps = [look.color.as_ref(), look.opacity.as_ref()];
                let found = pictures.texture(&look.name, maps, &look.folder, &mut tally);
                if let Some(i) = material {
                    model.materials[i].texture = found;
                }
            }
        } else if !name.is_empty() {
            unknown.insert(name.clone());
        }
        let mut mesh: Mesh = group.mesh();
        let material = material.unwrap_or(plain);
        if model.materials[material].texture.is_none() {
            mesh.places = Vec::new();
        } else if mesh.places.is_empty() {
            tally.add("some corners say nothing of the picture, which is left out", || {
                format!("material {name:?}")
            });
        }
        check::mesh(place, &mesh)?;
        model.add_mesh(mesh, material);
    }
    model.warnings = gaps(&missing, &unknown.into_iter().collect::<Vec<_>>(), place);
    model.warnings.extend(tally.warnings(place));
    Ok(model)
}

/// Pieces of at least `size` bytes; no line that ends one goes on in the next.
fn cut(text: &str, size: usize) -> Vec<Range<usize>> {
    pieces(text.as_bytes(), size, |line| !line.contains(&b'\\'))
}

/// Reads a text in pieces.
fn read(text: &str, pieces: &[Range<usize>]) -> Unplaced<Reader> {
    let mut reader = Reader::default();
    in_order(pieces, |piece| Piece::read(&text[piece.clone()]), |piece| reader.piece(&piece))?;
    Ok(reader)
}

/// A material by its name, without a comment behind it if need be.
fn find(known: &BTreeMap<&str, usize>, name: &str) -> Option<usize> {
    let bare = || name.split_once(" #").and_then(|(bare, _)| known.get(bare.trim()));
    known.get(name).or_else(bare).copied()
}

/// One sentence about libraries that are not there, else about materials that are not in them.
fn gaps(missing: &[String], unknown: &[String], place: &str) -> Vec<String> {
    let sentence = |names: &[String], end: &str| match names {
        [] => None,
        [name] => Some(format!("{name:?} {end}")),
        [name, rest @ ..] => Some(format!("{name:?} and {} more {end}", rest.len())),
    };
    let missing = sentence(missing, "not found; unknown materials are plain");
    let unknown = sentence(unknown, "unknown; their faces are plain");
    match (missing, unknown) {
        (Some(missing), _) => vec![format!("{place}: mtllib: {missing}")],
        (None, Some(unknown)) => vec![format!("{place}: usemtl: {unknown}")],
        (None, None) => Vec::new(),
    }
}

/// The most words of a library's name among others.
const MOST_WORDS: usize = 8;

/// The materials of all libraries, and the names of those that are not there.
fn libraries(
    lines: &[String],
    library: &mut dyn FnMut(&str) -> Option<Vec<u8>>,
) -> (Vec<Look>, Vec<String>) {
    let (mut looks, mut missing) = (Vec::new(), Vec::new());
    let mut read = |name: &str, looks: &mut Vec<Look>| {
        // A backslash before a blank only keeps the name together.
        let slashes = name.replace("\\ ", " ").replace('\\', "/");
        let found = library(name).or_else(|| (slashes != name).then(|| library(&slashes))?);
        let parsed = found.map(|bytes| mtl::parse(&bytes, name));
        let there = parsed.is_some();
        let folder = std::path::Path::new(&slashes).parent();
        for mut look in parsed.into_iter().flatten() {
            let beside = |named: &String| Some(folder?.join(named).to_str()?.to_owned());
            let beside: Vec<String> = look.named.iter().filter_map(beside).collect();
            look.named.extend(beside);
            look.folder = folder.and_then(|f| f.to_str()).unwrap_or_default().to_owned();
            looks.push(look);
        }
        there
    };
    for line in lines {
        let bare = line.trim_matches('"');
        // The whole line is one name if there is such a file, else there are several.
        if read(line, &mut looks) || (bare != line && read(bare, &mut looks)) {
            continue;
        }
        let mut names = &words(line)[..];
        while let [first, rest @ ..] = names {
            // Several names, each of which may have blanks.
            let most = names.len().min(MOST_WORDS);
            let joined = (1..=most).rev().find(|&n| read(&names[..n].join(" "), &mut looks));
            names = match joined {
                Some(count) => &names[count..],
                None => {
                    missing.push(first.clone());
                    rest
                }
            };
        }
    }
    (looks, missing)
}

/// Words, or what stands between quotes, up to a comment.
fn words(line: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut left = line.trim();
    while !left.is_empty() && !left.starts_with('#') {
        let (word, rest) = match left.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"').unwrap_or((quoted, "")),
            None => left.split_once(char::is_whitespace).unwrap_or((left, "")),
        };
        if !word.is_empty() {
            found.push(word.to_owned());
        }
        left = rest.trim_start();
    }
    found
}
