//! All of a scene, set up part by part.

use rayon::prelude::*;

use super::super::place::Placed;
use super::PART;
use super::part::{Part, Target};
use super::pieces::{Piece, Source};
use super::room::Room;
use crate::scene::{Object, Scene};

/// Objects are placed together until they have as many triangles, discs and vertices as this: enough for all threads,
/// however small objects are, and no more memory than one large object takes.
const GROUP: usize = 1 << 18;

/// All of a scene in submission order, and how many triangles and discs it has.
pub(super) fn set_up(scene: &Scene, target: Target, room: &Room) -> (Vec<Part>, u64) {
    let view_projection = scene.camera.view_projection(scene.size);
    let mut parts = Vec::new();
    let mut first = 0;
    for group in groups(&scene.objects) {
        let place =
            |object| Placed::new(object, scene, view_projection, &target.viewport, room.vertices());
        let placed: Vec<Placed<'_>> = group.iter().map(place).collect();
        let mut pieces = Vec::new();
        for object in &placed {
            let mesh = object.mesh();
            pieces.push(Piece { source: Source::Triangles(object, &mesh.triangles), first });
            first += mesh.triangles.len() as u32;
            pieces.push(Piece { source: Source::Discs(object, &mesh.discs), first });
            first += mesh.discs.len() as u32;
        }
        add(&mut parts, pieces, target, room);
        placed.into_iter().for_each(|object| room.keep_vertices(object.leave()));
    }
    add(&mut parts, vec![Piece { source: Source::Screen(&scene.screen), first }], target, room);
    (parts, u64::from(first) + scene.screen.len() as u64)
}

/// Objects that are placed together.
fn groups(objects: &[Object]) -> impl Iterator<Item = &[Object]> {
    let mut size = 0;
    objects.chunk_by(move |object, _| {
        size += object.mesh.primitives() + object.mesh.positions.len();
        let goes_on = size < GROUP;
        size = if goes_on { size } else { 0 };
        goes_on
    })
}

/// Set up pieces, in parts of [`PART`] triangles and discs, but for the last.
fn add(parts: &mut Vec<Part>, pieces: Vec<Piece<'_>>, target: Target, room: &Room) {
    let mut filled: Vec<Vec<Piece<'_>>> = Vec::new();
    let (mut last, mut left) = (Vec::new(), PART);
    for mut piece in pieces {
        while piece.len() > 0 {
            let taken = piece.take(left);
            left -= taken.len();
            last.push(taken);
            if left == 0 {
                filled.push(std::mem::take(&mut last));
                left = PART;
            }
        }
    }
    filled.push(last);
    parts.par_extend(filled.par_iter().map(|pieces| room.part().fill(pieces, target)));
}
