//! One frame from beginning to end: a scene and options in; an image, the kept fragments and a report out.

mod budget;
mod configure;
mod culling;
mod effects;
mod frames;
mod importance;
mod inputs;
mod limits;
mod options;
mod reference;
mod report;
mod shadows;
mod table;

use crate::effect::Made;
use crate::effect::layers::Layers;
use crate::effect::ldi::Voxels;
use crate::error::{Error, Result};
use crate::exec::clock::Stopwatch;
use crate::exec::sim::{Simulated, policy, schedule};
use crate::exec::{self, Frame, Instance, Job, Kit, Tally};
use crate::image::Image;
use crate::image::linear::Linear;
use crate::memory::Counters;
use crate::num::color::word16;
use crate::raster::{Attenuation, FrontEnd, Grid};
use crate::resolve::digest::kept_hash;
use crate::scene::Scene;
use crate::scheme::HeldKind;
use crate::scheme::contract::{Contract, Demand, Keeps};
use crate::scheme::course::Course;

pub use crate::effect::Effect;
pub use crate::effect::screen::{Screen, focus::Focus, occlusion::Occlusion};
pub use crate::effect::volume::Marching;
pub use crate::exec::sim::Checked;
pub use crate::exec::sim::Watched;
pub use crate::fragment::Data;
pub use crate::raster::CullFace;
pub use crate::resolve::{Kept, Lists};
pub use crate::scheme::hash_table::table::Offsets;
use configure::{HeldTo, configure, held_to, third_word};

pub use budget::{Budget, storage_bytes};
pub use culling::{CullingReport, DEFAULT_WORDS, keeps_nearest};
pub use frames::{AnimatedFrame, Animation, MAX_FRAMES, Resize, animate};
pub use importance::{
    Factors, Importance, ImportanceMap, ImportanceReport, Reach, Shares, fresnel,
};
pub use inputs::Given;
pub use options::{Exec, MAX_RESIDENT, MAX_THREADS, Options, Policy, Shadows, Sim, Sort, Wanted};
pub use reference::{Promises, Reference, promised, promising, reference};
pub use report::{Report, ShadowReport};
pub use table::{TableOptions, TableReport};

/// The result of one frame.
#[derive(Clone, Debug)]
pub struct Rendering {
    /// The picture.
    pub image: Image,
    /// The same in 16 bits of linear light, if asked for, or if the picture is transparent.
    pub linear: Option<Linear>,
    /// What the pixels hold after resolve.
    pub kept: Kept,
    /// With [`Effect::Csg`], those fragments that are surfaces of the combination.
    pub surfaces: Option<Lists>,
    /// With [`Effect::Ldi`], what is solid, if requested.
    pub voxels: Option<Voxels>,
    /// How records were divided, where a method divides them by importance.
    pub shares: Option<Shares>,
    /// Accounting, counters, hashes, times.
    pub report: Report,
    /// The recorded schedule, if asked for.
    pub schedule: Option<Vec<u8>>,
    /// What happened at the watched pixel, if one was watched on the simulated device.
    pub watched: Option<Watched>,
}

impl Rendering {
    /// The kept fragments.
    ///
    /// # Errors
    /// The method gives no lists of fragments.
    pub fn lists(&self) -> Result<&Lists> {
        self.kept
            .fragments()
            .ok_or_else(|| no_lists(&self.report.method, self.kept.kind(), "--fragments"))
    }
}

/// The error for something that needs lists of fragments, which a method does not give.
fn no_lists(method: &str, holds: HeldKind, place: &str) -> Error {
    let problem = format!("needs lists of fragments, but {method} gives {}", holds.name());
    Error::new(place, problem)
}

/// What simulated memory holds before the clear pass: a scheme must not rely on zeroes.
const GARBAGE: u64 = 0xDEAD_BEEF_5EED_F00D;

/// Draw `scene`.
///
/// # Errors
/// An option out of range, an input that does not fit, more memory than `options.max_memory`, a recorded schedule that
/// does not fit, or an effect that does not fit the scene.
///
/// # Examples
/// ```
/// use fragloom::render::{Options, render};
/// use fragloom::scene::{self, Overrides};
///
/// let scene = scene::load("layers:count=4", &Overrides { size: Some([32, 32]), ..Overrides::default() })?;
/// let drawn = render(&scene, &Options { method: fragloom::catalogue::method("ab-ll")?, ..Options::default() })?;
/// assert_eq!(drawn.report.generated, 4 * 32 * 32);
/// assert_eq!(drawn.lists()?.pixel(5, 5).len(), 4);
/// # Ok::<(), fragloom::error::Error>(())
/// ```
pub fn render(scene: &Scene, options: &Options) -> Result<Rendering> {
    render_with(scene, options, &Kit::default())
}

