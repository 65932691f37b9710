//! A ball of long thin tubes that start near its middle and wander; every tenth strand is red. The papers draw
//! such a ball for its depth complexity, which is high and uneven.

use glam::DVec3;

use super::super::super::{Material, Mesh, Model};
use super::super::{Builtin, Key, Keys, Range};
use super::strand::{Tube, direction};
use crate::error::Result;
use crate::num::random::Random;

/// The most triangles.
const MAX_TRIANGLES: u64 = 1 << 24;

pub(in crate::scene::procedural) const BUILTIN: Builtin = Builtin {
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

fn generate(keys: &Keys<'_>, _: [u32; 2]) -> Result<Model> {
    let strands = keys.count("strands")?;
    let segments = keys.count("segments")?;
    let tube = Tube { sides: keys.count("sides")?, radius: keys.real("radius")?, taper: 0.0 };
    let (alpha, seed) = (keys.alpha()?, keys.seed()?);
    if 2 * u64::from(strands) * u64::from(segments * tube.sides) > MAX_TRIANGLES {
        let problem = format!("strands x segments x sides x 2 exceeds {MAX_TRIANGLES} triangles");
        return Err(keys.wrong("strands", &problem));
    }
    let mut meshes = [Mesh::default(), Mesh::default()];
    for strand in 0..strands {
        let path = wander(&mut Random::new(seed, u64::from(strand)), segments);
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
