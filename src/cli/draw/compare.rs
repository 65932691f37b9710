//! `fragloom compare`: several methods against the exact reference.
//!
//! A method that keeps k fragments must give the same lists as the reference with the same k. The table also shows how
//! far its picture is from the one with all fragments, which is the cost of k. All methods and the reference store
//! depths in one format: the coarsest that any of them fixes. With a memory budget, a second table has the columns of
//! Table 2 of the importance paper.

mod row;

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::{Path, PathBuf};

use self::row::Compared;
use crate::catalogue::Catalogue;
use crate::cli::Verdict;
use crate::cli::options::flags::{Drawing, Output};
use crate::cli::options::settings::complete;
use crate::cli::terminal::{say, wait};
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::image::{Image, difference, heat, png, sheet, similarity};
use crate::num::depth::Format;
use crate::render::{Data, Exec, Options, Rendering, keeps_nearest, render};
use crate::report::{files, json};
use crate::scene::{self, Scene};
use crate::scheme::kplus_buffer::k_variable::ONE;
use crate::scheme::{Form, Keeps};

#[derive(Debug, clap::Args)]
pub(in crate::cli) struct Args {
    /// A mesh (.obj, .gltf, .glb, .ply), a scene file (.toml) or a built-in scene (see `fragloom scenes`)
    #[arg(value_name = "SCENE")]
    scene: String,

    /// Methods to compare, separated by commas [default: all in their correct form]
    #[arg(short, long = "method", value_name = "METHOD,...", value_delimiter = ',')]
    methods: Vec<String>,

    /// The method that is right by definition
    #[arg(long, value_name = "METHOD", default_value = "exact")]
    reference: String,

    /// A folder that exists, for one picture per method, compare-METHOD.png: exact, method, differences; and for a method
    /// with k by importance, importance-METHOD.png and k-METHOD.png [default: not written]
    #[arg(short = 'o', value_name = "DIR")]
    folder: Option<PathBuf>,

    #[command(flatten)]
    drawing: Drawing,

    #[command(flatten)]
    output: Output,
}

/// Draw everything, write the sheets, and print a row per method.
///
/// # Errors
/// Wrong options or scene, or a file that cannot be written.
pub(in crate::cli) fn run(catalogue: &Catalogue, args: &Args) -> Result<Verdict> {
    let methods = args.drawing.approximation.with_tail(methods(catalogue, args)?)?;
    let reference = catalogue.find("--reference", &args.reference)?;
    let mut settings = complete(&args.drawing, reference, false)?;
    settings.options.counters = false;
    if settings.options.depth_format.is_none() {
        let all = methods.iter().chain([&reference]);
        let fixed = all.map(|method| method.contract().depth_format);
        settings.options.depth_format = Some(common_format(fixed));
    }
    if let Some(folder) = &args.folder {
        files::check_folder("-o", folder)?;
    }
    let quiet = args.output.quiet;
    let scene = wait::during(quiet, "loading", || scene::load(&args.scene, &settings.overrides))?;
    let warnings = [settings.warnings, scene.warnings.clone()].concat();
    warnings.iter().for_each(|warning| say::warning(warning));
    let options = settings.options;
    let mut session = Session { scene, options, warnings, quiet, references: BTreeMap::new() };
    let rows = methods.iter().map(|&method| session.compare(method, args.folder.as_deref()));
    let rows: Vec<Compared> = rows.collect::<Result<_>>()?;
    let text = if args.output.json { json::document(&rows)? } else { row::table(&rows) };
    say::result(&text)?;
    rows.iter().for_each(|row| complain(row, &session.warnings));
    Ok(if rows.iter().all(Compared::agrees) { Verdict::Clean } else { Verdict::Found })
}

/// Report what concerns this method alone.
fn complain(row: &Compared, known: &[String]) {
    for warning in row.warnings.iter().filter(|warning| !known.contains(warning)) {
        say::warning(&format!("{}: {warning}", row.method));
    }
    for violation in &row.violations {
        say::violation(&format!("{}: {violation}", row.method));
    }
}

/// The given methods, or all correct ones but the reference.
fn methods(catalogue: &Catalogue, args: &Args) -> Result<Vec<Method>> {
    if !args.methods.is_empty() {
        return args.methods.iter().map(|name| catalogue.find("-m", name)).collect();
    }
    let shows = |m: &Method| m.contract().keeps != Keeps::Bound && m.name() != args.reference;
    let wanted = |m: &Method| m.contract().form == Form::Correct && shows(m);
    Ok(catalogue.methods().iter().copied().filter(wanted).collect())
}

/// The coarsest format that any of them fixes.
pub(super) fn common_format(fixed: impl Iterator<Item = Option<Format>>) -> Format {
    let fixed = fixed.flatten();
    let coarseness = |format: &Format| Format::ALL.iter().position(|known| known == format);
    fixed.max_by_key(coarseness).unwrap_or_default()
}

/// One scene, and the reference's frames as they are needed.
struct Session {
    scene: Scene,
    /// `method` is the reference.
    options: Options,
    /// Warnings for all rows.
    warnings: Vec<String>,
    quiet: bool,
    /// By the reference's k (`None` is all fragments) and data word.
    references: BTreeMap<(Option<u32>, Data), Rendering>,
}