/// As [`render()`], with what earlier frames have left in `kit`: the same bytes, sooner, as long as the method reads
/// nothing that its clear pass has not written ([`crate::memory::reuse`]).
///
/// # Errors
/// As [`render()`].
pub fn render_with(scene: &Scene, options: &Options, kit: &Kit) -> Result<Rendering> {
    options.check()?;
    let threads = options.worker_threads();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::new("--threads", format!("cannot start {threads}: {e}")))?;
    pool.install(|| draw(scene, options, threads, kit))
}

fn draw(scene: &Scene, options: &Options, threads: usize, kit: &Kit) -> Result<Rendering> {
    let (method, contract) = (options.method, options.method.contract());
    effects::check(options, scene)?;
    let mut watch = Stopwatch::start();
    let shadow = shadows::draw(scene, options, threads)?;
    let attenuation = shadow.map.map(|map| Box::new(map) as Box<dyn Attenuation>);
    if attenuation.is_some() {
        watch.lap("shadows");
    }
    let grid = Grid { width: scene.size[0], height: scene.size[1], tile: options.tile };
    let (bits, cull) = (options.sub_pixel_bits, options.cull_face);
    let front = FrontEnd::attenuated(scene, grid, bits, cull, attenuation, &kit.front);
    let front = third_word(front, scene, options);
    watch.lap("setup");
    let (config, before_tile, chosen) =
        configure(&front, options, options.k.or(contract.default_k))?;
    let k = config.k;
    let instance = method.instance(&config);
    let HeldTo { inputs, nearest, counts } =
        held_to(instance.as_deref(), scene, options, &front, k)?;
    watch.lap("count");
    let culled = culling::draw(options, &front, &nearest, threads)?;
    let (bounds, culling) = culled.map(|c| (c.bounds, c.report)).unzip();
    if culling.is_some() {
        watch.lap("culling");
    }
    let wanted = if options.needs_lists(scene) { Wanted::Lists } else { options.wanted };
    let job = Job {
        front: &front,
        record: options.record(),
        sort: options.sort,
        background: scene.background.map(word16),
        nearest,
        contract,
        course: Course::of(&contract.program),
        holds: method.holds(),
        inputs,
        before_tile,
        whole_pools: chosen.is_none(),
        threads,
        opaque: options.table.opaque(),
        culling: bounds.unwrap_or_default(),
        // The accounting compares no merged records, but fragments of methods that may lose some.
        picture_only: wanted == Wanted::Picture
            && match method.holds() {
                HeldKind::Fragments => !contract.is_racy() && !contract.is_judged(),
                HeldKind::Records => true,
                HeldKind::Color | HeldKind::Depth => false,
            },
        kit,
    };
    limits::kept(options, &job, wanted)?;
    limits::voxels(options, &grid)?;
    let mut executed = execute(instance.as_deref(), &job, k, options)?;
    watch.lap("draw");
    if executed.frame.settle(&job) {
        watch.lap("judge");
    }
    let (kept, composited) = match wanted {
        Wanted::Hash | Wanted::Picture if job.holds.is_list() => {
            (Kept::Gone(job.holds), executed.frame.picture(&grid))
        }
        _ => executed.frame.assemble(&grid),
    };
    if wanted == Wanted::Lists {
        kit.keep(std::mem::take(&mut executed.frame.tiles));
    }
    watch.lap("assemble");
    let table = executed.frame.table.take().map(|left| TableReport::new(&kit.read(left)));
    let mut report = account(scene, options, &front, &executed, table);
    let (format, data) = (job.record.depth, job.record.data);
    limits::layers(options, &kept)?;
    let layers = Layers { scene, front: &front, format, data, kept: &kept };
    let Made { image, surfaces, voxels, .. } =
        effects::make(options, &layers, &composited, &mut report)?;
    let linear =
        options.needs_light().then(|| effects::linear::picture(&layers, options.transparent));
    let image = match &linear {
        Some(linear) if options.transparent => linear.srgb8(),
        _ => image.unwrap_or(composited),
    };
    if options.effect != Effect::Transparency || !scene.volumes.is_empty() {
        watch.lap("effect");
    }
    shadow.outcome.into_iter().for_each(|outcome| outcome.add_to(&mut report));
    report.budget = chosen;
    report.k = match contract.keeps {
        Keeps::One => Some(1),
        Keeps::NearestChosen => None,
        _ => k,
    };
    let shares = counts.map(|counts| {
        let (shares, divided) = Shares::of(options, &job, config.records, &counts);
        divided.add_to(&mut report, options, &shares);
        shares
    });
    if let Some(culling) = culling {
        culling.add_to(&mut report, &executed.frame.tally, options, &job.nearest);
    }
    // The simulated device is one thread.
    report.threads = if matches!(options.exec, Exec::Sim(_)) { 1 } else { threads };
    report.nan_pixels = kept.nan_pixels();
    if report.generated == 0 && scene.volumes.is_empty() {
        report.warnings.push(nothing_in_view(scene));
    }
    report.image_hash = image.hash();
    report.fragments_hash = match wanted {
        Wanted::Hash if job.holds.is_list() => executed.frame.lists_hash(&grid),
        _ => kept_hash(&kept),
    };
    kit.keep(std::mem::take(&mut executed.frame.tiles));
    watch.lap("hash");
    report.seconds = watch.seconds();
    front.leave(&kit.front);
    let passes = std::mem::take(&mut executed.frame.seconds).into_iter();
    report.seconds.extend(passes.map(|(pass, seconds)| (format!("draw.{pass}"), seconds)));
    let Executed { schedule, watched, .. } = executed;
    Ok(Rendering { image, linear, kept, surfaces, voxels, shares, report, schedule, watched })
}

