//! From the given options to what is run: values are checked and defaults filled in.

use super::flags::{CullFace, Data, DepthFormat, Drawing, Exec, Offsets, Shading, Sort};
use super::{importance, values};
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::num::depth::Format;
use crate::render::{self, Options, Policy, Sim, TableOptions, Wanted};
use crate::scene::{self, Overrides, PointSize, Thickness};

/// Invocations in flight unless `--resident` is given.
const RESIDENT: usize = 4_096;

/// A run, ready except for the scene.
#[derive(Clone, Debug)]
pub(in crate::cli) struct Settings {
    /// What the command line changes in the scene.
    pub(in crate::cli) overrides: Overrides,
    /// The options for drawing.
    pub(in crate::cli) options: Options,
    /// Options that were given and have no effect.
    pub(in crate::cli) warnings: Vec<String>,
}

/// Check and complete the given options for a method of the catalogue. `record`: the schedule is to be recorded.
///
/// # Errors
/// The option that is wrong, and what would be right.
pub(in crate::cli) fn complete(typed: &Drawing, method: Method, record: bool) -> Result<Settings> {
    if typed.k == Some(0) {
        return Err(Error::new("-k", "0 fragments per pixel: must be at least 1"));
    }
    one_of("--tile", typed.tile, &[16, 32, 64])?;
    one_of("--sub-pixel-bits", typed.sub_pixel_bits, &[8, 4])?;
    let options = Options {
        method,
        k: typed.k,
        exec: exec(typed, record)?,
        threads: typed.threads,
        tile: typed.tile,
        sub_pixel_bits: typed.sub_pixel_bits,
        depth_format: typed.depth_format.map(Format::from),
        data: typed.data.map(render::Data::from).unwrap_or_default(),
        cull_face: typed.cull_face.into(),
        effect: render::Effect::default(),
        linear: false,
        transparent: false,
        volumes: render::Marching::default(),
        shadows: None,
        counters: true,
        memory_budget: typed
            .memory_budget
            .as_deref()
            .map(|text| values::bytes("--memory-budget", text))
            .transpose()?,
        inputs: Vec::new(),
        cull: typed.cull.as_deref().map(importance::culling).transpose()?,
        k_average: typed.importance.k_average,
        importance: typed.importance.complete()?,
        thickness: thickness(typed.thickness.as_deref())?,
        beta: typed.beta,
        approximation: typed.approximation.complete(),
        table: table(typed)?,
        sort: typed.sort.into(),
        // `fragloom render` says otherwise where less is wanted.
        wanted: Wanted::Lists,
        max_memory: values::bytes("--max-memory", &typed.max_memory)?,
    };
    Ok(Settings { overrides: overrides(typed)?, options, warnings: idle(typed) })
}

/// `--thickness`, or its default.
pub(in crate::cli) fn thickness(typed: Option<&str>) -> Result<Thickness> {
    let wrong = |problem| Error::new("--thickness", problem);
    typed.map_or(Ok(Thickness::default()), |text| Thickness::parse(text).map_err(wrong))
}

fn table(typed: &Drawing) -> Result<TableOptions> {
    let size = typed.table.as_deref().map(|text| values::cells("--table", text)).transpose()?;
    Ok(TableOptions {
        load: typed.load,
        size,
        offsets: typed.offsets.into(),
        seed: typed.offset_seed,
        ages: typed.age_limit,
        threshold: typed.cull_threshold,
    })
}

fn overrides(typed: &Drawing) -> Result<Overrides> {
    if let Some(alpha) = typed.alpha.filter(|alpha| !(0.0..=1.0).contains(alpha)) {
        return Err(Error::new("--alpha", format!("{alpha} must be an opacity from 0 to 1")));
    }
    let size = typed.size.as_deref().map(values::size).transpose()?;
    let points = PointSize { radius: typed.point_radius, scale: typed.point_scale };
    let shading = typed.shading.map(scene::Shading::from);
    let (viewpoint, format) = (typed.scene.viewpoint()?, typed.scene.format());
    Ok(Overrides { size, alpha: typed.alpha, shading, points, viewpoint, format })
}

fn exec(typed: &Drawing, record: bool) -> Result<render::Exec> {
    let needs_sim = |option| Err(Error::new(option, "needs --exec sim"));
    match typed.exec {
        Exec::Sim => Ok(render::Exec::Sim(sim(typed, record)?)),
        _ if typed.schedule.is_some() => needs_sim("--schedule"),
        _ if record => needs_sim("--record"),
        _ if typed.check_steps => needs_sim("--check-steps"),
        Exec::Tile => Ok(render::Exec::Tile),
        Exec::Threads => Ok(render::Exec::Threads),
    }
}

fn sim(typed: &Drawing, record: bool) -> Result<Sim> {
    let resident = typed.resident.unwrap_or(RESIDENT);
    if resident == 0 {
        return Err(Error::new("--resident", "0 invocations in flight: must be at least 1"));
    }
    let policy = typed.schedule.as_deref().map_or(Ok(Policy::Random), Policy::parse)?;
    let (seed, check) = (typed.seed.unwrap_or(0), typed.check_steps);
    Ok(Sim { policy, seed, resident, record, watch: None, check })
}

