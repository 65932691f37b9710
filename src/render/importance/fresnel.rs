//! The Fresnel term of a frame, for the importance of the next one.

use rayon::prelude::*;

use super::{fixed, pixels};
use crate::effect::lens::Lens;
use crate::fragment::{Data, data_of};
use crate::num::depth::Format;
use crate::raster::{FrontEnd, Grid, Record};
use crate::render::Options;
use crate::scene::Scene;
use crate::scheme::exact;

/// `I_f` of every pixel, row by row, in units of 2^-16: by the normal of the nearest fragment and the direction to the
/// eye. Where there is no fragment, or a triangle given in pixels, which has no place in the world, it is 1.
#[must_use]
pub fn fresnel(scene: &Scene, options: &Options) -> Vec<u32> {
    let grid = Grid { width: scene.size[0], height: scene.size[1], tile: options.tile };
    let front = FrontEnd::with_normals(scene, grid, options.sub_pixel_bits, options.cull_face);
    let lens = Lens::new(&scene.camera, scene.size, Format::D32);
    let record = Record { depth: Format::D32, data: Data::Primitive };
    let tile = |tile: usize| {
        let nearest = exact::tile(&front, tile, record, Some(1));
        let term = |(local, keys): (u32, &Vec<u64>)| {
            let (x, y) = grid.position(tile, local);
            let normal = keys.first().and_then(|&key| front.normal_of(data_of(key), x, y));
            fixed(normal.map_or(1.0, |n| term(n.map(f64::from), lens.sight(x, y).towards_eye())))
        };
        (0..).zip(&nearest).map(term).collect::<Vec<u32>>()
    };
    let tiles: Vec<Vec<u32>> = (0..grid.tiles()).into_par_iter().map(tile).collect();
    let per_tile = grid.pixels_per_tile() as u32;
    let of = |(x, y)| {
        let pixel = grid.pixel(x, y);
        tiles[(pixel / per_tile) as usize][(pixel % per_tile) as usize]
    };
    pixels(scene.size).map(of).collect()
}

/// 1 - (1 - n · e)^5 / 2.
fn term(normal: [f64; 3], eye: [f64; 3]) -> f64 {
    let cosine = (normal[0] * eye[0] + normal[1] * eye[1]) + normal[2] * eye[2];
    let grazing = 1.0 - cosine.clamp(0.0, 1.0);
    let square = grazing * grazing;
    1.0 - square * square * grazing * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{self, Overrides};

    #[test]
    fn the_term_at_known_angles() {
        let eye = [0.0, 0.0, 1.0];
        assert_eq!(term(eye, eye), 1.0);
        assert_eq!(term([1.0, 0.0, 0.0], eye), 0.5);
        assert_eq!(term([0.0, 0.0, -1.0], eye), 0.5, "from behind as at a grazing angle");
        let half = term([0.0, 0.75f64.sqrt(), 0.5], eye);
        assert!((half - (1.0 - 1.0 / 64.0)).abs() < 1e-12);
    }

    /// A ball is seen head-on in its middle, and at grazing angles at its rim.
    #[test]
    fn a_ball_dims_towards_its_rim() {
        let size = Some([65, 65]);
        let scene = scene::load("sphere", &Overrides { size, ..Overrides::default() }).unwrap();
        let words = fresnel(&scene, &Options::default());
        let row: Vec<u32> = words[32 * 65..33 * 65].to_vec();
        let (first, last) = (row.iter().position(|&w| w < 1 << 16).unwrap(), 32);
        assert!(row[first] < 50_000, "{row:?}");
        assert!(row[last] > 65_000, "{row:?}");
        assert!(words.iter().all(|&w| (1 << 15..=1 << 16).contains(&w)));
        assert_eq!(words[0], 1 << 16, "the background");
    }
}
