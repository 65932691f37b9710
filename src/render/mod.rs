//! One frame from beginning to end: a scene and options in; an image, the kept fragments and a report out.

mod budget;
mod effects;
mod frames;
mod hash;
mod limits;
mod options;
mod report;
mod shadows;

use crate::effect::ldi::Voxels;
use crate::effect::{Made, Stage};
use crate::error::{Error, Result};
use crate::exec::clock::Stopwatch;
use crate::exec::sim::{Simulated, policy, schedule};
use crate::exec::{self, Frame, Job, Tally};
use crate::image::Image;
use crate::memory::{Counters, Layout, Observer};
use crate::num::color::word16;
use crate::raster::{Attenuation, FrontEnd, Grid, Record};
use crate::resolve::hash::fragments_hash;
use crate::scene::Scene;
use crate::scheme::catalogue::{self, Visitor};
use crate::scheme::contract::{Contract, Demand, Keeps};
use crate::scheme::{Config, Scheme};

pub use crate::effect::Effect;
pub use crate::exec::sim::Checked;
pub use crate::exec::sim::Watched;
pub use crate::fragment::Data;
pub use crate::raster::CullFace;
pub use crate::resolve::Lists;
pub use crate::scheme::hash::Offsets;
pub use budget::{Budget, storage_bytes};
pub use frames::{AnimatedFrame, Animation, MAX_FRAMES, Resize, animate};
pub use hash::{HashOptions, TableReport};
pub use options::{Exec, MAX_RESIDENT, MAX_THREADS, Options, Policy, Shadows, Sim, Sort};
pub use report::{Report, ShadowReport};

/// Everything one frame gives.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture.
    pub image: Image,
    /// The kept fragments after resolve.
    pub lists: Lists,
    /// With [`Effect::Csg`], those of them that are surfaces of the combination.
    pub surfaces: Option<Lists>,
    /// With [`Effect::Ldi`], what is solid, if it was asked for.
    pub voxels: Option<Voxels>,
    /// Accounting, counters, hashes, times.
    pub report: Report,
    /// The recorded schedule, if asked for.
    pub schedule: Option<Vec<u8>>,
    /// What happened at the watched pixel, if one was watched on the simulated device.
    pub watched: Option<Watched>,
}

/// What simulated memory holds before the clear pass: a scheme must not rely on zeroes.
const GARBAGE: u64 = 0xDEAD_BEEF_5EED_F00D;

/// Draw `scene`.
///
/// # Errors
/// An unknown method, an option out of range, more memory than `options.max_memory`, a recorded schedule that does
/// not fit, or an effect that does not fit the scene.
///
/// # Examples
/// ```
/// use fragloom::render::{Options, render};
/// use fragloom::scene::{self, Overrides};
///
/// let scene = scene::load("layers:count=4", &Overrides { size: Some([32, 32]), ..Overrides::default() })?;
/// let drawn = render(&scene, &Options { method: "ab-ll".to_owned(), ..Options::default() })?;
/// assert_eq!(drawn.report.generated, 4 * 32 * 32);
/// assert_eq!(drawn.lists.pixel(5, 5).len(), 4);
/// # Ok::<(), fragloom::error::Error>(())
/// ```
pub fn render(scene: &Scene, options: &Options) -> Result<Rendering> {
    let contract = catalogue::contract(&options.method)?;
    options.check(contract)?;
    let threads = options.worker_threads();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::new("--threads", format!("cannot start {threads}: {e}")))?;
    pool.install(|| draw(scene, options, contract, threads))
}

