//! Stanford PLY: meshes and point sets in ASCII or binary of either byte order. `ply-rs-bw` reads the payload; it would believe a
//! header that promises any number of elements without properties, so counts are held against the file's
//! length before it starts.

use std::sync::Arc;

use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{
    ElementDef, Encoding, Header, Property, PropertyAccess, PropertyAccessResult, PropertyType,
    ScalarType,
};

use super::model::{GREY, MAX_TRIANGLES, Unplaced};
use super::points::table::{self, Table};
use super::{Material, Mesh, Model, PointSize, check, points};
use crate::error::{Error, Result};

/// The mesh of a PLY file, grey and opaque: `x y z`, and where present `nx ny nz` and `red green blue` (linear;
/// integers are divided by the largest of their type). Polygons are cut into fans from their first corner. A file
/// without faces is a point set, which may also have `alpha` and `radius`, or the properties of Gaussian splats.
/// `place` names the file in messages.
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
    let failed = |error: ParseError| Error::new(place, one_line(&error));
    let mut reader = Reader::new(bytes);
    let header = Parser::<Skipped>::new().read_header(&mut reader).map_err(failed)?;
    check_header(&header, reader.get_ref().len()).map_err(|problem| Error::new(place, problem))?;
    if faces(&header) == 0 {
        let table = table(&mut reader, &header).map_err(failed)?;
        return points::model(&table, size, place);
    }
    let (mut vertices, mut faces) = (Vec::new(), Vec::new());
    for (name, element) in &header.elements {
        let reader = &mut reader;
        match name.as_str() {
            "vertex" => vertices = read(reader, element, &header).map_err(failed)?,
            "face" => faces = read(reader, element, &header).map_err(failed)?,
            _ => drop(read::<Skipped>(reader, element, &header).map_err(failed)?),
        }
    }
    let mesh =
        assemble(&header, &vertices, &faces).map_err(|problem| Error::new(place, problem))?;
    check::mesh(place, &mesh)?;
    let mut model = Model::default();
    let material = model.add_material(Material::new("default", GREY, 1.0));
    model.add_placed(Arc::new(mesh), glam::DMat4::IDENTITY, material);
    Ok(model)
}

/// How many faces the header promises.
fn faces(header: &Header) -> usize {
    header.elements.get("face").map_or(0, |face| face.count)
}

/// The vertices of a point set. What follows them is not looked at.
fn table(reader: &mut Reader<&[u8]>, header: &Header) -> std::result::Result<Table, ParseError> {
    let mut table = Table { has: [false; table::COLUMNS], rows: Vec::new() };
    for (name, element) in &header.elements {
        if name == "vertex" {
            let known = element.properties.keys().filter_map(|name| table::column(name));
            known.for_each(|column| table.has[column] = true);
            table.rows = read::<Point>(reader, element, header)?.into_iter().map(|p| p.0).collect();
            break;
        }
        drop(read::<Skipped>(reader, element, header)?);
    }
    Ok(table)
}

fn read<E: PropertyAccess>(
    reader: &mut Reader<&[u8]>,
    element: &ElementDef,
    header: &Header,
) -> std::result::Result<Vec<E>, ParseError> {
    Parser::<E>::new().read_payload_for_element(reader, element, header)
}

/// The parser's messages span lines and quote whole ones.
fn one_line(error: &ParseError) -> String {
    let text = error.to_string();
    text.split_whitespace().collect::<Vec<_>>().join(" ").chars().take(300).collect()
}

/// Whether the elements are those of a mesh, and can be as many as the header says in `length` bytes.
fn check_header(header: &Header, length: usize) -> Unplaced<()> {
    for (name, element) in &header.elements {
        let size = least_size(element, header.encoding);
        if size == 0 {
            return Err(format!("element {name}: needs at least one property"));
        }
        if element.count as u128 * size as u128 > length as u128 + 1 {
            let count = element.count;
            return Err(format!("element {name}: count: {count} do not fit into {length} bytes"));
        }
    }
    let element = |name| header.elements.get(name).ok_or(format!("element {name}: is missing"));
    let vertex = element("vertex")?;
    if let Some(axis) = ["x", "y", "z"].iter().find(|&&axis| !vertex.properties.contains_key(axis))
    {
        return Err(format!("element vertex: property {axis}: is missing"));
    }
    if faces(header) == 0 {
        if vertex.count > MAX_TRIANGLES {
            let count = vertex.count;
            return Err(format!("element vertex: count: {count} are more than {MAX_TRIANGLES}"));
        }
        return Ok(());
    }
    let face = element("face")?;
    if !["vertex_indices", "vertex_index"].iter().any(|&name| face.properties.contains_key(name)) {
        return Err("element face: property vertex_indices: is missing".to_owned());
    }
    Ok(())
}

