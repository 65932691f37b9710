//! The last gate before drawing: the promises that [`Scene`] makes about itself, each checked, each with a
//! message of its own. Loaders check what they can say more about (lines, vertices of a file) themselves.

use glam::DVec3;

use super::model::MAX_TRIANGLES;
use super::parts::first;
use super::{Bounds, Disc, MAX_SIZE, Mesh, Object, Scene, ScreenTriangle};
use crate::error::{Error, Result};

/// The farthest that a vertex may be from the origin of the world along an axis.
const MAX_COORDINATE: f64 = 1e30;

/// The farthest that a screen triangle's corner may be from the image's upper left corner along an axis, pixels.
const MAX_PIXEL: f64 = 32_768.0;

/// Checks a whole scene; errors carry its name as their place.
pub fn scene(scene: &Scene) -> Result<()> {
    let place = scene.name.as_str();
    size(place, scene.size)?;
    triangles(place, scene)?;
    color(place, "background", scene.background)?;
    for material in &scene.materials {
        color(place, &format!("material {:?}: color", material.name), material.color)?;
        fraction(place, &format!("material {:?}: alpha", material.name), material.alpha)?;
    }
    for (i, object) in scene.objects.iter().enumerate() {
        check_object(place, i, object, scene.materials.len())?;
    }
    scene.camera.check(place)?;
    light(place, scene)?;
    scene.screen.iter().enumerate().try_for_each(|(i, triangle)| screen(place, i, triangle))
}

/// Width and height, each 1 to [`MAX_SIZE`].
pub fn size(place: &str, size: [u32; 2]) -> Result<()> {
    if size.iter().all(|side| (1..=MAX_SIZE).contains(side)) {
        return Ok(());
    }
    let [width, height] = size;
    let problem =
        format!("size: {width}x{height} is not within 1x1 to {MAX_SIZE}x{MAX_SIZE} pixels");
    Err(Error::new(place, problem))
}

/// Three channels, each 0..1.
pub fn color(place: &str, field: &str, color: [f32; 3]) -> Result<()> {
    color.into_iter().try_for_each(|channel| fraction(place, field, channel))
}

/// A number that must be 0..1.
pub fn fraction(place: &str, field: &str, value: f32) -> Result<()> {
    if (0.0..=1.0).contains(&value) {
        return Ok(());
    }
    Err(Error::new(place, format!("{field}: {value} is not within 0 to 1")))
}

/// A mesh's own promises: finite vertices, one attribute per vertex, indices in range, discs that can be drawn.
pub fn mesh(place: &str, mesh: &Mesh) -> Result<()> {
    let wrong = |problem: String| Err(Error::new(place, problem));
    let count = mesh.positions.len();
    if let Some(i) = first(&mesh.positions, |p| !p.iter().all(|c| c.is_finite())) {
        return wrong(format!("vertex {i}: position {:?} is not finite", mesh.positions[i]));
    }
    if !mesh.alphas.is_empty() && mesh.alphas.len() != count {
        return wrong(format!("alpha: {} of them for {count} vertices", mesh.alphas.len()));
    }
    if let Some(i) = first(&mesh.alphas, |alpha| !(0.0..=1.0).contains(alpha)) {
        return wrong(format!("vertex {i}: alpha {} is not within 0 to 1", mesh.alphas[i]));
    }
    if !mesh.places.is_empty() && mesh.places.len() != count {
        let have = mesh.places.len();
        return wrong(format!("texture coordinates: {have} of them for {count} vertices"));
    }
    if let Some(i) = first(&mesh.places, |p| !p.iter().all(|c| c.is_finite())) {
        let place = mesh.places[i];
        return wrong(format!("vertex {i}: texture coordinates {place:?} are not finite"));
    }
    for (field, values) in [("normal", &mesh.normals), ("color", &mesh.colors)] {
        if !values.is_empty() && values.len() != count {
            return wrong(format!("{field}: {} of them for {count} vertices", values.len()));
        }
        if let Some(i) = first(values, |v| !v.iter().all(|c| c.is_finite())) {
            return wrong(format!("vertex {i}: {field} {:?} is not finite", values[i]));
        }
    }
    if let Some(i) = first(&mesh.colors, |c| !c.iter().all(|c| (0.0..=1.0).contains(c))) {
        return wrong(format!("vertex {i}: color {:?} is not within 0 to 1", mesh.colors[i]));
    }
    let out = |t: &[u32; 3]| t.iter().any(|&vertex| vertex as usize >= count);
    if let Some(i) = first(&mesh.triangles, out) {
        let corners = mesh.triangles[i];
        return wrong(format!(
            "triangle {i}: vertex of {corners:?} is not below the {count} vertices"
        ));
    }
    mesh.discs.iter().enumerate().try_for_each(|(i, disc)| check_disc(place, i, disc))
}

