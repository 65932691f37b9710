//! What to draw with and how, and checks of these options.

use crate::catalogue;
use crate::effect::Effect;
use crate::effect::volume::Marching;
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::fragment::Data;
use crate::num::depth;
use crate::raster::{CullFace, Record};
use crate::scene::{MAX_SIZE, Scene, Thickness};
use crate::scheme::HeldKind;
use crate::scheme::approximate::Approximation;
use crate::scheme::approximate::stochastic::MOST_SAMPLES;
use crate::scheme::merging::Merging;

use super::culling;
use super::importance::Importance;
use super::inputs::Given;
use super::no_lists;
use super::table::TableOptions;

pub use crate::exec::sim::policy::Policy;
pub use crate::fragment::sort::Sort;

/// What is wanted of the lists that pixels keep, of fragments or of merged records. Less takes less memory and time;
/// colours and depths are always at hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Wanted {
    /// Their lists, and the hash of them.
    #[default]
    Lists,
    /// The hash alone: 8 bytes a fragment, 12 if it may be thick, by tile.
    Hash,
    /// Nothing: lists are needed for the tiles in work alone, unless the accounting compares them with the exact ones,
    /// as for racy methods.
    Picture,
}

/// What to draw with, and how. The defaults are the command line's.
#[derive(Clone, Debug)]
pub struct Options {
    /// The method.
    pub method: Method,
    /// Fragments kept per pixel, at least 1; `None` is the method's own default (8 for k-buffers, all for `exact` and
    /// A-buffers).
    pub k: Option<u32>,
    /// The executor of the invocations.
    pub exec: Exec,
    /// Worker threads, at most [`MAX_THREADS`]; 0 means one per core.
    pub threads: usize,
    /// Tile edge in pixels: 16, 32 or 64.
    pub tile: u32,
    /// Sub-pixel bits that vertices are snapped to: 8 or 4.
    pub sub_pixel_bits: u32,
    /// What is stored for a depth; `None` is the method's own.
    pub depth_format: Option<depth::Format>,
    /// What is stored beside a depth.
    pub data: Data,
    /// Which faces are not drawn.
    pub cull_face: CullFace,
    /// What is made from the lists. [`Effect::Media`] and [`Effect::Csg`] need [`Data::Primitive`].
    pub effect: Effect,
    /// Give the picture in 16 bits of linear light as well. For surfaces that are composited: without volumes, and
    /// with [`Effect::Transparency`].
    pub linear: bool,
    /// Leave the background out: the picture keeps its opacity, and its colours are not multiplied by it. For surfaces
    /// that are composited, too.
    pub transparent: bool,
    /// How rays go through the scene's volumes.
    pub volumes: Marching,
    /// Shadows by a second frame, from the light.
    pub shadows: Option<Shadows>,
    /// Count memory operations.
    pub counters: bool,
    /// Bytes that the method's storage may take: k, or the room for fragments, is the largest that fits. Not together
    /// with `k`, where storage depends on it.
    pub memory_budget: Option<u64>,
    /// The method's inputs, by name; those that are not given have their defaults.
    pub inputs: Vec<(String, Given)>,
    /// Cull fragments before the method sees them, by an occupancy mask of this many words a pixel, 1 to 256. For a
    /// method that keeps the nearest fragments, and for the culling passes themselves (32, if it is not given).
    pub cull: Option<u32>,
    /// For a method that divides records by importance: how many a pixel has on average, 0 or more; `None` is `k`. Not
    /// together with a memory budget.
    pub k_average: Option<f64>,
    /// What makes a pixel important.
    pub importance: Importance,
    /// How thick surfaces are that do not say so themselves, for a method that merges.
    pub thickness: Thickness,
    /// Where slabs are cut: from optical, 0, to smooth, 1.
    pub beta: f64,
    /// What methods that approximate take.
    pub approximation: Approximation,
    /// How hash tables are made.
    pub table: TableOptions,
    /// How a pixel's fragments are sorted.
    pub sort: Sort,
    /// What is wanted of the fragments. Whatever an effect needs is at hand in any case.
    pub wanted: Wanted,
    /// Bytes above which a run is refused before they are allocated: the method's storage with what executors keep of
    /// every pixel, and the kept fragments (16 bytes each) or merged records (68).
    pub max_memory: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: catalogue::DEFAULT,
            k: None,
            exec: Exec::Tile,
            threads: 0,
            tile: 64,
            sub_pixel_bits: 8,
            depth_format: None,
            data: Data::Color,
            cull_face: CullFace::None,
            effect: Effect::default(),
            linear: false,
            transparent: false,
            volumes: Marching::default(),
            shadows: None,
            counters: true,
            memory_budget: None,
            inputs: Vec::new(),
            cull: None,
            k_average: None,
            importance: Importance::default(),
            thickness: Thickness::default(),
            beta: 1.0,
            approximation: Approximation::default(),
            table: TableOptions::default(),
            sort: Sort::default(),
            wanted: Wanted::default(),
            max_memory: 8 << 30,
        }
    }
}

