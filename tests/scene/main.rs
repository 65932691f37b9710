//! Scenes from every kind of source, and every kind of bad input with the message that it gets.

#![allow(
    clippy::unwrap_used,
    reason = "clippy takes only the tests themselves for tests, not their helpers"
)]

mod gltf;
mod gltf_parts;
mod hostile;
mod load;
mod models;
mod obj;
mod pcd;
mod ply;
mod points;
mod polygons;
mod procedural;
mod real;
mod stl;
mod textures;
mod volumes;

use fragloom::error::Result;
use fragloom::scene::Scene;
use glam::DVec3;

/// Asserts that a load fails with a message that holds all `parts`.
#[track_caller]
fn assert_fails<T>(result: Result<T>, parts: &[&str]) {
    let message = result.err().expect("must be refused").to_string();
    assert!(!message.contains('\n'), "one line: {message}");
    for part in parts {
        assert!(message.contains(part), "{message:?} does not say {part:?}");
    }
}

/// The corners of all placed triangles, in the world, in drawing order.
fn corners(scene: &Scene) -> Vec<[DVec3; 3]> {
    let objects = scene.objects.iter();
    objects.flat_map(|o| o.mesh.triangles.iter().map(|t| t.map(|i| o.world(i)))).collect()
}

/// Shorthand for a vertex in the world.
trait World {
    fn world(&self, vertex: u32) -> DVec3;
}

impl World for fragloom::scene::Object {
    fn world(&self, vertex: u32) -> DVec3 {
        let point = self.mesh.positions[vertex as usize];
        self.transform.transform_point3(DVec3::from(point))
    }
}