/// A disc's own promises.
fn check_disc(place: &str, index: usize, disc: &Disc) -> Result<()> {
    let wrong = |problem: String| Err(Error::new(place, format!("point {index}: {problem}")));
    if !disc.center.iter().all(|c| c.is_finite()) {
        return wrong(format!("position {:?} is not finite", disc.center));
    }
    if let Some(axis) = disc.axes.iter().find(|axis| !axis.iter().all(|c| c.is_finite())) {
        return wrong(format!("axis {axis:?} is not finite"));
    }
    if !disc.color.iter().all(|c| (0.0..=1.0).contains(c)) {
        return wrong(format!("color {:?} is not within 0 to 1", disc.color));
    }
    if !(0.0..=1.0).contains(&disc.alpha) {
        return wrong(format!("alpha {} is not within 0 to 1", disc.alpha));
    }
    if !(disc.sigmas >= 0.0 && disc.sigmas.is_finite()) {
        return wrong(format!("sigmas: {} must be finite and not below 0", disc.sigmas));
    }
    Ok(())
}

/// One screen triangle: corners in range, colour and opacity 0..1.
pub fn screen(place: &str, index: usize, triangle: &ScreenTriangle) -> Result<()> {
    let wrong = |problem: String| Err(Error::new(place, format!("screen {index}: {problem}")));
    for (corner, [x, y, z]) in triangle.points.into_iter().enumerate() {
        if ![x, y].iter().all(|c| (-MAX_PIXEL..=MAX_PIXEL).contains(c)) {
            return wrong(format!(
                "points[{corner}]: x, y = {x}, {y} is not within +-{MAX_PIXEL} pixels"
            ));
        }
        if !(0.0..=1.0).contains(&z) {
            return wrong(format!("points[{corner}]: z = {z} is not within 0 to 1"));
        }
    }
    let field = format!("screen {index}: color");
    triangle.color.into_iter().try_for_each(|channel| fraction(place, &field, channel))
}

fn triangles(place: &str, scene: &Scene) -> Result<()> {
    let placed = scene.objects.iter().map(|object| object.mesh.primitives());
    match placed.fold(scene.screen.len(), usize::saturating_add) {
        0 if scene.volumes.is_empty() && scene.objects.is_empty() => {
            Err(Error::new(place, "scene: has no triangle and no volume; it needs at least one"))
        }
        count if count > MAX_TRIANGLES => {
            let problem = format!("scene: {count} triangles are more than {MAX_TRIANGLES}");
            Err(Error::new(place, problem))
        }
        _ => Ok(()),
    }
}

fn light(place: &str, scene: &Scene) -> Result<()> {
    let length = scene.light.towards.length();
    if (length - 1.0).abs() > 1e-6 || length.is_nan() {
        return Err(Error::new(place, "light.towards: must be a direction, not zero, finite"));
    }
    fraction(place, "light.ambient", scene.light.ambient)
}

fn check_object(place: &str, index: usize, object: &Object, materials: usize) -> Result<()> {
    let wrong = |problem: &str| Err(Error::new(place, format!("object {index}: {problem}")));
    if object.material >= materials {
        return wrong("material: there is no such material");
    }
    mesh(place, &object.mesh)?;
    if !object.transform.is_finite() {
        return wrong("transform: must be finite");
    }
    let bounds = Bounds::of(std::slice::from_ref(object));
    let limit = DVec3::splat(MAX_COORDINATE);
    if !(bounds.min.cmpge(-limit).all() && bounds.max.cmple(limit).all()) {
        return wrong("vertices: a place in the world is beyond +-1e30");
    }
    Ok(())
}
