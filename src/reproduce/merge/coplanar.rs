//! What a picture shows if faces in one plane are mixed: known from where the faces are, not from depths.

use crate::error::Result;
use crate::fragment::{data_of, depth_of};
use crate::image::Image;
use crate::num::color::word16;
use crate::raster::{CullFace, FrontEnd, Grid};
use crate::render::{Data, Options, render};
use crate::resolve::composite::Ray;
use crate::scene::Scene;
use crate::scheme::Record;
use crate::scheme::merging::slab::{Visibility, mix};

/// The plane of a face that is aligned to the axes: its axis, and where it cuts that axis in millionths of a world unit.
/// Of any other face, 3 and its object.
pub(super) type Face = (usize, i64);

/// The picture, and what is at its pixels.
pub(super) struct Blended {
    /// Faces of one plane mixed (equations 6 to 8), and then composited in their planes' order.
    pub(super) image: Image,
    /// The faces at every pixel from the front, each plane once.
    pub(super) stacks: Vec<Vec<Face>>,
    /// Pixels with several faces in one plane.
    pub(super) coplanar: Vec<bool>,
}

/// The face of every primitive.
fn faces(scene: &Scene) -> Vec<Face> {
    let mut faces = Vec::new();
    for (number, object) in (0..).zip(&scene.objects) {
        for triangle in &object.mesh.triangles {
            let corners = triangle.map(|i| {
                let position = object.mesh.positions[i as usize];
                let corner = object.transform.transform_point3(position.into());
                corner.to_array().map(|x| (x * 1e6).round() as i64)
            });
            let aligned = (0..3).find(|&axis| corners.iter().all(|c| c[axis] == corners[0][axis]));
            faces.push(aligned.map_or((3, number), |axis| (axis, corners[0][axis])));
        }
        faces.extend(object.mesh.discs.iter().map(|_| (3, number)));
    }
    faces
}

/// Draw it.
pub(super) fn blended(scene: &Scene) -> Result<Blended> {
    let options =
        Options { data: Data::Primitive, counters: false, ..Options::default().exact(None) };
    let drawn = render(scene, &options)?;
    let lists = drawn.lists()?;
    let [width, height] = scene.size;
    let front = FrontEnd::new(scene, Grid { width, height, tile: 64 }, 8, CullFace::None);
    let faces = faces(scene);
    let background = scene.background.map(word16);
    let (mut pixels, mut stacks, mut coplanar) = (Vec::new(), Vec::new(), Vec::new());
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let mut layers: Vec<Layer> = Vec::new();
        for &key in lists.pixel(x, y) {
            let (depth, triangle) = (depth_of(key), data_of(key));
            let face = faces.get(triangle as usize).copied().unwrap_or((3, -1));
            let color = front.color_of(triangle, x, y, depth);
            let one = Layer::new(face, Visibility::new(Record::surface(depth, color).rgba));
            match layers.iter_mut().find(|layer| face.0 < 3 && layer.face == face) {
                Some(layer) => layer.mix(&one),
                None => layers.push(one),
            }
        }
        let mut ray = Ray::default();
        for layer in &layers {
            ray.over_record(&Record { rgba: layer.visibility.rgba(), ..Record::default() });
        }
        pixels.push(ray.finish(background));
        coplanar.push(layers.iter().any(|layer| layer.several));
        stacks.push(layers.into_iter().map(|layer| layer.face).collect());
    }
    Ok(Blended { image: Image { width, height, pixels }, stacks, coplanar })
}

/// What lies in one plane.
struct Layer {
    face: Face,
    visibility: Visibility,
    sum: f64,
    several: bool,
}

impl Layer {
    fn new(face: Face, visibility: Visibility) -> Self {
        Self { face, visibility, sum: visibility.opacity, several: false }
    }

    fn mix(&mut self, other: &Self) {
        self.visibility = mix((self.visibility, self.sum), (other.visibility, other.sum));
        self.sum += other.sum;
        self.several = true;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{TWINS, load};
    use super::*;

    /// The twins share their fronts where they overlap, and nothing at their ends.
    #[test]
    fn shared_planes_are_found() {
        let scene = load(TWINS, 48).unwrap();
        let blended = blended(&scene).unwrap();
        let shared = blended.coplanar.iter().filter(|&&c| c).count();
        assert!(shared > 300 && shared < 48 * 48 / 2, "{shared}");
        let front: Face = (2, 1_000_000);
        let [middle, corner] = [24 * 48 + 24, 0];
        assert!(blended.stacks[middle].contains(&front) && blended.coplanar[middle]);
        assert!(blended.stacks[corner].is_empty() && !blended.coplanar[corner]);
        // Where nothing is shared, it is the exact picture.
        let exact = render(&scene, &Options::default().exact(None)).unwrap().image;
        for (i, pixel) in blended.image.pixels.iter().enumerate() {
            assert!(blended.coplanar[i] || *pixel == exact.pixels[i], "{i}");
        }
    }
}
