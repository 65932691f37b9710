//! The fragments of all pixels for the page's inspector.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;
use serde::Serialize;

use super::block::{self, EDGE, Streams};
use super::{Page, Pictures};
use crate::effect::solids::Part;
use crate::error::{Error, Result};
use crate::fragment::Data;
use crate::inspect::frame::{Drawn, Frame};
use crate::num::depth::Format;
use crate::render::{Kept, Options};
use crate::scene::Scene;

/// What the script must know to read the blocks.
#[derive(Clone, Debug, Serialize)]
pub(super) struct Pixels {
    scene: String,
    /// Pixels of a block's edge.
    edge: u32,
    /// The blocks' names, row by row.
    blocks: Vec<String>,
    methods: Vec<Method>,
    /// Names of objects; the triangles below `ends[i]` that no earlier part has are of `objects[solids[i]]`.
    objects: Vec<String>,
    ends: Vec<u32>,
    solids: Vec<usize>,
    depth_format: Format,
    near: f64,
    far: f64,
    parallel: bool,
    background: [f32; 3],
}

#[derive(Clone, Debug, Serialize)]
struct Method {
    title: String,
    method: String,
    exec: String,
    k: Option<u32>,
    /// `fragments`, `records`, `color` or nothing.
    holds: &'static str,
    /// The data word that is stored with a depth: `color`, `primitive` or `none`.
    data: &'static str,
    warnings: Vec<String>,
    violations: Vec<String>,
}

/// A frame's blocks, to which methods are added one after another.
pub struct Blocks<'a> {
    frame: &'a Frame<'a>,
    methods: Vec<Method>,
    /// For each block, the streams so far.
    blocks: Vec<Streams>,
}

impl<'a> Blocks<'a> {
    /// The fragments, and what they give, without any method.
    #[must_use]
    pub fn new(frame: &'a Frame<'a>) -> Self {
        let numbers = 0..block::count(frame.size());
        let blocks = numbers.into_par_iter().map(|number| block::fragments(frame, number));
        Self { frame, methods: Vec::new(), blocks: blocks.collect() }
    }

    /// Add what a method made of every pixel.
    pub fn add(&mut self, options: &Options, drawn: &Drawn<'_>) {
        let frame = self.frame;
        self.blocks.par_iter_mut().enumerate().for_each(|(number, streams)| {
            streams.extend(block::method(frame, options, drawn, number as u32));
        });
        let report = &drawn.rendering.report;
        self.methods.push(Method {
            title: drawn.title(),
            method: options.method.name().to_owned(),
            exec: report.exec.clone(),
            k: drawn.k(),
            holds: match drawn.rendering.kept {
                Kept::Fragments(_) => "fragments",
                Kept::Records(_) => "records",
                Kept::Color(_) => "color",
                Kept::Depths(_) | Kept::Gone(_) => "",
            },
            data: match options.record().data {
                Data::Primitive => "primitive",
                Data::Color => "color",
                Data::Nothing => "none",
            },
            warnings: report.warnings.clone(),
            violations: report.violations.clone(),
        });
    }
}

/// Give the pictures of a scene a pixel inspector.
///
/// # Errors
/// None that can be told apart: the compressor's.
pub fn add(
    page: &mut Page,
    pictures: &mut Pictures,
    scene: &Scene,
    blocks: Blocks<'_>,
) -> Result<()> {
    let Blocks { frame, methods, blocks } = blocks;
    let packed: Vec<Vec<u8>> = blocks
        .into_par_iter()
        .map(|streams| pack(&block::join(&[&streams])))
        .collect::<std::io::Result<_>>()
        .map_err(|error| Error::new("the page", error.to_string()))?;
    let distances = frame.distances();
    let parts = frame.solids().parts();
    pictures.pixels = Some(Pixels {
        scene: scene.name.clone(),
        edge: EDGE,
        blocks: packed.into_iter().map(|bytes| page.attach(bytes, false)).collect(),
        methods,
        objects: frame.solids().names().to_vec(),
        ends: parts.iter().map(Part::end).collect(),
        solids: parts.iter().map(|part| part.solid).collect(),
        depth_format: distances.format,
        near: distances.planes.near,
        far: distances.planes.far,
        parallel: distances.planes.parallel,
        background: scene.background,
    });
    Ok(())
}

/// In zlib's format, which browsers call `deflate`.
fn pack(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes)?;
    encoder.finish()
}