/// Options without effect are not errors: scripts pass them to every run.
fn idle(typed: &Drawing) -> Vec<String> {
    let simulated = typed.exec == Exec::Sim;
    let random = typed.schedule.as_deref().is_none_or(|p| p == "random" || p.starts_with("pct:"));
    let mut warnings = Vec::new();
    if typed.seed.is_some() && !(simulated && random) {
        warnings
            .push("--seed has no effect without --exec sim --schedule random or pct:D".to_owned());
    }
    if typed.resident.is_some() && !simulated {
        warnings.push("--resident has no effect without --exec sim".to_owned());
    }
    warnings
}

fn one_of(option: &str, value: u32, right: &[u32]) -> Result<()> {
    if right.contains(&value) {
        return Ok(());
    }
    let right: Vec<String> = right.iter().map(ToString::to_string).collect();
    Err(Error::new(option, format!("{value} must be one of {}", right.join(", "))))
}

impl From<Shading> for scene::Shading {
    fn from(typed: Shading) -> Self {
        match typed {
            Shading::Flat => Self::Flat,
            Shading::Lambert => Self::Lambert,
            Shading::Gooch => Self::Gooch,
        }
    }
}

impl From<DepthFormat> for Format {
    fn from(typed: DepthFormat) -> Self {
        match typed {
            DepthFormat::D32 => Self::D32,
            DepthFormat::D24 => Self::D24,
            DepthFormat::F32 => Self::F32,
        }
    }
}

impl From<Sort> for render::Sort {
    fn from(typed: Sort) -> Self {
        match typed {
            Sort::Fastest => Self::Fastest,
            Sort::Published => Self::Published,
        }
    }
}

impl From<Offsets> for render::Offsets {
    fn from(typed: Offsets) -> Self {
        match typed {
            Offsets::Random => Self::Random,
            Offsets::FarthestPoint => Self::FarthestPoint,
        }
    }
}

impl From<Data> for render::Data {
    fn from(typed: Data) -> Self {
        match typed {
            Data::Color => Self::Color,
            Data::Primitive => Self::Primitive,
            Data::None => Self::Nothing,
        }
    }
}

impl From<CullFace> for render::CullFace {
    fn from(typed: CullFace) -> Self {
        match typed {
            CullFace::None => Self::None,
            CullFace::Front => Self::Front,
            CullFace::Back => Self::Back,
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        drawing: Drawing,
    }

    fn settings(line: &str) -> Result<Settings> {
        let words = std::iter::once("test").chain(line.split_whitespace());
        complete(
            &Line::try_parse_from(words).unwrap().drawing,
            Method::EXACT,
            line.contains("warp"),
        )
    }

    #[test]
    fn defaults() {
        let settings = settings("").unwrap();
        let options = settings.options;
        assert_eq!((options.method.name(), options.k, options.threads), ("exact", None, 0));
        assert_eq!((options.exec, options.tile), (render::Exec::Tile, 64));
        assert_eq!((options.sub_pixel_bits, options.depth_format), (8, None));
        assert_eq!((options.data, options.cull_face), Default::default());
        assert_eq!((options.counters, options.max_memory), (true, 8 << 30));
        assert_eq!(settings.overrides.size, None);
        assert!(settings.warnings.is_empty());
    }

    #[test]
    fn a_simulated_device() {
        let found = settings("--exec sim --schedule warp:8 --resident 9").unwrap().options.exec;
        let expected = Sim {
            policy: Policy::Warp(8),
            seed: 0,
            resident: 9,
            record: true,
            watch: None,
            check: false,
        };
        assert_eq!(found, render::Exec::Sim(expected));
        let found = settings("--exec sim --seed 7").unwrap().options.exec;
        let expected = Sim {
            policy: Policy::Random,
            seed: 7,
            resident: RESIDENT,
            record: false,
            watch: None,
            check: false,
        };
        assert_eq!(found, render::Exec::Sim(expected));
    }

    #[test]
    fn wrong_values_name_their_option() {
        for (line, place) in [
            ("-k 0", "-k"),
            ("--size 0x1", "--size"),
            ("--alpha 1.5", "--alpha"),
            ("--alpha NaN", "--alpha"),
            ("--alpha -0.1", "--alpha"),
            ("--tile 8", "--tile"),
            ("--sub-pixel-bits 5", "--sub-pixel-bits"),
            ("--max-memory 0", "--max-memory"),
            ("--thickness -1", "--thickness"),
            ("--thickness NaNx", "--thickness"),
            ("--schedule random", "--schedule"),
            ("--exec sim --resident 0", "--resident"),
            ("--exec sim --schedule fifo", "--schedule"),
        ] {
            assert_eq!(settings(line).unwrap_err().place(), place, "{line}");
        }
    }

    #[test]
    fn options_without_effect_are_warned_of() {
        assert_eq!(settings("--seed 1").unwrap().warnings.len(), 1);
        assert_eq!(settings("--resident 1 --exec threads").unwrap().warnings.len(), 1);
        assert_eq!(settings("--seed 1 --exec sim --schedule order").unwrap().warnings.len(), 1);
        assert!(settings("--seed 1 --exec sim --schedule random").unwrap().warnings.is_empty());
    }
}