fn draw(
    scene: &Scene,
    options: &Options,
    contract: &'static Contract,
    threads: usize,
) -> Result<Rendering> {
    options.effect.check(scene)?;
    let mut watch = Stopwatch::start();
    let shadow = shadows::draw(scene, options, contract, threads)?;
    let attenuation = shadow.map.map(|map| Box::new(map) as Box<dyn Attenuation>);
    if attenuation.is_some() {
        watch.lap("shadows");
    }
    let grid = Grid { width: scene.size[0], height: scene.size[1], tile: options.tile };
    let (bits, cull) = (options.sub_pixel_bits, options.cull_face);
    let front = FrontEnd::attenuated(scene, grid, bits, cull, attenuation);
    watch.lap("setup");
    let (mut config, before_tile) = configure(&front, contract, options.k.or(contract.default_k));
    let mut chosen = None;
    if let Some(bytes) = options.memory_budget {
        let (within, budget) = budget::Scene::new(&front, contract).within(bytes, options.k)?;
        (config, chosen) = (within, Some(budget));
    }
    config.grid = grid;
    if contract.crosses {
        config.hash = options.hash.settings(config.generated, scene.size)?;
    }
    let k = config.k;
    watch.lap("count");
    let job = Job {
        front: &front,
        record: record(options, contract),
        sort: options.sort,
        background: scene.background.map(word16),
        nearest: contract.reference_k(k),
        contract,
        before_tile,
        whole_pools: chosen.is_none(),
        threads,
        opaque: options.hash.opaque(),
    };
    limits::kept(options, &job)?;
    limits::voxels(options, &grid)?;
    let run = Run { job: &job, config, options, fingerprint: fingerprint(&front, options) };
    let mut executed = catalogue::visit(contract.name, run)??;
    watch.lap("draw");
    let (lists, composited) = executed.frame.assemble(&grid);
    watch.lap("assemble");
    let stage = Stage { scene, front: &front, format: job.record.depth, lists: &lists };
    let mut report = account(scene, options, &front, &executed);
    let Made { image, surfaces, voxels, .. } = effects::make(&options.effect, &stage, &mut report)?;
    let image = image.unwrap_or(composited);
    if options.effect != Effect::Transparency {
        watch.lap("effect");
    }
    shadow.outcome.into_iter().for_each(|outcome| outcome.add_to(&mut report));
    report.budget = chosen;
    report.k = match contract.keeps {
        Keeps::One => Some(1),
        _ => k,
    };
    report.threads = threads;
    report.image_hash = image.hash();
    report.fragments_hash = fragments_hash(lists.width, lists.height, &lists.offsets, &lists.keys);
    watch.lap("hash");
    report.seconds = watch.seconds();
    let passes = std::mem::take(&mut executed.frame.seconds).into_iter();
    report.seconds.extend(passes.map(|(pass, seconds)| (format!("draw.{pass}"), seconds)));
    let Executed { schedule, watched, .. } = executed;
    Ok(Rendering { image, lists, surfaces, voxels, report, schedule, watched })
}

/// What the method must know of the scene, measured only if it must; and the fragments before each tile, and in all.
fn configure(front: &FrontEnd, contract: &Contract, k: Option<u32>) -> (Config, Vec<u64>) {
    let pixels = front.grid.storage_pixels() as u32;
    let mut config = Config { k, pixels, ..Config::default() };
    let mut before_tile = Vec::new();
    match contract.demand {
        Demand::Generated => {
            before_tile = front.count_fragments();
            for count in &mut before_tile {
                let before = config.generated;
                config.generated += *count;
                *count = before;
            }
            before_tile.push(config.generated);
        }
        Demand::MaxDepthComplexity if k.is_none() || contract.keeps == Keeps::Nearest => {
            config.max_depth_complexity = front.max_depth_complexity();
        }
        Demand::Bounded => config = budget::Scene::new(front, contract).config(k),
        _ => {}
    }
    (config, before_tile)
}

fn record(options: &Options, contract: &Contract) -> Record {
    Record {
        depth: options.depth_format.or(contract.depth_format).unwrap_or_default(),
        data: contract.data.unwrap_or(options.data),
    }
}