impl Session {
    fn compare(&mut self, method: Method, folder: Option<&Path>) -> Result<Compared> {
        let contract = method.contract();
        // What keeps more than the nearest fragments is drawn without culling.
        let cull = self.options.cull.filter(|_| keeps_nearest(contract));
        let options = Options { method, cull, ..self.options.clone() };
        let drawn = self.draw(&options)?;
        let k = self.held_to(method, drawn.report.k);
        let data = options.record().data;
        self.prepare(None, data)?;
        self.prepare(k, data)?;
        let (all, same) = (&self.references[&(None, data)], &self.references[&(k, data)]);
        let mut row = Compared::new(method, self.options.method.name(), k, &drawn);
        row.warnings.retain(|warning| !self.warnings.contains(warning));
        row.warnings.splice(..0, self.warnings.iter().cloned());
        row.lists_equal = match (drawn.kept.fragments(), same.kept.fragments()) {
            // The run itself has judged, fragment by fragment, what may be missing.
            _ if contract.keeps == Keeps::Visible => drawn.report.violations.is_empty(),
            (Some(own), Some(all)) if let Some(shares) = &drawn.shares => {
                *own == all.cut(|pixel, keys| keys.truncate(shares.k[pixel] as usize))
            }
            (Some(own), Some(same)) if contract.keeps_alike() => own == same,
            (Some(own), Some(same)) => *own == same.cut(|_, keys| keys.dedup()),
            // Without lists, only the pictures can be compared.
            _ => true,
        };
        row.may_look_different = matches!(contract.keeps, Keeps::Visible | Keeps::NearestChosen)
            || drawn.kept.fragments().is_none()
            || drawn.report.dropped.contains_key("duplicate");
        row.from_reference = difference::measure(&same.image, &drawn.image)?;
        row.from_all = difference::measure(&all.image, &drawn.image)?;
        row.psnr = similarity::psnr(&all.image, &drawn.image)?;
        row.ssim = similarity::ssim(&all.image, &drawn.image)?;
        if let Some(folder) = folder {
            let path = folder.join(format!("compare-{method}.png"));
            let picture = sheet::compose(&row.labels(&self.scene.name), &all.image, &drawn.image)?;
            write(&path, &picture)?;
            for (name, picture) in shares(&row, &drawn) {
                write(&folder.join(format!("{name}-{method}.png")), &picture)?;
            }
        }
        Ok(row)
    }

    /// The reference's k for a method that ran with `k`, which a memory budget may have chosen; the reference itself
    /// uses the k that was given.
    fn held_to(&self, method: Method, k: Option<u32>) -> Option<u32> {
        if method == self.options.method {
            self.options.k
        } else {
            method.contract().reference_k(k)
        }
    }

    /// Draw the reference with `k`, unless that is done. It uses tiles, since its answer does not depend on the
    /// executor. A budget applies only to the methods.
    fn prepare(&mut self, k: Option<u32>, data: Data) -> Result<()> {
        let exec = Exec::Tile;
        let (memory_budget, cull) = (None, None);
        let options = Options { k, exec, data, memory_budget, cull, ..self.options.clone() };
        if self.references.contains_key(&(k, data)) {
            return Ok(());
        }
        let drawn = self.draw(&options)?;
        if let Entry::Vacant(place) = self.references.entry((k, data)) {
            place.insert(drawn);
        }
        Ok(())
    }

    fn draw(&self, options: &Options) -> Result<Rendering> {
        let message = format!("drawing {} with {}", self.scene.name, options.method);
        wait::during(self.quiet, &message, || render(&self.scene, options))
    }
}

fn write(path: &Path, picture: &Image) -> Result<()> {
    let bytes = png::encode(picture)
        .map_err(|error| Error::new(path.display().to_string(), error.to_string()))?;
    files::write_bytes(path, &bytes)
}

/// Importance and k of every pixel as maps, where a method divides its records by importance.
fn shares(row: &Compared, drawn: &Rendering) -> Vec<(&'static str, Image)> {
    let Some(shares) = &drawn.shares else { return Vec::new() };
    let map = |name: &str, meaning: &str, values: Vec<f64>, most: f64| {
        let title = format!("{} \u{b7} {} \u{b7} {name}", row.method, row.scene);
        let (size, most) = ([row.width, row.height], if most > 0.0 { most } else { 1.0 });
        heat::Map { title: &title, meaning, size, values: &values, most }.draw()
    };
    let one = f64::from(ONE);
    let importance = shares.importance.iter().map(|&q| f64::from(q) / one).collect();
    let k: Vec<f64> = shares.k.iter().map(|&k| f64::from(k)).collect();
    let most = k.iter().copied().fold(0.0, f64::max);
    vec![
        (
            "importance",
            map("importance", "importance, 0 to 1 (noise may exceed 1)", importance, 1.0),
        ),
        ("k", map("k", "records of a pixel", k, most)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_coarsest_fixed_format_wins() {
        let [free, f32, d24] = [None, Some(Format::F32), Some(Format::D24)];
        let common = |fixed: [Option<Format>; 3]| common_format(fixed.into_iter());
        assert_eq!(common([free, free, free]), Format::D32);
        assert_eq!(common([free, f32, free]), Format::F32);
        assert_eq!(common([d24, f32, free]), Format::D24);
        assert_eq!(common([free, free, d24]), Format::D24);
    }
}