/// The fewest bytes that an element can take.
fn least_size(element: &ElementDef, encoding: Encoding) -> usize {
    let types = element.properties.values().map(|property| &property.data_type);
    let sizes = types.map(|data_type| match (encoding, data_type) {
        // A digit and what separates it from the next one.
        (Encoding::Ascii, _) => 2,
        (_, PropertyType::Scalar(scalar) | PropertyType::List(scalar, _)) => size(scalar),
    });
    sizes.sum()
}

fn size(scalar: &ScalarType) -> usize {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

fn assemble(header: &Header, vertices: &[Vertex], faces: &[Face]) -> Unplaced<Mesh> {
    let has = |names: [&str; 3]| {
        let vertex = header.elements.get("vertex");
        vertex.is_some_and(|v| names.iter().all(|&name| v.properties.contains_key(name)))
    };
    let triples = |from: usize, wanted: bool| -> Vec<[f32; 3]> {
        let pick = |v: &Vertex| std::array::from_fn(|i| v.0[from + i] as f32);
        if wanted { vertices.iter().map(pick).collect() } else { Vec::new() }
    };
    let mut triangles = Vec::with_capacity(faces.len());
    for (i, face) in faces.iter().enumerate() {
        fan(&face.0, vertices.len(), &mut triangles).map_err(|p| format!("face {i}: {p}"))?;
    }
    Ok(Mesh {
        positions: triples(0, true),
        normals: triples(3, has(["nx", "ny", "nz"])),
        colors: triples(6, has(["red", "green", "blue"])),
        triangles,
        discs: Vec::new(),
    })
}

/// Cuts a polygon into triangles around its first corner.
fn fan(corners: &[i64], vertices: usize, triangles: &mut Vec<[u32; 3]>) -> Unplaced<()> {
    if corners.len() < 3 {
        return Err(format!("vertex_indices: needs at least 3, not {}", corners.len()));
    }
    let index = |&corner: &i64| match u32::try_from(corner) {
        Ok(index) if (index as usize) < vertices => Ok(index),
        _ => Err(format!("vertex_indices: {corner} is not below the {vertices} vertices")),
    };
    let corners = corners.iter().map(index).collect::<Unplaced<Vec<_>>>()?;
    triangles.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
    Ok(())
}

/// Position, normal and colour.
struct Vertex([f64; 9]);

const VERTEX: [&str; 9] = ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue"];

impl PropertyAccess for Vertex {
    fn new() -> Self {
        Self([0.0; 9])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(i) = VERTEX.iter().position(|&known| known == name) else {
            return PropertyAccessResult::Ignored;
        };
        let Some((value, largest)) = scalar(&property) else {
            return PropertyAccessResult::UnsupportedType;
        };
        self.0[i] = if i < 6 { value } else { value / largest };
        PropertyAccessResult::Set
    }
}

/// A scalar's value, and the value that stands for full colour in its type.
fn scalar(property: &Property) -> Option<(f64, f64)> {
    Some(match *property {
        Property::Char(v) => (v.into(), 127.0),
        Property::UChar(v) => (v.into(), 255.0),
        Property::Short(v) => (v.into(), 32_767.0),
        Property::UShort(v) => (v.into(), 65_535.0),
        Property::Int(v) => (v.into(), 2_147_483_647.0),
        Property::UInt(v) => (v.into(), 4_294_967_295.0),
        Property::Float(v) => (v.into(), 1.0),
        Property::Double(v) => (v, 1.0),
        _ => return None,
    })
}

/// A point of a point set.
struct Point(table::Row);

impl PropertyAccess for Point {
    fn new() -> Self {
        Self([0.0; table::COLUMNS])
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        let Some(column) = table::column(name) else {
            return PropertyAccessResult::Ignored;
        };
        let Some((value, largest)) = scalar(&property) else {
            return PropertyAccessResult::UnsupportedType;
        };
        self.0[column] = if table::is_share(column) { value / largest } else { value } as f32;
        PropertyAccessResult::Set
    }
}

/// The corners of a polygon.
struct Face(Vec<i64>);

impl PropertyAccess for Face {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, name: &str, property: Property) -> PropertyAccessResult {
        if !matches!(name, "vertex_indices" | "vertex_index") {
            return PropertyAccessResult::Ignored;
        }
        self.0 = match property {
            Property::ListChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUChar(list) => list.into_iter().map(i64::from).collect(),
            Property::ListShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUShort(list) => list.into_iter().map(i64::from).collect(),
            Property::ListInt(list) => list.into_iter().map(i64::from).collect(),
            Property::ListUInt(list) => list.into_iter().map(i64::from).collect(),
            _ => return PropertyAccessResult::UnsupportedType,
        };
        PropertyAccessResult::Set
    }
}

/// An element that is not drawn.
struct Skipped;

impl PropertyAccess for Skipped {
    fn new() -> Self {
        Self
    }
}