/// Where the scene lies, and where the camera looks.
fn nothing_in_view(scene: &Scene) -> String {
    let point = |p: glam::DVec3| format!("({:.4}, {:.4}, {:.4})", p.x, p.y, p.z);
    let bounds = scene.bounds();
    let camera = &scene.camera;
    let lies = match bounds.min.is_finite() && bounds.max.is_finite() {
        true => format!("it lies from {} to {}", point(bounds.min), point(bounds.max)),
        false => "its triangles are given in pixels, or have no area".to_owned(),
    };
    format!(
        "nothing is in view: {lies}; the camera is at {} and looks to {}, from {} to {} ahead",
        point(camera.eye),
        point(camera.target),
        camera.near,
        camera.far
    )
}

/// Everything that an interleaving and its result depend on, so that a schedule is not replayed on something else: the
/// options, and every primitive with its surface. Computed only where a schedule is recorded or followed.
fn fingerprint(front: &FrontEnd, options: &Options) -> u64 {
    let Exec::Sim(sim) = &options.exec else { return 0 };
    if !sim.record && !matches!(sim.policy, Policy::Recorded(_)) {
        return 0;
    }
    let Options { method, k, memory_budget, depth_format, data, table, .. } = options;
    let size = (front.grid.width, front.grid.height);
    // The name under which schedules were recorded.
    let table = format!("{table:?}").replacen("TableOptions", "HashOptions", 1);
    let mut head =
        format!("{size:?} {method} {k:?} {memory_budget:?} {depth_format:?} {data:?} {table}");
    if let Some(words) = options.cull {
        head += &format!(" cull {words}");
    }
    if method.contract().demand == Demand::Records {
        head += &format!(" {:?} {:?}", options.k_average, options.importance);
    }
    if method.contract().has_slabs() {
        head += &format!(" {} {:?}", options.beta, front.slabs());
    }
    if method.contract().keeps.is_approximate() {
        head += &format!(" {:?}", options.approximation);
    }
    let indices = front.indices().into_iter().zip(0..);
    let primitives = indices
        .map(|(i, place)| format!("{} {:?}", front.primitive(i).text(place), front.surface(i)));
    schedule::fingerprint(std::iter::once(head).chain(primitives))
}

/// The result of an executor.
struct Executed {
    frame: Frame,
    bytes: u64,
    exec: &'static str,
    schedule: Option<Vec<u8>>,
    watched: Option<Watched>,
    checked: Option<Checked>,
}

impl Executed {
    fn new(frame: Frame, bytes: u64, exec: &'static str) -> Self {
        Self { frame, bytes, exec, schedule: None, watched: None, checked: None }
    }
}

