//! Wavefront OBJ with MTL materials. `tobj` assembles meshes; before it sees a file, every line that matters
//! is checked here, because `tobj` names no lines, overflows on huge indices, panics on an MTL colour with
//! fewer than three numbers, mixes up colours where only some vertices have them, and takes `l` for faces.
//! Texture coordinates are checked and left out: fragloom draws no textures.

use std::collections::BTreeSet;
use std::path::Path;

use super::model::{GREY, Unplaced};
use super::{Material, Mesh, Model};
use crate::error::{Error, Result};

/// The meshes of an OBJ file: one object per group and material. Surfaces without a material are grey and
/// opaque. `place` names the file in messages; `library` gives the bytes of an MTL file by its name, or `None`
/// where there is no such file (a warning).
///
/// # Errors
/// Names the first bad line and its field.
pub fn parse(
    bytes: &[u8],
    place: &str,
    library: &mut dyn FnMut(&str) -> Option<Vec<u8>>,
) -> Result<Model> {
    let text = utf8(bytes, place)?;
    let mut sifted = Sifted { place, ..Sifted::default() };
    for (i, line) in text.lines().enumerate() {
        sifted
            .line(line)
            .map_err(|problem| Error::new(place, format!("line {}: {problem}", i + 1)))?;
    }
    let materials = sifted.read_libraries(library)?;
    sifted.assemble(&materials)
}

fn utf8<'a>(bytes: &'a [u8], place: &str) -> Result<&'a str> {
    std::str::from_utf8(bytes).map_err(|error| {
        Error::new(place, format!("byte {}: is not UTF-8 text", error.valid_up_to()))
    })
}

/// The lines that `tobj` will see, and what is known about the file so far.
#[derive(Default)]
struct Sifted<'a> {
    place: &'a str,
    text: String,
    vertices: usize,
    colored: usize,
    texcoords: usize,
    normals: usize,
    /// How many faces have normals at all corners, and how many do not.
    faces: [usize; 2],
    /// In the order in which they are named; the set says which are in it.
    libraries: Vec<&'a str>,
    named: BTreeSet<&'a str>,
    missing: Vec<&'a str>,
    used: BTreeSet<&'a str>,
    warnings: Vec<String>,
}

impl<'a> Sifted<'a> {
    /// Checks one line and keeps it if it matters.
    fn line(&mut self, line: &'a str) -> Unplaced<()> {
        let (keyword, rest) = split(line);
        match keyword {
            "v" => self.vertex(rest)?,
            "vn" => {
                numbers(rest, "vn", 3..=3)?;
                self.normals += 1;
            }
            "vt" => {
                numbers(rest, "vt", 1..=3)?;
                self.texcoords += 1;
                return Ok(());
            }
            "f" => return self.face(rest),
            "usemtl" if rest.is_empty() => {
                return Err("usemtl: needs the name of a material".into());
            }
            "usemtl" => {
                self.used.insert(rest);
            }
            "mtllib" => {
                if self.named.insert(rest) {
                    self.libraries.push(rest);
                }
                return Ok(());
            }
            "o" | "g" => {}
            _ => return Ok(()),
        }
        self.keep(keyword, rest);
        Ok(())
    }

    fn keep(&mut self, keyword: &str, rest: &str) {
        self.text.push_str(keyword);
        self.text.push(' ');
        self.text.push_str(rest);
        self.text.push('\n');
    }

    fn vertex(&mut self, rest: &str) -> Unplaced<()> {
        let values = numbers(rest, "v", 3..=6)?;
        match values.len() {
            5 => return Err("v: needs x y z, x y z w or x y z r g b, not 5 numbers".into()),
            4 if values[3] == 0.0 => return Err("v: w must not be 0".into()),
            6 if !values[3..].iter().all(|c| (0.0..=1.0).contains(c)) => {
                return Err(format!("v: color {:?} is not within 0 to 1", &values[3..]));
            }
            6 => self.colored += 1,
            _ => {}
        }
        self.vertices += 1;
        Ok(())
    }

    /// A face, kept as `v//vn` or `v` with indices counted from 1.
    fn face(&mut self, rest: &str) -> Unplaced<()> {
        let corners = rest.split_whitespace().map(|word| self.corner(word));
        let corners = corners.collect::<Unplaced<Vec<_>>>()?;
        if corners.len() < 3 {
            return Err(format!("f: needs at least 3 vertices, not {}", corners.len()));
        }
        let smooth = corners.iter().all(|(_, normal)| normal.is_some());
        self.faces[usize::from(smooth)] += 1;
        let words = corners.into_iter().map(|(vertex, normal)| match normal {
            Some(normal) if smooth => format!("{vertex}//{normal}"),
            _ => vertex.to_string(),
        });
        self.keep("f", &words.collect::<Vec<_>>().join(" "));
        Ok(())
    }

