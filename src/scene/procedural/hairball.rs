//! A ball of long thin tubes that start near its middle and wander; every tenth strand is red. The papers draw
//! such a ball for its depth complexity, which is high and uneven.

use glam::DVec3;

use super::super::{Material, Mesh, Model};
use super::shape::{on_circle, point};
use super::{Builtin, Key, Keys, Range};
use crate::error::Result;
use crate::num::random::Random;

/// The most triangles.
const MAX_TRIANGLES: u64 = 1 << 24;

pub(super) const BUILTIN: Builtin = Builtin {
    name: "hairball",
    about: "thin tubes that wander through a ball of radius 1, every tenth one red",
    in_pixels: false,
    keys: &[
        Key { name: "strands", default: "1000", range: Range::Count(1, 100_000), about: "tubes" },
        Key {
            name: "segments",
            default: "32",
            range: Range::Count(1, 1024),
            about: "straight pieces of a tube",
        },
        Key { name: "sides", default: "5", range: Range::Count(3, 64), about: "of a tube" },
        Key {
            name: "radius",
            default: "0.006",
            range: Range::Real(1e-6, 0.5),
            about: "of a tube; the ball's is 1",
        },
        Key::alpha("0.3"),
        Key::SEED,
    ],
    generate,
};

/// A tube's cross-section and length.
struct Tube {
    segments: u32,
    sides: u32,
    radius: f64,
}

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let strands = keys.count("strands")?;
    let tube = Tube {
        segments: keys.count("segments")?,
        sides: keys.count("sides")?,
        radius: keys.real("radius")?,
    };
    let (alpha, seed) = (keys.alpha()?, keys.seed()?);
    if 2 * u64::from(strands) * u64::from(tube.segments * tube.sides) > MAX_TRIANGLES {
        let problem = format!("strands x segments x sides x 2 exceeds {MAX_TRIANGLES} triangles");
        return Err(keys.wrong("strands", &problem));
    }
    let mut meshes = [Mesh::default(), Mesh::default()];
    for strand in 0..strands {
        let path = wander(&mut Random::new(seed, u64::from(strand)), tube.segments);
        tube.add(&path, &mut meshes[usize::from(strand % 10 == 0)]);
    }
    let mut model = Model::default();
    let looks = [("hair", [0.35, 0.25, 0.15]), ("red hair", [0.8, 0.05, 0.05])];
    for (mesh, (name, color)) in meshes.into_iter().zip(looks) {
        let material = model.add_material(Material::new(name, color, alpha));
        model.add_mesh(mesh, material);
    }
    Ok(model)
}

/// A path of `segments` steps from near the middle outwards, bent at random and kept in the ball.
fn wander(random: &mut Random, segments: u32) -> Vec<DVec3> {
    let mut at = direction(random) * 0.2;
    let mut heading = direction(random);
    let step = 2.5 / f64::from(segments);
    let bend = libm::sqrt(step) * 0.9;
    let mut path = vec![at];
    for _ in 0..segments {
        heading = (heading + direction(random) * bend).normalize_or(heading);
        let outside = (at + heading * step).length() - 0.97;
        if outside > 0.0 {
            // Along the surface, and a little inwards.
            let out = at.normalize_or(heading);
            heading = (heading - out * (heading.dot(out) + 0.1)).normalize_or(-out);
        }
        at += heading * step;
        path.push(at);
    }
    path
}

/// A uniformly random unit vector, by rejection.
fn direction(random: &mut Random) -> DVec3 {
    loop {
        let v = DVec3::from([(); 3].map(|()| random.range(-1.0, 1.0)));
        let square = v.length_squared();
        if square > 1e-4 && square <= 1.0 {
            return v / libm::sqrt(square);
        }
    }
}

impl Tube {
    /// Adds a tube along a path. Its cross-section is carried along without twist.
    fn add(&self, path: &[DVec3], mesh: &mut Mesh) {
        let first = mesh.positions.len() as u32;
        let mut across = (path[1] - path[0]).any_orthogonal_vector();
        for (i, &center) in path.iter().enumerate() {
            let ends = [path[i.saturating_sub(1)], path[(i + 1).min(path.len() - 1)]];
            let along = (ends[1] - ends[0]).normalize_or(DVec3::Y);
            across =
                (across - along * along.dot(across)).normalize_or(along.any_orthonormal_vector());
            let other = along.cross(across);
            for (c, s) in (0..self.sides).map(|side| on_circle(side, self.sides)) {
                let normal = across * c + other * s;
                mesh.positions.push(point(center + normal * self.radius));
                mesh.normals.push(point(normal));
            }
        }
        for ring in 0..self.segments {
            let start = first + ring * self.sides;
            for side in 0..self.sides {
                let [a, b] = [start + side, start + (side + 1) % self.sides];
                let [c, d] = [a + self.sides, b + self.sides];
                mesh.triangles.extend([[a, b, d], [a, d, c]]);
            }
        }
    }
}
