//! What is to be timed: options, checked and completed.

use super::stats::timed;
use super::{Args, Scaling, Wanted};
use crate::catalogue::Catalogue;
use crate::cli::options::flags::Exec;
use crate::cli::options::importance::culling;
use crate::cli::options::{settings, values};
use crate::cli::terminal::wait;
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::render::{self, Data, MAX_THREADS, Options, Sim, TableOptions};
use crate::scene::procedural::{Key, Range};
use crate::scene::{self, Overrides, Scene, Shading, Thickness};

/// Scenes that are timed if none is named.
const SCENES: [&str; 3] = ["synthetic:n=16,density=80", "layers:count=8", "bottles"];

/// Methods that are timed if none is named; and by the suite.
const METHODS: [&str; 2] = ["ab-ll", "kplus-array"];
const SUITE_METHODS: [&str; 7] =
    ["z-buffer", "ab-ll", "kplus-array", "kplus-heap", "s-buffer", "dfb", "ha64"];

/// The size of `--quick`.
const QUICK: [u32; 2] = [256, 256];

/// The most fragments of the suite's scenes, in millions.
const MOST_MILLIONS: u32 = 300;

/// The most steps of a scaling: 2,048 times the first.
const MOST_STEPS: u32 = 12;

/// A scene, as it was named.
pub(super) struct Asked {
    pub(super) name: String,
    pub(super) scene: Scene,
    /// Seconds that its file or generator took.
    pub(super) load: f64,
}

/// Everything that was asked for.
pub(super) struct Plan {
    /// The scenes' names; they are loaded by [`Plan::load`].
    pub(super) named: Vec<String>,
    pub(super) methods: Vec<Method>,
    pub(super) execs: Vec<render::Exec>,
    /// At least one; none is 0.
    pub(super) threads: Vec<usize>,
    pub(super) k: Option<u32>,
    /// Of hash tables, in per cent.
    pub(super) load: Option<u32>,
    pub(super) thickness: Thickness,
    /// Words of the culling passes.
    pub(super) cull: Option<u32>,
    pub(super) repeats: u32,
    pub(super) size: Option<[u32; 2]>,
    wanted: render::Wanted,
    max_memory: u64,
    pub(super) quiet: bool,
}

impl Plan {
    /// Check and complete what was typed.
    ///
    /// # Errors
    /// The option that is wrong, and what would be right.
    pub(super) fn new(catalogue: &Catalogue, args: &Args) -> Result<Self> {
        within("--repeats", args.repeats, 1, 1_000)?;
        within("--steps", args.steps, 2, MOST_STEPS)?;
        args.load.map_or(Ok(()), |load| within("--load", load, 1, 100))?;
        let quick = args.quick.then_some(QUICK);
        let size = args.size.as_deref().map(values::size).transpose()?.or(quick);
        let mut named = Vec::new();
        if let Some(millions) = args.suite {
            within("--suite", millions, 1, MOST_MILLIONS)?;
            named.extend(suite(millions, size.unwrap_or([1_024, 1_024])));
        }
        named.extend(args.scenes.iter().cloned());
        if named.is_empty() {
            let usual: &[&str] = match args.scaling {
                Some(Scaling::Fragments) => &["layers:count=10"],
                Some(Scaling::Triangles) => &["synthetic:n=1,density=100,area=8"],
                _ => &SCENES,
            };
            named.extend(usual.iter().map(|&name| name.to_owned()));
        }
        let usual: &[&str] = if args.suite.is_some() { &SUITE_METHODS } else { &METHODS };
        let methods = match args.methods.as_slice() {
            [] => usual.iter().map(|&name| name.to_owned()).collect(),
            typed => typed.to_vec(),
        };
        let execs = args.execs.iter().map(|&exec| executor(exec)).collect();
        Ok(Self {
            named,
            methods: catalogue.select("-m", &methods)?,
            execs,
            threads: threads(args)?,
            k: args.k,
            load: args.load,
            thickness: settings::thickness(args.thickness.as_deref())?,
            cull: args.cull.as_deref().map(culling).transpose()?,
            repeats: args.repeats,
            size,
            wanted: match args.wanted {
                Wanted::Lists => render::Wanted::Lists,
                Wanted::Hash => render::Wanted::Hash,
                Wanted::Picture => render::Wanted::Picture,
            },
            max_memory: values::bytes("--max-memory", &args.max_memory)?,
            quiet: args.output.quiet,
        })
    }