    /// The vertex and, where given, the normal of one corner `v`, `v/vt`, `v//vn` or `v/vt/vn`, from 1.
    fn corner(&self, word: &str) -> Unplaced<(usize, Option<usize>)> {
        let mut parts = word.split('/');
        let vertex = index(parts.next(), "vertex", self.vertices)?;
        index(parts.next(), "texture coordinate", self.texcoords)?;
        let normal = index(parts.next(), "normal", self.normals)?;
        match (vertex, parts.next()) {
            (Some(vertex), None) => Ok((vertex, normal)),
            _ => Err(format!("f: {word:?} is not v, v/vt, v//vn or v/vt/vn")),
        }
    }

    fn read_libraries(
        &mut self,
        library: &mut dyn FnMut(&str) -> Option<Vec<u8>>,
    ) -> Result<Vec<tobj::Material>> {
        let mut materials = Vec::new();
        for name in std::mem::take(&mut self.libraries) {
            match library(name) {
                Some(bytes) => materials.extend(mtl(&bytes, name)?),
                None => self.missing.push(name),
            }
        }
        Ok(materials)
    }

    fn warn(&mut self, warning: &str) {
        self.warnings.push(format!("{}: {warning}", self.place));
    }

    /// Lets `tobj` build the meshes, and takes them over.
    fn assemble(mut self, materials: &[tobj::Material]) -> Result<Model> {
        if self.faces == [0, 0] {
            return Err(Error::new(self.place, "f: there is no face; it needs at least one"));
        }
        self.warn_of_gaps(materials);
        let mut model = Model { warnings: self.warnings, ..Model::default() };
        for material in materials {
            model.add_material(convert(material, self.place)?);
        }
        let grey = model.add_material(Material::new("default", GREY, 1.0));
        let mixed = self.colored != 0 && self.colored != self.vertices;
        let text = if mixed { without_colors(&self.text) } else { self.text };
        for part in build(&text, materials, self.place)? {
            let material = part.mesh.material_id.unwrap_or(grey);
            model.add_mesh(mesh(&part.mesh, self.place)?, material);
        }
        Ok(model)
    }

    fn warn_of_gaps(&mut self, materials: &[tobj::Material]) {
        let known: BTreeSet<&str> = materials.iter().map(|m| m.name.as_str()).collect();
        let unknown: Vec<&str> = self.used.difference(&known).copied().collect();
        match (&self.missing[..], &unknown[..]) {
            ([name, rest @ ..], _) => {
                let more = rest.len();
                self.warn(&format!(
                    "mtllib: {name:?} and {more} more not found; unknown materials are grey"
                ));
            }
            ([], [name, rest @ ..]) => {
                let more = rest.len();
                self.warn(&format!(
                    "usemtl: {name:?} and {more} more unknown; their faces are grey"
                ));
            }
            _ => {}
        }
        if self.colored != 0 && self.colored != self.vertices {
            self.warn("v: only some vertices have colours; all colours are left out");
        }
        if self.faces[0] != 0 && self.faces[1] != 0 {
            self.warn("f: only some faces have normals; groups that mix them have none");
        }
    }
}

/// The first word and the rest of a line, both trimmed; numbers lose the comment behind them.
fn split(line: &str) -> (&str, &str) {
    let line = line.trim();
    let (keyword, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
    let bare = rest.split_once('#').map_or(rest, |(bare, _)| bare);
    let numeric = matches!(keyword, "v" | "vn" | "vt" | "f" | "Kd" | "d" | "Tr");
    (keyword, if numeric { bare.trim() } else { rest.trim() })
}

/// Finite numbers, as many as `count` allows.
fn numbers(rest: &str, field: &str, count: std::ops::RangeInclusive<usize>) -> Unplaced<Vec<f32>> {
    let parse = |word: &str| match word.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("{field}: {word:?} is not a finite number")),
    };
    let values = rest.split_whitespace().map(parse).collect::<Unplaced<Vec<_>>>()?;
    if count.contains(&values.len()) {
        return Ok(values);
    }
    let (low, high) = count.into_inner();
    let need = if low == high { low.to_string() } else { format!("{low} to {high}") };
    Err(format!("{field}: needs {need} numbers, not {}", values.len()))
}

