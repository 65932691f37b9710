//! The scene file beside a `.glb` file: what glTF has no place for, or rounds.

use super::super::{Camera, Projection, Scene};

/// The text. Numbers are written so that they are read back as the same.
pub(super) fn text(scene: &Scene, camera: &Camera, file: &str) -> String {
    let three = |v: [f64; 3]| format!("[{:?}, {:?}, {:?}]", v[0], v[1], v[2]);
    let [width, height] = scene.size;
    let [r, g, b] = scene.background;
    let projection = match camera.projection {
        Projection::Perspective { fov_y } => format!("fov_y = {fov_y:?}"),
        Projection::Orthographic { height } => format!("ortho_height = {height:?}"),
    };
    let [eye, target, up] = [camera.eye, camera.target, camera.up].map(|v| three(v.to_array()));
    let [near, far] = [camera.near, camera.far].map(|plane| format!("{plane:?}"));
    let towards = three(scene.light.towards.to_array());
    let (ambient, file) = (scene.light.ambient, toml::Value::from(file));
    format!(
        "\
# Written by fragloom export: draws {file} as it was exported.
size = [{width}, {height}]
background = [{r:?}, {g:?}, {b:?}]

[camera]
eye = {eye}
target = {target}
up = {up}
{projection}
near = {near}
far = {far}

[light]
towards = {towards}
ambient = {ambient:?}

[[object]]
file = {file}
"
    )
}