/// How the frame from the light is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Shadows {
    /// The map's edge in pixels, 1 to [`MAX_SIZE`]; `None` is the image's longer edge.
    pub size: Option<u32>,
    /// How much nearer to the light a surface must be to cast a shadow, in world units, 0 or more; `None` is twice the
    /// width of the map's pixels.
    pub bias: Option<f64>,
}

/// The executor of a pass's invocations.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Exec {
    /// Tiles in parallel; each owns its pixels' memory.
    Tile,
    /// Rasterizer threads feed worker threads that contend on shared atomics.
    Threads,
    /// One thread steps resident invocations, one memory operation at a time.
    Sim(Sim),
}

impl Exec {
    /// The name on the command line.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Tile => "tile",
            Self::Threads => "threads",
            Self::Sim(_) => "sim",
        }
    }
}

/// How the simulated device schedules.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Sim {
    /// Which invocation goes next.
    pub policy: Policy,
    /// Seed of `Policy::Random` and `Policy::Pct`.
    pub seed: u64,
    /// Invocations in flight, 1 to [`MAX_RESIDENT`].
    pub resident: usize,
    /// Record the schedule and return it.
    pub record: bool,
    /// A pixel, column and row from the top left, whose fragments and steps are reported.
    pub watch: Option<[u32; 2]>,
    /// Check memory after every step of the store pass against the method's invariants, if it states any.
    pub check: bool,
}

impl Default for Sim {
    fn default() -> Self {
        Self {
            policy: Policy::Random,
            seed: 0,
            resident: 4_096,
            record: false,
            watch: None,
            check: false,
        }
    }
}

/// The most worker threads.
pub const MAX_THREADS: usize = 1_024;

/// The most resident invocations.
pub const MAX_RESIDENT: usize = 1 << 20;

impl Options {
    /// The words that the method stores of a fragment: those requested, or its own.
    #[must_use]
    pub fn record(&self) -> Record {
        self.method.contract().record(self.depth_format, self.data)
    }

    /// The same options for the oracle, in the words that this method stores: the k nearest fragments of every pixel,
    /// or all.
    #[must_use]
    pub fn exact(&self, k: Option<u32>) -> Self {
        let Record { depth, data } = self.record();
        let depth_format = Some(depth);
        Self {
            method: Method::EXACT,
            k,
            exec: Exec::Tile,
            depth_format,
            data,
            memory_budget: None,
            inputs: Vec::new(),
            cull: None,
            k_average: None,
            ..self.clone()
        }
    }

    /// Check every value against its range, and k against the method.
    ///
    /// # Errors
    /// The first that is out of range, by the name of its option.
    pub fn check(&self) -> Result<()> {
        let contract = self.method.contract();
        let wrong = |option: &str, problem: String| Err(Error::new(option, problem));
        match self.k {
            Some(0) => return wrong("-k", "is 0, but a pixel keeps at least 1 fragment".into()),
            Some(k) if k > contract.max_k => {
                let (name, most) = (contract.name, contract.max_k);
                return wrong("-k", format!("is {k}, but {name} keeps at most {most} fragments"));
            }
            _ => {}
        }
        if let (Some(bytes), Some(_)) = (self.memory_budget, self.k)
            && contract.budget_chooses_k()
        {
            let problem =
                format!("{bytes} bytes, and -k: the budget chooses k, so give one of them");
            return wrong("--memory-budget", problem);
        }
        self.check_records()?;
        self.check_merging()?;
        self.check_approximation()?;
        culling::check(self)?;
        if ![16, 32, 64].contains(&self.tile) {
            return wrong("--tile", format!("is {}, but must be 16, 32 or 64 pixels", self.tile));
        }
        if ![4, 8].contains(&self.sub_pixel_bits) {
            let bits = self.sub_pixel_bits;
            return wrong("--sub-pixel-bits", format!("is {bits}, but must be 8 or 4"));
        }
        self.table.check()?;
        if let (Some(bytes), true) = (self.memory_budget, contract.crosses()) {
            let sized = if self.table.load.is_some() { Some("--load") } else { None };
            if let Some(other) = sized.or(self.table.size.map(|_| "--table")) {
                let problem = format!("{bytes} bytes, and {other}: both size the table, give one");
                return wrong("--memory-budget", problem);
            }
        }
        let format = self.record().depth;
        if format.bits() > contract.depth_bits {
            let (name, bits) = (contract.name, contract.depth_bits);
            let problem = format!("is {}, but {name}'s records hold {bits} bits", format.name());
            return wrong("--depth-format", problem);
        }
        if self.threads > MAX_THREADS {
            let n = self.threads;
            return wrong("--threads", format!("is {n}, but at most {MAX_THREADS} are possible"));
        }
        if let Exec::Sim(Sim { policy: Policy::Pct(0), .. }) = &self.exec {
            return wrong("--schedule", "is pct:0, but the depth is at least 1".to_owned());
        }
        if let Exec::Sim(sim) = &self.exec
            && !(1..=MAX_RESIDENT).contains(&sim.resident)
        {
            let n = sim.resident;
            return wrong("--resident", format!("is {n}, but must be 1 to {MAX_RESIDENT}"));
        }
        self.check_effect()?;
        self.check_shadows()
    }