/// Run the method, which is the oracle if there is no instance of it.
fn execute(
    instance: Option<&dyn Instance>,
    job: &Job<'_>,
    k: Option<u32>,
    options: &Options,
) -> Result<Executed> {
    let Some(instance) = instance else {
        let frame = exec::oracle::run(job, k);
        let bytes = 8 * frame.tally.generated;
        return Ok(Executed::new(frame, bytes, "sequential"));
    };
    let layout = instance.layout();
    limits::storage(options, job, layout)?;
    let grid = &job.front.grid;
    let bytes = layout.bytes(u64::from(grid.width) * u64::from(grid.height));
    let executed = |frame| Executed::new(frame, bytes, options.exec.name());
    let counted = options.counters;
    match &options.exec {
        Exec::Tile => Ok(executed(exec::tile::run(instance, job, counted))),
        Exec::Threads => Ok(executed(exec::threads::run(instance, job, counted))),
        Exec::Sim(sim) => {
            let scheduling = scheduling(sim, job, fingerprint(job.front, options));
            let mut run = exec::sim::run(instance, job, &scheduling, GARBAGE)?;
            if !counted {
                run.frame.counters = Counters::default();
            }
            let Simulated { frame, schedule, watched, checked } = run;
            Ok(Executed { schedule, watched, checked, ..executed(frame) })
        }
    }
}

fn scheduling(sim: &Sim, job: &Job<'_>, fingerprint: u64) -> policy::Scheduling {
    let Sim { policy, seed, resident, record, watch, check } = sim.clone();
    let grid = &job.front.grid;
    let inside = watch.filter(|&[x, y]| x < grid.width && y < grid.height);
    let watch = inside.map(|[x, y]| grid.pixel(x, y));
    policy::Scheduling { policy, seed, resident, record, fingerprint, watch, check }
}

/// The report, except what is known only after assembly.
fn account(
    scene: &Scene,
    options: &Options,
    front: &FrontEnd,
    executed: &Executed,
    table: Option<TableReport>,
) -> Report {
    let (tally, contract) = (&executed.frame.tally, options.method.contract());
    // Beyond the largest age. If no cell is empty, the reason is lack of room, whatever the largest age.
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
        merged: tally.merged,
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
        warnings: [scene.warnings.clone(), table::idle(options, contract).into_iter().collect()]
            .concat(),
        violations: violations(contract, executed),
        ..Report::default()
    }
}

/// The fields that no schedule can change: what the rasterizer decides, and, as far as the contract goes, the result.
fn deterministic(contract: &Contract, tally: &Tally) -> Vec<String> {
    let mut names = vec!["triangles", "degenerate", "generated", "max_depth_complexity"];
    names.extend(["bytes", "passes"]);
    // A schedule is an order of arrival, unless an interlock restores that of submission.
    let by_arrival = contract.is_arrival_dependent() && !contract.is_interlocked();
    let blends = contract.keeps == Keeps::Merged || contract.keeps.is_approximate();
    let open = contract.is_racy() || contract.keeps == Keeps::Visible || (by_arrival && blends);
    if !open {
        names.extend(["duplicated", "torn", "merged"]);
        // Which invocation takes a page that others would have filled depends on the order.
        let settled = !contract.crosses() || contract.settles_overflow();
        if tally.dropped() == 0 || (contract.page == 1 && settled) {
            names.push("kept");
        }
        // Whether two equal fragments that find no room were told apart on the way depends on the order.
        if tally.dropped() == 0 || (contract.page == 1 && (!contract.crosses() || tally.age == 0)) {
            names.push("dropped");
        }
    }
    // Which fragments find no room depends on arrival, whatever the contract says of the rest.
    let unsettled = if contract.settles_overflow() { 0 } else { tally.age };
    if !open && tally.overflow + tally.pool + unsettled == 0 {
        names.extend(["image_hash", "fragments_hash"]);
    }
    names.into_iter().map(str::to_owned).collect()
}

/// What the method promised and did not keep.
fn violations(contract: &Contract, executed: &Executed) -> Vec<String> {
    let Executed { frame: Frame { tally, outside, .. }, checked, .. } = executed;
    let mut found = Vec::new();
    if *outside > 0 {
        found.push(format!("{outside} accesses outside of the method's words"));
    }
    if let Some((checked, first)) = checked.as_ref().and_then(|c| Some((c, c.first.as_ref()?))) {
        found.push(format!("after {} of {} steps: {first}", checked.violations, checked.steps));
    }
    // A method that keeps one fragment of every depth loses the others, and says so; so does a published form that
    // loses some.
    let loses = matches!(contract.keeps, Keeps::Layers | Keeps::Some);
    let lost = if loses { 0 } else { tally.lost };
    let compared = contract.is_judged() || contract.crosses();
    if compared && !contract.is_racy() && lost + tally.duplicated + tally.torn > 0 {
        found.push(format!(
            "{lost} fragments lost, {} duplicated, {} torn",
            tally.duplicated, tally.torn
        ));
    }
    if !compared && !contract.is_racy() && tally.unbalanced > 0 {
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
