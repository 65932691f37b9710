//! The cameras of nodes. They only matter where somebody asks for one by its name, so a broken one is left out.

use glam::DMat4;
use serde_json::Value;

use super::super::parts::Tally;
use super::super::{NamedCamera, Projection};
use super::json;
use crate::scene::model::Unplaced;

/// The camera of a node at `transform`, if it has one.
pub(super) fn of_node(
    root: &Value,
    node: &Value,
    transform: DMat4,
    name: &str,
    tally: &mut Tally,
) -> Option<NamedCamera> {
    let found = json::index(node, "camera").and_then(|index| match index {
        Some(index) => read(root, index).map(Some),
        None => Ok(None),
    });
    match found {
        Ok(found) => found.map(|(own, projection, planes)| {
            let node = json::text(node, "name").unwrap_or_default().to_owned();
            NamedCamera { names: [own, node], transform, projection, planes }
        }),
        Err(problem) => {
            tally.add("the camera is left out", || format!("{name}: {problem}"));
            None
        }
    }
}

type Found = (String, Projection, [Option<f64>; 2]);

fn read(root: &Value, index: usize) -> Unplaced<Found> {
    let cameras = json::list(root, "cameras")?;
    let missing = || format!("camera: {index} is not among the {}", cameras.len());
    let camera = cameras.get(index).ok_or_else(missing)?;
    let name = json::text(camera, "name").unwrap_or_default().to_owned();
    let kind = json::text(camera, "type").unwrap_or_default();
    let wrong = |problem: String| format!("camera {index}: {problem}");
    let missing = |key: &str| wrong(format!("{key}: is missing"));
    let table = json::get(camera, kind).ok_or_else(|| missing("perspective or orthographic"))?;
    let number = |key: &str| json::number(table, key).map_err(wrong);
    let needed = |key: &str| number(key)?.ok_or_else(|| missing(key));
    let projection = match kind {
        "perspective" => Projection::Perspective { fov_y: needed("yfov")?.to_degrees() },
        "orthographic" => Projection::Orthographic { height: 2.0 * needed("ymag")?.abs() },
        _ => return Err(wrong("type: must be perspective or orthographic".to_owned())),
    };
    Ok((name, projection, [number("znear")?, number("zfar")?]))
}