    /// What divides records among pixels.
    fn check_records(&self) -> Result<()> {
        let wrong = |option: &str, problem: String| Err(Error::new(option, problem));
        if let Some(average) = self.k_average {
            let most = f64::from(u32::MAX);
            if !(0.0..=most).contains(&average) {
                return wrong("--k-average", format!("is {average}, but must be 0 to {most}"));
            }
            if self.memory_budget.is_some() {
                let problem =
                    format!("is {average}, and --memory-budget: both give the records, give one");
                return wrong("--k-average", problem);
            }
        }
        self.importance.check()
    }

    fn check_merging(&self) -> Result<()> {
        if !self.thickness.is_valid() {
            let problem = format!("is {}, but must be 0 or more, and finite", self.thickness);
            return Err(Error::new("--thickness", problem));
        }
        if !(0.0..=1.0).contains(&self.beta) {
            let problem = format!("is {}, but must be 0 (optical) to 1 (smooth)", self.beta);
            return Err(Error::new("--beta", problem));
        }
        Ok(())
    }

    fn check_approximation(&self) -> Result<()> {
        let Approximation { moments, samples, .. } = self.approximation;
        if ![4, 6, 8].contains(&moments) {
            return Err(Error::new("--moments", format!("is {moments}, but must be 4, 6 or 8")));
        }
        if !(1..=MOST_SAMPLES).contains(&samples) {
            let problem = format!("is {samples}, but must be 1 to {MOST_SAMPLES}");
            return Err(Error::new("--samples", problem));
        }
        Ok(())
    }

    /// Whether something is made of the lists.
    pub(super) fn needs_lists(&self, scene: &Scene) -> bool {
        self.effect != Effect::Transparency || !scene.volumes.is_empty() || self.needs_light()
    }

    /// Whether the light of pixels must be computed before it is encoded.
    pub(super) fn needs_light(&self) -> bool {
        self.linear || self.transparent
    }

    /// What merging must know of the run.
    pub(super) fn merging(&self) -> Merging {
        let relative = matches!(self.thickness, Thickness::Precision(_));
        Merging { beta: self.beta, relative }
    }

    fn check_effect(&self) -> Result<()> {
        let name = self.effect.name();
        let (method, stores) = (self.method.name(), self.method.contract().data);
        let holds = self.method.holds();
        let layered = holds == HeldKind::Records && self.effect.takes_layers();
        if holds != HeldKind::Fragments && self.effect != Effect::Transparency && !layered {
            return Err(no_lists(method, holds, &format!("--effect {name}")));
        }
        if holds != HeldKind::Fragments && self.shadows.is_some() {
            return Err(no_lists(method, holds, "--shadows"));
        }
        if self.effect.needs_primitives() && stores.is_some_and(|data| data != Data::Primitive) {
            let problem =
                format!("{name} must know a fragment's object, but {method} stores no triangle");
            return Err(Error::new("--effect", problem));
        }
        if self.shadows.is_some() && stores == Some(Data::Nothing) {
            let problem = format!("need colours, but {method} stores depths alone");
            return Err(Error::new("--shadows", problem));
        }
        if self.effect.needs_primitives() && self.data != Data::Primitive {
            let problem =
                format!("color: {name} must know a fragment's object, so it needs primitive");
            return Err(Error::new("--data", problem));
        }
        if self.effect.needs_solids() && self.cull_face != CullFace::None {
            let problem = format!("{name} needs front and back faces, so it must be none");
            return Err(Error::new("--cull-face", problem));
        }
        Ok(())
    }

    fn check_shadows(&self) -> Result<()> {
        let Some(Shadows { size, bias }) = self.shadows else { return Ok(()) };
        if let Some(size) = size.filter(|size| !(1..=MAX_SIZE).contains(size)) {
            let problem = format!("is {size}, but must be 1 to {MAX_SIZE} pixels");
            return Err(Error::new("--shadow-size", problem));
        }
        if let Some(bias) = bias.filter(|bias| !(bias.is_finite() && *bias >= 0.0)) {
            let problem = format!("is {bias}, but must be 0 or more world units, and finite");
            return Err(Error::new("--shadow-bias", problem));
        }
        match &self.exec {
            Exec::Sim(Sim { record: true, .. }) => {
                Err(Error::new("--record", "a schedule covers one frame, but --shadows draws two"))
            }
            Exec::Sim(Sim { policy: Policy::Recorded(_), .. }) => {
                Err(Error::new("--schedule", "covers one frame, but --shadows draws two"))
            }
            _ => Ok(()),
        }
    }

    /// Worker threads, at least 1.
    #[must_use]
    pub fn worker_threads(&self) -> usize {
        match self.threads {
            0 => std::thread::available_parallelism().map_or(1, usize::from),
            n => n,
        }
    }
}
