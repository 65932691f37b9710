//! What another renderer should make of an exported scene, and where it may rightly differ.

mod near;

use serde::Serialize;

pub use self::near::near_edges;
use self::near::{edges, ties};
use crate::error::Result;
use crate::num::color;
use crate::raster::{FrontEnd, Grid};
use crate::render::{Options, Rendering};
use crate::scene::export::Exported;
use crate::scene::{Projection, Scene};

/// Pixels whose centre is this near to an edge may be covered or not where vertices are snapped in another way: 1/16 of
/// a pixel, as far as 4 sub-pixel bits can move an edge, and more than 8 can.
pub const EDGE_DISTANCE: f64 = 1.0 / 16.0;

/// Depths this near to each other, 0 to 1, may change their order where they are computed in 24 bits or in 32-bit
/// floating point.
pub const DEPTH_DISTANCE: f64 = 1.0 / 4_194_304.0;

/// The format of the document.
const FORMAT: u32 = 1;

/// The document beside an exported scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Expected {
    /// Of this document: 1.
    pub format: u32,
    /// The version of the program.
    pub program: &'static str,
    /// The scene's name.
    pub scene: String,
    /// The files that belong together, by what they are.
    pub files: Files,
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Linear RGB, 0..1.
    pub background: [f32; 3],
    /// The same as bytes of sRGB.
    pub background_srgb: [u8; 3],
    /// The camera, in the numbers that are drawn with.
    pub camera: Seen,
    /// Bits after the point of a vertex's pixel coordinates.
    pub sub_pixel_bits: u32,
    /// Fragments.
    pub generated: u64,
    /// The most of them at a pixel.
    pub max_depth_complexity: u32,
    /// SHA-256 of the fragment lists, hexadecimal.
    pub fragments_hash: Option<String>,
    /// SHA-256 of the picture, hexadecimal.
    pub image_hash: String,
    /// Whether this program draws the same bytes from the exported files.
    pub exact: bool,
    /// How many numbers of the scene were rounded to 32 bits.
    pub rounded: u64,
    /// Where another renderer may differ.
    pub tolerances: Tolerances,
}

/// Names of files.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Files {
    /// The scene as glTF.
    pub gltf: String,
    /// A scene file for this program.
    pub scene: String,
    /// The picture.
    pub picture: String,
    /// The fragments of every pixel, front to back.
    pub fragments: String,
}

/// A camera.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Seen {
    /// `perspective` or `orthographic`.
    pub projection: &'static str,
    /// From world to clip space, column by column: x to the right, y up, depth from 0 (near) to w (far).
    pub view_projection: [f64; 16],
    /// Distance of the near plane.
    pub near: f64,
    /// Distance of the far plane.
    pub far: f64,
}

/// Where another renderer may rightly differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Tolerances {
    /// Steps of an 8-bit channel, by which rounding may differ everywhere.
    pub channel: u8,
    /// Pixels; see `edges`.
    pub edge_distance: f64,
    /// Pixels whose centre is at most `edge_distance` from an edge: as rows, `[y, first x, one past the last x]`.
    pub edges: Vec<[u32; 3]>,
    /// Depth, 0..1; see `ties`.
    pub depth_distance: f64,
    /// Pixels with two fragments whose depths are at most `depth_distance` apart, and of two colours, as rows.
    pub ties: Vec<[u32; 3]>,
}

impl Expected {
    /// Of a scene, what it was exported to, and what was drawn of it with the fragments' colours as data; `again` is what
    /// was drawn of what was exported.
    ///
    /// # Errors
    /// `drawn` has no lists of fragments.
    pub fn of(
        scene: &Scene,
        (exported, files): (&Exported, Files),
        options: &Options,
        drawn: &Rendering,
        again: &Rendering,
    ) -> Result<Self> {
        let (report, size) = (&drawn.report, scene.size);
        let projection = match exported.camera.projection {
            Projection::Perspective { .. } => "perspective",
            Projection::Orthographic { .. } => "orthographic",
        };
        let camera = Seen {
            projection,
            view_projection: exported.camera.view_projection(size).to_cols_array(),
            near: exported.camera.near,
            far: exported.camera.far,
        };
        let grid = Grid { width: size[0], height: size[1], tile: options.tile };
        let front = FrontEnd::outlined(scene, grid, options.sub_pixel_bits, options.cull_face);
        let tolerances = Tolerances {
            channel: 1,
            edge_distance: EDGE_DISTANCE,
            edges: edges(&front, size, EDGE_DISTANCE),
            depth_distance: DEPTH_DISTANCE,
            ties: ties(drawn.lists()?, options.record().depth, DEPTH_DISTANCE),
        };
        Ok(Self {
            format: FORMAT,
            program: env!("CARGO_PKG_VERSION"),
            scene: scene.name.clone(),
            files,
            size,
            background: scene.background,
            background_srgb: scene.background.map(|c| color::srgb(color::word16(c))),
            camera,
            sub_pixel_bits: options.sub_pixel_bits,
            generated: report.generated,
            max_depth_complexity: report.max_depth_complexity,
            fragments_hash: report.fragments_hash.clone(),
            image_hash: report.image_hash.clone(),
            exact: report.image_hash == again.report.image_hash
                && report.fragments_hash == again.report.fragments_hash,
            rounded: exported.rounded,
            tolerances,
        })
    }
}