/// Everything that an interleaving and its result depend on, so that a schedule is not run on something else: the
/// options, and every primitive with its surface. Computed only where a schedule is recorded or followed.
fn fingerprint(front: &FrontEnd, options: &Options) -> u64 {
    let Exec::Sim(sim) = &options.exec else { return 0 };
    if !sim.record && !matches!(sim.policy, Policy::Recorded(_)) {
        return 0;
    }
    let Options { method, k, memory_budget, depth_format, data, hash, .. } = options;
    let size = (front.grid.width, front.grid.height);
    let head =
        format!("{size:?} {method} {k:?} {memory_budget:?} {depth_format:?} {data:?} {hash:?}");
    let primitives = front.primitives().iter().map(|p| format!("{p:?} {:?}", front.surface(p)));
    schedule::fingerprint(std::iter::once(head).chain(primitives))
}

/// Runs one method, once its type is known.
struct Run<'a> {
    job: &'a Job<'a>,
    config: Config,
    options: &'a Options,
    fingerprint: u64,
}

/// What an executor gave.
struct Executed {
    contract: &'static Contract,
    frame: Frame,
    bytes: u64,
    exec: &'static str,
    schedule: Option<Vec<u8>>,
    watched: Option<Watched>,
    checked: Option<Checked>,
}

impl Visitor for Run<'_> {
    type Output = Result<Executed>;

    fn scheme<S: Scheme>(self) -> Result<Executed> {
        if self.options.counters { self.run::<S, Counters>() } else { self.run::<S, ()>() }
    }

    /// Counted in any case; what was not asked for is left out.
    fn fault<S: Scheme>(self) -> Result<Executed> {
        let counters = self.options.counters;
        let mut executed = self.run::<S, Counters>()?;
        if !counters {
            executed.frame.counters = Counters::default();
        }
        Ok(executed)
    }

    fn exact(self) -> Result<Executed> {
        let frame = exec::oracle::run(self.job, self.config.k);
        let bytes = 8 * frame.tally.generated;
        let (schedule, watched, checked) = (None, None, None);
        let contract = self.job.contract;
        Ok(Executed { contract, frame, bytes, exec: "sequential", schedule, watched, checked })
    }
}

impl Run<'_> {
    fn run<S: Scheme, O: Observer + Default + Send>(&self) -> Result<Executed> {
        let mut layout = Layout::default();
        let scheme = S::new(&self.config, &mut layout);
        limits::storage(self.options, self.job, &layout)?;
        let (grid, exec) = (&self.job.front.grid, self.options.exec.name());
        let bytes = layout.bytes(u64::from(grid.width) * u64::from(grid.height));
        let mut executed = Executed {
            contract: self.job.contract,
            frame: Frame::default(),
            bytes,
            exec,
            schedule: None,
            watched: None,
            checked: None,
        };
        executed.frame = match &self.options.exec {
            Exec::Tile => exec::tile::run::<O>(&scheme, &layout, self.job),
            Exec::Threads => exec::threads::run::<O>(&scheme, &layout, self.job),
            Exec::Sim(sim) => {
                let run = self.simulate::<S, O>(&scheme, &layout, sim)?;
                (executed.schedule, executed.watched) = (run.schedule, run.watched);
                executed.checked = run.checked;
                run.frame
            }
        };
        Ok(executed)
    }

    fn simulate<S: Scheme, O: Observer + Default + Send>(
        &self,
        scheme: &S,
        layout: &Layout,
        sim: &Sim,
    ) -> Result<Simulated> {
        let Sim { policy, seed, resident, record, watch, check } = sim.clone();
        let (fingerprint, grid) = (self.fingerprint, &self.job.front.grid);
        let inside = watch.filter(|&[x, y]| x < grid.width && y < grid.height);
        let watch = inside.map(|[x, y]| grid.pixel(x, y));
        let settings =
            policy::Settings { policy, seed, resident, record, fingerprint, watch, check };
        exec::sim::run::<S, O>(scheme, layout, self.job, &settings, GARBAGE)
    }
}