    /// Load a scene.
    ///
    /// # Errors
    /// It cannot be read.
    pub(super) fn load(&self, name: &str, size: Option<[u32; 2]>) -> Result<Asked> {
        // One colour per triangle: float shading is not timed, and devices do not do it.
        let shading = Some(Shading::Flat);
        let overrides = Overrides { size, shading, ..Overrides::default() };
        let (load, scene) = timed(|| scene::load(name, &overrides));
        Ok(Asked { name: name.to_owned(), scene: scene?, load })
    }

    /// Load all scenes, so that a mistake is said before anything is timed.
    ///
    /// # Errors
    /// The first that cannot be read.
    pub(super) fn scenes(&self) -> Result<Vec<Asked>> {
        let load = |name: &String| self.load(name, self.size);
        wait::during(self.quiet, "loading", || self.named.iter().map(load).collect())
    }

    /// The options of a run.
    pub(super) fn options(&self, method: Method, exec: &render::Exec, threads: usize) -> Options {
        Options {
            method,
            k: self.k,
            exec: exec.clone(),
            threads,
            thickness: self.thickness,
            table: TableOptions { load: self.load, ..TableOptions::default() },
            data: Data::Color,
            counters: false,
            wanted: self.wanted,
            max_memory: self.max_memory,
            ..Options::default()
        }
    }

    /// Executors, each with every number of threads. The simulated device is one thread.
    pub(super) fn executors(&self) -> Vec<(render::Exec, usize)> {
        let with = |exec: &render::Exec| {
            let simulated = matches!(exec, render::Exec::Sim(_));
            let threads = if simulated { vec![1] } else { self.threads.clone() };
            threads.into_iter().map(|n| (exec.clone(), n)).collect::<Vec<_>>()
        };
        self.execs.iter().flat_map(with).collect()
    }
}

fn within(option: &str, value: u32, least: u32, most: u32) -> Result<()> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(Error::new(option, format!("is {value}, but must be {least} to {most}")))
}

fn executor(exec: Exec) -> render::Exec {
    match exec {
        Exec::Tile => render::Exec::Tile,
        Exec::Threads => render::Exec::Threads,
        Exec::Sim => render::Exec::Sim(Sim::default()),
    }
}

/// Numbers of threads: those typed, or one per core; with `--scaling threads` all up to that.
pub(super) fn threads(args: &Args) -> Result<Vec<usize>> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    if let Some(most) = args.threads.iter().find(|&&n| n > MAX_THREADS) {
        let problem = format!("is {most}, but at most {MAX_THREADS} are possible");
        return Err(Error::new("--threads", problem));
    }
    let typed: Vec<usize> = args.threads.iter().map(|&n| if n == 0 { cores } else { n }).collect();
    Ok(match (typed.is_empty(), args.scaling) {
        (false, _) => typed,
        (true, Some(Scaling::Threads)) => (1..=cores).collect(),
        (true, _) => vec![cores],
    })
}

/// The suite's scenes, each of about so many million fragments at this size: triangles of 8 and of 128 pixels, whole
/// layers in each order, hair, a ball of hair, and points.
fn suite(millions: u32, [width, height]: [u32; 2]) -> Vec<String> {
    let pixels = f64::from(width) * f64::from(height);
    let fragments = f64::from(millions) * 1e6;
    let layers = libm::round(fragments / pixels).clamp(1.0, 4_096.0);
    // Of 8-pixel triangles there is room for as many as a scene may have.
    let small = layers.min(libm::floor(4_194_304.0 * 16.0 / pixels)).max(1.0);
    let megapixels = pixels / f64::from(1 << 20);
    let count =
        |each: f64, most: f64| libm::round(fragments / (each * megapixels)).clamp(1.0, most);
    vec![
        format!("synthetic:n={small},density=100,area=8"),
        format!("synthetic:n={layers},density=100,area=128"),
        format!("layers:count={layers}"),
        format!("layers:count={layers},order=front-to-back"),
        format!("layers:count={layers},order=back-to-front"),
        format!("beard:hairs={}", count(PER_HAIR, 200_000.0)),
        format!("hairball:strands={}", count(PER_STRAND, 100_000.0)),
        format!("surfels:count={}", count(PER_SURFEL, 100_000.0)),
    ]
}

