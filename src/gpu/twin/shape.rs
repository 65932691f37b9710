//! What a method is to a device: buffers for its words, constants before its text, and fragments as words.

use super::source::Constants;
use crate::error;
use crate::exec::Method;
use crate::fragment::{Data, Fragment};
use crate::gpu::driver::device::Device;
use crate::gpu::driver::failure::{Failure, Result};
use crate::memory::{Inputs, Layout};
use crate::num::depth::Format;
use crate::raster::Record;
use crate::scheme::Config;
use crate::scheme::approximate::wboit::Weight;
use crate::scheme::contract::{Contract, Keeps};
use crate::scheme::culling::occupancy::MOST_WORDS;

/// Bytes of a fragment.
pub(in crate::gpu) const FRAGMENT: u64 = size_of::<Words>() as u64;

/// A fragment as `shared/fragment.wgsl` has it: pixel, depth, data, the third word, and room for the outcome.
pub type Words = [u32; 5];

/// Extra room at the end of every buffer of words: a struct in WGSL ends with an array of at least one element.
pub(super) const SPARE: u64 = 64;

/// What a method's type determines: its words, and how many invocations its passes over the frame have.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Its contract.
    pub contract: &'static Contract,
    /// Its configuration.
    pub config: Config,
    /// Its words.
    pub layout: Layout,
    /// By pass of the program.
    pub invocations: Vec<u32>,
    /// The words of its inputs; their defaults, unless they are filled.
    pub inputs: Inputs,
}

impl Shape {
    /// The shape of a method with a configuration.
    ///
    /// # Errors
    /// The method is the oracle, which has no passes.
    pub fn new(method: Method, config: Config) -> error::Result<Self> {
        let contract = method.contract();
        let instance = method.instance(&config).ok_or_else(|| {
            error::Error::new("-m", format!("{method} is sequential: it has no passes"))
        })?;
        let passes = 0..contract.program.passes.len();
        let invocations = passes.map(|pass| instance.invocations(pass)).collect();
        let layout = instance.layout().clone();
        let inputs = Inputs::defaults(&layout);
        Ok(Self { contract, config, layout, invocations, inputs })
    }

    /// The words of all inputs, one after another.
    pub(super) fn input_words(&self) -> Vec<u32> {
        self.inputs.tables(&self.layout, self.config.pixels).concat()
    }

    /// Bytes of a binding of the first group: 32 and 64-bit words of pixels, then of the frame.
    #[must_use]
    pub fn bytes(&self, binding: u32) -> u64 {
        let (pixel, frame) = (self.layout.per_pixel(), self.layout.per_frame());
        let pixels = u64::from(self.config.pixels);
        match binding {
            0 => 4 * pixel.words32 * pixels,
            1 => 8 * pixel.words64 * pixels,
            2 => 4 * frame.words32,
            _ => 8 * frame.words64,
        }
    }

    /// Whether a device has room for every buffer of words.
    ///
    /// # Errors
    /// The first that is too large.
    pub fn fits(&self, device: &Device) -> Result<()> {
        for binding in 0..4 {
            let (bytes, most) = (self.bytes(binding) + SPARE, device.largest());
            if bytes > most {
                let name = self.contract.name;
                let problem = format!("{name} needs a buffer of {bytes} bytes, at most {most}");
                return Err(Failure::TooLarge(problem));
            }
        }
        Ok(())
    }
}

/// The constants before a twin.
#[must_use]
pub fn constants(shape: &Shape, record: Record, background: [u16; 3]) -> Constants {
    let config = &shape.config;
    let (grid, table) = (config.grid, config.table);
    let pixels = u64::from(config.pixels);
    let blocks = pixels.div_ceil(64).max(1);
    // Only what keeps the first k has no more slots than that.
    let limited = config.k.filter(|_| shape.contract.keeps == Keeps::FirstArrivals);
    let slots = limited.unwrap_or(config.max_depth_complexity);
    let [red, green, blue] = background.map(u64::from);
    let (mut constants, mut first) = (Constants::default(), 0);
    let tables = shape.inputs.tables(&shape.layout, config.pixels);
    for (input, words) in shape.layout.inputs().iter().zip(tables) {
        let name = input.name.to_uppercase().replace(|c: char| !c.is_alphanumeric(), "_");
        constants = constants.with(&format!("INPUT_{name}"), first);
        first += words.len() as u64;
    }
    if shape.contract.keeps.is_approximate() {
        constants = of_approximation(constants, shape);
    }
    constants
        .with("PIXELS", pixels)
        .with("WIDTH", grid.width.into())
        .with("HEIGHT", grid.height.into())
        .with("TILE", grid.tile.into())
        .with("COLUMNS", if grid.tile == 0 { 1 } else { grid.columns().into() })
        .with("K", config.k.or(shape.contract.default_k).unwrap_or(8).into())
        .with_room("SLOTS", slots.into())
        .with_room("GENERATED", config.generated)
        .with_room("BOUNDED", config.bounded)
        .with_room("PAGES", config.pages)
        .with_room("RECORDS", config.records)
        .with("ALPHA", config.weighting.alpha.into())
        .with("LAYERS", config.weighting.limit.into())
        .with("MASK_WORDS", config.mask_words.clamp(1, MOST_WORDS).into())
        .with("BLOCKS", blocks)
        .with("GROUPS", blocks.div_ceil(64))
        .with("TABLE_WIDTH", table.size[0].max(1).into())
        .with("TABLE_HEIGHT", table.size[1].max(1).into())
        .with("CELLS", table.cells().max(1))
        .with("AGES", table.ages.into())
        .with("DATA_IS_TRIANGLE", (record.data == Data::Primitive).into())
        .with("HOLDS_RECORDS", holds_no_list(shape.contract).into())
        .with("DEPTH_SHIFT", if record.depth == Format::D24 { 8 } else { 0 })
        .with("BACKGROUND_R", red)
        .with("BACKGROUND_G", green)
        .with("BACKGROUND_B", blue)
}

/// Whether what resolve emits is no list of fragments, to be sorted and composited.
fn holds_no_list(contract: &Contract) -> bool {
    contract.keeps == Keeps::Merged || contract.keeps.is_approximate()
}

/// The constants of methods that approximate. What is a float is computed in f64, and rounded once.
fn of_approximation(constants: Constants, shape: &Shape) -> Constants {
    let approximation = shape.config.approximation;
    let planes = shape.config.distances.planes;
    let (near, far, last) = (planes.near, planes.far, f64::from(u32::MAX));
    let weight = Weight::ALL.iter().position(|&weight| weight == approximation.weight);
    constants
        .with("WORDS64", shape.layout.per_pixel().words64)
        .with("SAMPLES", approximation.samples.into())
        .with("SEED_LOW", approximation.seed & u64::from(u32::MAX))
        .with("SEED_HIGH", approximation.seed >> 32)
        .with("MOMENTS", approximation.moments.into())
        .with("WEIGHT", weight.unwrap_or_default() as u64)
        .with("PARALLEL", planes.parallel.into())
        .with_float("NEAR", near)
        .with_float("DEPTH_STEP", (far - near) / last)
        .with_float("NEAR_TIMES_FAR", near * far)
        .with_float("NEAR_PER_FAR", near / far)
        .with_float("SHARE_STEP", (1.0 - near / far) / last)
        .with_float("TWICE_PER_LOG", 2.0 / libm::log(far / near))
        .with_float("TWICE_PER_DEPTH", 2.0 / last)
}

/// A fragment's words.
#[must_use]
pub fn words_of(fragment: &Fragment) -> Words {
    [fragment.pixel, fragment.depth, fragment.data, fragment.extra, 0]
}
