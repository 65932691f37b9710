//! One scene that several methods draw, and the reference's frames that they are compared with.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use super::Heat;
use super::row::Compared;
use crate::cli::terminal::wait;
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::image::metrics::Metrics;
use crate::image::{Image, difference, flip, heat, png, sheet};
use crate::render::{Data, Exec, Options, Rendering, keeps_nearest, render};
use crate::report::files;
use crate::scene::Scene;
use crate::scheme::Keeps;
use crate::scheme::kplus_buffer::k_variable::ONE;

/// One scene, and the reference's frames as they are needed.
pub(super) struct Session {
    pub(super) scene: Scene,
    /// `method` is the reference.
    pub(super) options: Options,
    /// Warnings for all rows.
    pub(super) warnings: Vec<String>,
    threshold: u8,
    quiet: bool,
    /// By the reference's k (`None` is all fragments) and data word.
    references: BTreeMap<(Option<u32>, Data), Rendering>,
    /// Errors against the reference with all fragments, by its data word and a picture's hash: pictures are often equal.
    measured: BTreeMap<(Data, String), Metrics>,
}

impl Session {
    pub(super) fn new(
        scene: Scene,
        options: Options,
        warnings: Vec<String>,
        threshold: u8,
        quiet: bool,
    ) -> Self {
        let (references, measured) = Default::default();
        Self { scene, options, warnings, threshold, quiet, references, measured }
    }

    /// Draw with a method, and compare. Pictures go to a folder, if there is one.
    ///
    /// # Errors
    /// What the method refuses, or a file that cannot be written.
    pub(super) fn compare(
        &mut self,
        method: Method,
        pictures: Option<(&Path, Option<Heat>)>,
    ) -> Result<Compared> {
        let contract = method.contract();
        let options = culled(Options { method, ..self.options.clone() });
        let drawn = self.draw(&options, "")?;
        let k = self.held_to(method, drawn.report.k);
        let data = options.record().data;
        let metrics = self.measure(&drawn, data)?;
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
        row.from_reference = difference::measure(&same.image, &drawn.image, self.threshold)?;
        row.from_all = difference::measure(&all.image, &drawn.image, self.threshold)?;
        row.metrics = metrics;
        if let Some((folder, heat)) = pictures {
            let path = folder.join(format!("compare-{method}.png"));
            let picture = sheet::compose(&row.labels(&self.scene.name), &all.image, &drawn.image)?;
            write(&path, &picture)?;
            for (name, picture) in shares(&row, &drawn) {
                write(&folder.join(format!("{name}-{method}.png")), &picture)?;
            }
            if let Some(heat) = heat {
                let picture = heat_map(heat, &row, &all.image, &drawn.image)?;
                write(&folder.join(format!("heat-{method}.png")), &picture)?;
            }
        }
        Ok(row)
    }

    /// The errors of a picture against the reference with all fragments.
    ///
    /// # Errors
    /// What the reference refuses.
    pub(super) fn measure(&mut self, drawn: &Rendering, data: Data) -> Result<Metrics> {
        self.prepare(None, data)?;
        let key = (data, drawn.report.image_hash.clone());
        if let Some(known) = self.measured.get(&key) {
            return Ok(*known);
        }
        let all = &self.references[&(None, data)].image;
        let measure = || Metrics::measure(all, &drawn.image, self.threshold);
        let metrics = wait::during(self.quiet, "measuring errors", measure)?;
        self.measured.insert(key, metrics);
        Ok(metrics)
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
        let drawn = self.draw(&options, "")?;
        if let Entry::Vacant(place) = self.references.entry((k, data)) {
            place.insert(drawn);
        }
        Ok(())
    }

    /// Draw; `progress` stands behind the message on the terminal.
    ///
    /// # Errors
    /// What the method refuses.
    pub(super) fn draw(&self, options: &Options, progress: &str) -> Result<Rendering> {
        let message = format!("drawing {} with {}{progress}", self.scene.name, options.method);
        wait::during(self.quiet, &message, || render(&self.scene, options))
    }
}

/// What keeps more than the nearest fragments is drawn without culling.
pub(super) fn culled(options: Options) -> Options {
    let cull = options.cull.filter(|_| keeps_nearest(options.method.contract()));
    Options { cull, ..options }
}

pub(super) fn write(path: &Path, picture: &Image) -> Result<()> {
    let bytes = png::encode(picture)
        .map_err(|error| Error::new(path.display().to_string(), error.to_string()))?;
    files::write_bytes(path, &bytes)
}

/// A method's errors as a map, on the whole scale.
fn heat_map(heat: Heat, row: &Compared, exact: &Image, drawn: &Image) -> Result<Image> {
    let (name, meaning, values, most) = match heat {
        Heat::Flip => {
            ("FLIP", "FLIP, 0 (equal) to 1, always on this scale", flip::map(exact, drawn)?, 1.0)
        }
        Heat::Difference => (
            "difference",
            "largest difference of R, G, B and A, of 255",
            difference::map(exact, drawn)?.into_iter().map(f64::from).collect(),
            255.0,
        ),
    };
    let title = format!("{} \u{b7} {} \u{b7} {name}", row.method, row.scene);
    let size = [row.width, row.height];
    Ok(heat::Map { title: &title, meaning, size, values: &values, most }.draw())
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