/// Fragments of a hair, a strand and a disc at 1024x1024, as counted; they grow with the pixels.
const PER_HAIR: f64 = 320.0;
const PER_STRAND: f64 = 3_740.0;
const PER_SURFEL: f64 = 4_390.0;

/// A built-in scene with `factor` times as much of what its first count counts.
///
/// # Errors
/// It is no built-in scene, or has nothing to count.
pub(super) fn grown(name: &str, factor: u32) -> Result<String> {
    let (base, rest) = name.split_once(':').unwrap_or((name, ""));
    let builtin = scene::builtin().iter().find(|builtin| builtin.name == base);
    let Some(builtin) = builtin else {
        let problem = format!("{name} is no built-in scene, and only these can be made larger");
        return Err(Error::new("--scaling", problem));
    };
    let is_count = |key: &&Key| matches!(key.range, Range::Count(..));
    let Some(key) = builtin.keys.iter().find(is_count) else {
        let problem = format!("{base} has no key that counts what it is made of");
        return Err(Error::new("--scaling", problem));
    };
    let (mut parts, mut count) = (Vec::new(), key.default);
    for part in rest.split(',').filter(|part| !part.trim().is_empty()) {
        match part.split_once('=') {
            Some((name, value)) if name.trim() == key.name => count = value.trim(),
            _ => parts.push(part.to_owned()),
        }
    }
    let count: u32 = count
        .parse()
        .map_err(|_| Error::new(name, format!("{}: must be a whole number", key.name)))?;
    let count = u64::from(count) * u64::from(factor);
    parts.insert(0, format!("{}={count}", key.name));
    Ok(format!("{base}:{}", parts.join(",")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{CullFace, FrontEnd, Grid};

    #[test]
    fn scenes_grow_by_their_first_count() {
        let grow = |name: &str| grown(name, 4).map_err(|error| error.to_string());
        assert_eq!(grow("layers").unwrap(), "layers:count=64");
        let more = grow("layers:alpha=0.5,count=3,order=random").unwrap();
        assert_eq!(more, "layers:count=12,alpha=0.5,order=random");
        assert_eq!(grow("synthetic:n=2,area=8").unwrap(), "synthetic:n=8,area=8");
        assert_eq!(grow("hairball").unwrap(), "hairball:strands=4000");
        assert!(grow("ball.obj").unwrap_err().starts_with("--scaling: ball.obj is no built-in"));
        assert_eq!(
            grow("layers:count=x").unwrap_err(),
            "layers:count=x: count: must be a whole number"
        );
    }

    /// Every scene of the suite can be made, and those in pixels have the fragments that were asked for.
    #[test]
    fn the_suite_is_as_large_as_asked() {
        let at = |millions, size: [u32; 2]| suite(millions, size);
        let layers = format!("layers:count={}", 10_000_000 / (1_024 * 1_024) + 1);
        assert_eq!(at(10, [1_024, 1_024])[2], layers);
        assert_eq!(at(300, [1_024, 1_024])[2], "layers:count=286");
        assert_eq!(at(300, [1_024, 1_024])[0], "synthetic:n=64,density=100,area=8");
        assert_eq!(at(1, [16_384, 16_384])[4], "layers:count=1,order=back-to-front");
        // About: pictures of another shape show more or less of a scene.
        for name in at(1, [1_024, 1_024]) {
            let overrides = Overrides { size: Some([1_024, 1_024]), ..Overrides::default() };
            let scene = scene::load(&name, &overrides).expect(&name);
            let grid = Grid { width: 1_024, height: 1_024, tile: 64 };
            let front = FrontEnd::new(&scene, grid, 8, CullFace::None);
            let fragments: u64 = front.count_fragments().iter().sum();
            assert!((800_000..1_300_000).contains(&fragments), "{name}: {fragments}");
        }
    }
}
