//! STL, binary and ASCII: triangles in grey. The normals of facets and what follows them in binary files are not used.

use super::model::{GREY, MAX_TRIANGLES, Unplaced};
use super::parts::{decode, lines};
use super::{Material, Mesh, Model, check};
use crate::error::{Error, Result};

/// Bytes before the first facet of a binary file.
const HEADER: usize = 84;

/// Bytes of a facet.
const FACET: usize = 50;

/// The triangles of an STL file. `place` names it in messages.
///
/// # Errors
/// Names the line or the facet, and what is wrong with it.
pub fn parse(bytes: &[u8], place: &str) -> Result<Model> {
    let corners = match count(bytes) {
        Some(count) => binary(bytes, count),
        None => match text(&decode(bytes)) {
            // No text after all: a binary file with more behind its facets.
            Ok(corners) if corners.is_empty() => match promised(bytes) {
                Some(count) if count > 0 && !is_text(bytes) => binary(bytes, count),
                _ => Ok(corners),
            },
            corners => corners,
        },
    };
    let corners = corners.map_err(|problem| Error::new(place, problem))?;
    let count = corners.len() as u32 / 3;
    if count == 0 {
        return Err(Error::new(place, "facet: there is none; it needs at least one"));
    }
    let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = Mesh { positions: corners, triangles, ..Mesh::default() };
    check::mesh(place, &mesh)?;
    let mut model = Model::default();
    let material = model.add_material(Material::new("default", GREY, 1.0));
    model.add_mesh(mesh, material);
    Ok(model)
}

/// How many facets a binary file promises; `None` for text. A binary file, too, may begin with "solid", and a text with
/// anything, so that the length decides.
fn count(bytes: &[u8]) -> Option<usize> {
    let count = promised(bytes)?;
    let first = bytes.trim_ascii_start();
    let text =
        first.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) || is_text(bytes);
    (!text || bytes.len() - HEADER == count.saturating_mul(FACET)).then_some(count)
}

/// A binary file has a zero byte: its count is below 2^24.
fn is_text(bytes: &[u8]) -> bool {
    !bytes.contains(&0)
}

/// What a binary file's header says.
fn promised(bytes: &[u8]) -> Option<usize> {
    let word = bytes.get(HEADER - 4..HEADER)?.try_into().ok()?;
    Some(u32::from_le_bytes(word) as usize)
}

fn binary(bytes: &[u8], count: usize) -> Unplaced<Vec<[f64; 3]>> {
    let facets = &bytes[HEADER..];
    if count > MAX_TRIANGLES || count * FACET > facets.len() {
        return Err(format!("header: {count} facets do not fit into {} bytes", bytes.len()));
    }
    let number = |bytes: &[u8; 4]| f64::from(f32::from_le_bytes(*bytes));
    let facets = facets.as_chunks::<FACET>().0.iter().take(count);
    let corners = facets.flat_map(|facet| facet[12..48].as_chunks::<12>().0);
    Ok(corners
        .map(|corner| {
            let axes = corner.as_chunks::<4>().0;
            [number(&axes[0]), number(&axes[1]), number(&axes[2])]
        })
        .collect())
}

fn text(text: &str) -> Unplaced<Vec<[f64; 3]>> {
    let mut corners = Vec::new();
    for (line, words) in lines(text) {
        // Not of the format, but met: comments.
        let words = words.split('#').next().unwrap_or_default();
        let words: Vec<&str> = words.split_whitespace().collect();
        let Some(keyword) = words.first() else { continue };
        let ends_facet = keyword.eq_ignore_ascii_case("endfacet");
        if ends_facet && corners.len() % 3 != 0 {
            return Err(format!("line {line}: a facet needs 3 vertices"));
        }
        if !keyword.eq_ignore_ascii_case("vertex") {
            continue;
        }
        let numbers: Vec<f64> = words[1..].iter().filter_map(|word| word.parse().ok()).collect();
        match numbers[..] {
            [x, y, z] if words.len() == 4 && numbers.iter().all(|v| v.is_finite()) => {
                corners.push([x, y, z]);
            }
            _ => return Err(format!("line {line}: vertex: needs 3 finite numbers")),
        }
    }
    if corners.len() % 3 != 0 {
        return Err("the file ends within a facet".to_owned());
    }
    Ok(corners)
}