/// An index of a face's corner, made absolute, from 1; `None` where it is left out.
fn index(word: Option<&str>, field: &str, count: usize) -> Unplaced<Option<usize>> {
    let Some(word) = word.filter(|word| !word.is_empty()) else { return Ok(None) };
    let number: i64 = word.parse().map_err(|_| format!("f: {word:?} is not an index"))?;
    let count = count as i64;
    let absolute = if number < 0 { number.saturating_add(count + 1) } else { number };
    if (1..=count).contains(&absolute) {
        return Ok(Some(absolute as usize));
    }
    Err(format!("f: {field} {number} is not among the {count} so far"))
}

/// The materials of an MTL file, of which only the lines that matter are shown to `tobj`.
fn mtl(bytes: &[u8], place: &str) -> Result<Vec<tobj::Material>> {
    let mut sifted = String::new();
    for (i, line) in utf8(bytes, place)?.lines().enumerate() {
        let (keyword, rest) = split(line);
        let checked = match keyword {
            "newmtl" if rest.is_empty() => Err("newmtl: needs a name".to_owned()),
            "newmtl" => Ok(Vec::new()),
            // The other forms give a spectrum or CIE coordinates, which are not used in practice.
            "Kd" if rest.starts_with("spectral") || rest.starts_with("xyz") => continue,
            "Kd" => numbers(rest, "Kd", 1..=3),
            "d" | "Tr" => numbers(rest.trim_start_matches("-halo"), keyword, 1..=1),
            _ => continue,
        };
        let values = checked.map_err(|p| Error::new(place, format!("line {}: {p}", i + 1)))?;
        match (keyword, &values[..]) {
            // One number stands for all three.
            ("Kd", [one]) => sifted.push_str(&format!("Kd {one} {one} {one}\n")),
            ("Kd", [_, _]) => {
                return Err(Error::new(
                    place,
                    format!("line {}: Kd: needs 3 numbers, not 2", i + 1),
                ));
            }
            ("d" | "Tr", [value]) => sifted.push_str(&format!("{keyword} {value}\n")),
            _ => sifted.push_str(&format!("{keyword} {rest}\n")),
        }
    }
    let loaded = tobj::load_mtl_buf(&mut sifted.as_bytes());
    Ok(loaded.map_err(|error| Error::new(place, format!("mtl: {error}")))?.0)
}

/// Kd is the colour; d, or else 1 - Tr, the opacity.
fn convert(material: &tobj::Material, place: &str) -> Result<Material> {
    let transparency = material.unknown_param.get("Tr").and_then(|tr| tr.parse::<f32>().ok());
    let alpha = material.dissolve.or(transparency.map(|tr| 1.0 - tr)).unwrap_or(1.0);
    let color = material.diffuse.unwrap_or(GREY);
    let place_of = |field: &str| format!("material {:?}: {field}", material.name);
    super::check::color(place, &place_of("Kd"), color)?;
    super::check::fraction(place, &place_of("opacity by d or Tr"), alpha)?;
    Ok(Material::new(&material.name, color, alpha))
}

/// `tobj` has no answer to vertices of which only some have colours.
fn without_colors(text: &str) -> String {
    let plain = |line: &str| match line.split_whitespace().collect::<Vec<_>>()[..] {
        ["v", x, y, z, _, _, _] => format!("v {x} {y} {z}\n"),
        _ => format!("{line}\n"),
    };
    text.lines().map(plain).collect()
}

fn build(text: &str, materials: &[tobj::Material], place: &str) -> Result<Vec<tobj::Model>> {
    let options = tobj::LoadOptions { triangulate: true, single_index: true, ..Default::default() };
    // `tobj` learns the materials' indices only from a library, so it gets one that holds them all.
    let text = format!("mtllib all\n{text}");
    let library = |_: &Path| {
        let indices = materials.iter().enumerate().map(|(i, m)| (m.name.clone(), i)).collect();
        Ok((materials.to_vec(), indices))
    };
    let loaded = tobj::load_obj_buf(&mut text.as_bytes(), &options, library);
    Ok(loaded.map_err(|error| Error::new(place, format!("obj: {error}")))?.0)
}

fn mesh(part: &tobj::Mesh, place: &str) -> Result<Mesh> {
    let triples = |values: &[f32]| values.as_chunks().0.to_vec();
    let positions: Vec<[f32; 3]> = triples(&part.positions);
    let fits = |values: &[f32]| values.len() == part.positions.len();
    let mesh = Mesh {
        normals: if fits(&part.normals) { triples(&part.normals) } else { Vec::new() },
        colors: if fits(&part.vertex_color) { triples(&part.vertex_color) } else { Vec::new() },
        triangles: part.indices.as_chunks().0.to_vec(),
        positions,
        discs: Vec::new(),
    };
    super::check::mesh(place, &mesh)?;
    Ok(mesh)
}
