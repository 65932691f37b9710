//! Stanford PLY: meshes and point sets in ASCII or binary of either byte order, with elements in any order. Counts are held
//! against the file's length before anything is kept for them.

mod blocks;
mod faces;
mod header;
mod lines;
mod payload;
#[cfg(test)]
mod same;

use std::sync::Arc;

use self::faces::Faces;
use self::header::{Element, Header, Kind};
use self::payload::Payload;
use super::model::{GREY, MAX_TRIANGLES, Unplaced};
use super::parts::{PIECE, Tally, without_mark};
use super::points::table::{self, ALPHA, COLOR, NORMAL, Table};
use super::{Material, Mesh, Model, PointSize, check, points};
use crate::error::{Error, Result};

/// The mesh of a PLY file: `x y z`, and where present `nx ny nz` and `red green blue alpha` (linear; integers are divided
/// by the largest of their type). It is opaque and grey where it says nothing else. Faces may be polygons of any outline,
/// and triangle strips. A file without faces is a point set, which may also have `radius`, or the properties of Gaussian
/// splats. `place` names the file in messages.
///
/// # Errors
/// Names the element or the point, and the property.
pub fn parse(bytes: &[u8], place: &str) -> Result<Model> {
    parse_sized(bytes, place, PointSize::default())
}

/// As [`parse`]; `size` is for the points of a point set.
///
/// # Errors
/// As [`parse`].
pub fn parse_sized(bytes: &[u8], place: &str, size: PointSize) -> Result<Model> {
    read(bytes, place, size, PIECE)
}

/// Reads a file; text in pieces of about `piece` bytes. 0 is for rows one after the other.
fn read(bytes: &[u8], place: &str, size: PointSize, piece: usize) -> Result<Model> {
    let wrong = |problem: String| Error::new(place, problem);
    let bytes = without_mark(bytes);
    let mut tally = Tally::default();
    let header = Header::read(bytes, &mut tally).map_err(wrong)?;
    header.check(bytes.len()).map_err(wrong)?;
    let mut payload = Payload::new(bytes, &header, piece);
    let drawn = header.has_faces();
    let (mut table, mut faces) = (Table::default(), Faces::default());
    for element in &header.elements {
        match element.name.as_str() {
            "vertex" => {
                table = vertices(&mut payload, element, &mut tally).map_err(wrong)?;
                if !drawn {
                    // What follows the points is not looked at.
                    break;
                }
            }
            name @ ("face" | "tristrips") => {
                let strip = name == "tristrips";
                let from = match header.is_text() {
                    true => lines::faces(&mut payload, element, &mut faces, strip),
                    false => blocks::faces(&mut payload, element, &mut faces, strip),
                };
                faces.read(&mut payload, element, from, strip).map_err(wrong)?;
                faces.say(&mut tally);
            }
            _ => skip(&mut payload, element).map_err(wrong)?,
        }
        if element.name == "edge" && element.count > 0 {
            tally.add("edges are not drawn", || format!("element edge {}", element.count));
        }
    }
    if let Some(line) = payload.beyond() {
        tally.add("what follows the values of the header's properties is left out", || {
            format!("line {line}")
        });
    }
    let mut model = match drawn {
        true => mesh(table, faces, &mut tally, place)?,
        false => points::model(&table, size, place)?,
    };
    model.warnings.extend(tally.warnings(place));
    Ok(model)
}

/// One object of everything.
fn mesh(table: Table, faces: Faces, tally: &mut Tally, place: &str) -> Result<Model> {
    let wrong = |problem: String| Error::new(place, problem);
    let triangles = faces.triangles(&table.places, tally).map_err(wrong)?;
    if triangles.is_empty() {
        return Err(wrong("element face: no face has 3 corners".to_owned()));
    }
    let three = |from: usize| -> Vec<[f32; 3]> {
        if table.has[from..from + 3] != [true; 3] {
            return Vec::new();
        }
        let slot = table.slot(from);
        table.values.chunks_exact(table.width()).map(|v| [0, 1, 2].map(|i| v[slot + i])).collect()
    };
    let mut mesh =
        Mesh { normals: three(NORMAL), colors: three(COLOR), triangles, ..Mesh::default() };
    if table.has[ALPHA] {
        let slot = table.slot(ALPHA);
        mesh.alphas = table.values.chunks_exact(table.width()).map(|v| v[slot]).collect();
    }
    mesh.positions = table.places;
    for (i, position) in mesh.positions.iter_mut().enumerate() {
        // A face that used it would have been an error.
        if !position.iter().all(|c| c.is_finite()) {
            let what = *position;
            tally.add("is not finite; no face uses it, and it is left out", || {
                format!("vertex {i}: position {what:?}")
            });
            *position = [0.0; 3];
        }
    }
    for (i, normal) in mesh.normals.iter_mut().enumerate() {
        if !normal.iter().all(|c| c.is_finite()) {
            let what = *normal;
            tally.add("is not finite and is left out", || format!("vertex {i}: normal {what:?}"));
            *normal = [0.0; 3];
        }
    }
    check::mesh(place, &mesh)?;
    let mut model = Model::default();
    let color = if mesh.colors.is_empty() { GREY } else { [1.0; 3] };
    let material = model.add_material(Material::new("default", color, 1.0));
    model.add_placed(Arc::new(mesh), glam::DMat4::IDENTITY, material);
    Ok(model)
}