/// The report, but for what is known only after assembly.
fn account(scene: &Scene, options: &Options, front: &FrontEnd, executed: &Executed) -> Report {
    let (tally, contract) = (&executed.frame.tally, executed.contract);
    let table = executed.frame.table.as_ref().map(TableReport::new);
    // Beyond the largest age: where no cell is empty, for want of room, whatever the largest age.
    let full = table.as_ref().is_some_and(TableReport::is_full);
    let dropped = [
        (if full { "full" } else { "age" }, tally.age),
        ("duplicate", tally.duplicate),
        ("lost", tally.lost),
        ("overflow", tally.overflow),
        ("pool", tally.pool),
    ];
    Report {
        method: contract.name.to_owned(),
        scene: scene.name.clone(),
        exec: executed.exec.to_owned(),
        width: front.grid.width,
        height: front.grid.height,
        triangles: front.triangles,
        degenerate: front.degenerate,
        generated: tally.generated,
        duplicated: tally.duplicated,
        torn: tally.torn,
        kept: tally.kept,
        culled: tally.culled,
        evicted: tally.evicted,
        dropped: dropped.iter().filter(|d| d.1 > 0).map(|d| (d.0.to_owned(), d.1)).collect(),
        deterministic: deterministic(contract, tally),
        max_depth_complexity: tally.max_depth_complexity,
        bytes: executed.bytes,
        passes: contract.program.geometry(),
        rounds: executed.frame.rounds,
        counters: executed.frame.counters.by_name(),
        table,
        checked: executed.checked.as_ref().map(|checked| checked.steps),
        warnings: [scene.warnings.clone(), hash::idle(options, contract).into_iter().collect()]
            .concat(),
        violations: violations(contract, tally, executed.checked.as_ref()),
        ..Report::default()
    }
}

/// The fields that no schedule can change: what the rasterizer decides, and, as far as the contract goes, the result.
fn deterministic(contract: &Contract, tally: &Tally) -> Vec<String> {
    let mut names = vec!["triangles", "degenerate", "generated", "max_depth_complexity"];
    names.extend(["bytes", "passes"]);
    let open = contract.racy || contract.keeps == Keeps::Visible;
    if !open {
        names.extend(["duplicated", "torn", "merged"]);
        // Who takes a page that others would have filled depends on the order.
        let settled = !contract.crosses || contract.settled_overflow;
        if tally.dropped() == 0 || (contract.page == 1 && settled) {
            names.push("kept");
        }
        // Two that are alike and find no room may be told apart on the way, or not.
        if tally.dropped() == 0 || (contract.page == 1 && (!contract.crosses || tally.age == 0)) {
            names.push("dropped");
        }
    }
    // What finds no room depends on arrival, whatever the contract says of the rest.
    let unsettled = if contract.settled_overflow { 0 } else { tally.age };
    if !open && tally.overflow + tally.pool + unsettled == 0 {
        names.extend(["image_hash", "fragments_hash"]);
    }
    names.into_iter().map(str::to_owned).collect()
}

/// What the method promised and did not keep.
fn violations(contract: &Contract, tally: &Tally, checked: Option<&Checked>) -> Vec<String> {
    let mut found = Vec::new();
    if let Some((checked, first)) = checked.and_then(|c| Some((c, c.first.as_ref()?))) {
        found.push(format!("after {} of {} steps: {first}", checked.violations, checked.steps));
    }
    // Who keeps one of every depth loses the others, and says so; so does a published form that loses some.
    let loses = matches!(contract.keeps, Keeps::Layers | Keeps::Some);
    let lost = if loses { 0 } else { tally.lost };
    let compared = contract.judged || contract.crosses;
    if compared && !contract.racy && lost + tally.duplicated + tally.torn > 0 {
        found.push(format!(
            "{lost} fragments lost, {} duplicated, {} torn",
            tally.duplicated, tally.torn
        ));
    }
    if !compared && !contract.racy && tally.unbalanced > 0 {
        found.push(format!(
            "{} pixels do not balance: {} fragments lost, {} duplicated, {} torn",
            tally.unbalanced, tally.lost, tally.duplicated, tally.torn
        ));
    }
    if !tally.balances() {
        found.push(format!("the accounting does not balance: {tally:?}"));
    }
    found
}