/// All vertices, by column.
fn vertices(payload: &mut Payload<'_>, element: &Element, tally: &mut Tally) -> Unplaced<Table> {
    let mut table = Table::default();
    let columns: Vec<_> = element
        .properties
        .iter()
        .map(|property| match property.kind {
            Kind::Scalar(_) => table::column(&property.name),
            Kind::List(..) => None,
        })
        .collect();
    columns.iter().flatten().for_each(|&column| table.has[column] = true);
    table.fill(element.count);
    if blocks::vertices(payload, element, &mut table, tally) {
        return Ok(table);
    }
    let from = lines::vertices(payload, element, &mut table);
    for row in from..element.count {
        for (property, column) in element.properties.iter().zip(&columns) {
            let context = || format!("vertex {row}: {}", property.name);
            let (Kind::Scalar(scalar), Some(column)) = (property.kind, *column) else {
                payload
                    .skip(property.kind)
                    .map_err(|problem| format!("{}: {problem}", context()))?;
                continue;
            };
            let value =
                payload.scalar(scalar).map_err(|problem| format!("{}: {problem}", context()))?;
            let value = match table::is_share(column) {
                true => tally.clamped(value / scalar.largest(), context).into(),
                false => value,
            };
            table.set(row, column, value);
        }
        payload.end_row();
    }
    Ok(table)
}

fn skip(payload: &mut Payload<'_>, element: &Element) -> Unplaced<()> {
    for row in 0..element.count {
        for property in &element.properties {
            payload.skip(property.kind).map_err(|problem| {
                format!("{} {row}: {}: {problem}", element.name, property.name)
            })?;
        }
        payload.end_row();
    }
    Ok(())
}

impl Header {
    /// Whether the elements are those of a mesh or a point set, and can be as many as the header says in `length` bytes.
    fn check(&self, length: usize) -> Unplaced<()> {
        for element in &self.elements {
            let (name, count) = (&element.name, element.count);
            let size = element.least_size(self.is_text());
            if size == 0 && count > 0 {
                return Err(format!("element {name}: needs at least one property"));
            }
            if count as u128 * size as u128 > length as u128 + 1 {
                return Err(format!(
                    "element {name}: count: {count} do not fit into {length} bytes"
                ));
            }
        }
        let vertex = self.element("vertex").ok_or("element vertex: is missing")?;
        let lacks =
            |axis: &&str| !vertex.properties.iter().any(|p| p.name == **axis && p.is_scalar());
        if vertex.properties.iter().any(|property| property.name == "packed_position") {
            let problem = "packed splats are not supported; export them with x, y, z, scale_0, rot_0 and so on";
            return Err(format!("element vertex: property packed_position: {problem}"));
        }
        if let Some(axis) = ["x", "y", "z"].iter().find(|axis| lacks(axis)) {
            return Err(format!("element vertex: property {axis}: is missing"));
        }
        if vertex.count > MAX_TRIANGLES {
            let count = vertex.count;
            return Err(format!("element vertex: count: {count} are more than {MAX_TRIANGLES}"));
        }
        for name in ["face", "tristrips"] {
            let element = self.element(name).filter(|element| element.count > 0);
            if element.is_some_and(|element| faces::indices(element).is_none()) {
                return Err(format!("element {name}: property vertex_indices: is missing"));
            }
        }
        Ok(())
    }

    /// Whether there is anything but points.
    fn has_faces(&self) -> bool {
        ["face", "tristrips"].iter().any(|name| self.element(name).is_some_and(|e| e.count > 0))
    }
}
