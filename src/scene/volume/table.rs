//! `[[volume]]` of a scene file.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DMat4, DVec3};
use serde::Deserialize;

use super::format::{Element, npy, nrrd};
use super::{Grid, Interpolation, MAX_STEPS, Transfer, Volume, procedural};
use crate::error::{Error, Result};
use crate::scene::model::Unplaced;
use crate::scene::placement::Placement;

/// A volume as written.
#[derive(Clone, Debug, Deserialize)]
pub(in crate::scene) struct VolumeTable {
    file: Option<String>,
    procedural: Option<String>,
    translate: Option<[f64; 3]>,
    rotate: Option<[f64; 4]>,
    scale: Option<f64>,
    extent: Option<[f64; 3]>,
    density: Option<f64>,
    transfer: Option<TransferValue>,
    step: Option<f64>,
    step_unit: Option<f64>,
    #[serde(default)]
    interpolation: Interpolation,
    range: Option<[f64; 2]>,
    /// Of a `.raw` file.
    size: Option<[u64; 3]>,
    #[serde(rename = "type")]
    element: Option<String>,
    /// The rule's own; a file has none.
    #[serde(flatten)]
    keys: BTreeMap<String, toml::Value>,
}

/// A name, or points.
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum TransferValue {
    Name(String),
    Points(Vec<[f64; 5]>),
}

/// The kinds of files.
enum Kind {
    Npy,
    Nrrd,
    Raw,
}

impl VolumeTable {
    fn placement(&self) -> Placement {
        let Self { translate, rotate, scale, .. } = *self;
        Placement { translate, rotate, scale }
    }

    /// All checks that do not need the file.
    pub(in crate::scene) fn check(&self) -> Unplaced<()> {
        self.placement().transform()?;
        self.transfer()?;
        for (name, value) in [("step", self.step), ("step_unit", self.step_unit)] {
            if let Some(value) = value.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(format!("{name}: {value} must be above 0 world units, and finite"));
            }
        }
        if let Some(density) = self.density.filter(|d| !(d.is_finite() && *d >= 0.0)) {
            return Err(format!("density: {density} must be 0 or more, and finite"));
        }
        if let Some(extent) = self.extent.filter(|e| !e.iter().all(|e| e.is_finite() && *e > 0.0)) {
            return Err(format!("extent: {extent:?} must be above 0 world units, and finite"));
        }
        if let Some([low, high]) =
            self.range.filter(|[low, high]| !(low < high && (high - low).is_finite()))
        {
            return Err(format!("range: {low} must be below {high}, both finite"));
        }
        match (&self.file, &self.procedural) {
            (Some(file), None) => self.check_file(file),
            (None, Some(name)) => {
                procedural::find(name).map_err(|error| format!("procedural: {error}"))?;
                self.raw_keys("a volume made by rule")
            }
            _ => Err("file: needs either file or procedural".to_owned()),
        }
    }

    fn check_file(&self, file: &str) -> Unplaced<()> {
        if let Some(key) = self.keys.keys().next() {
            return Err(format!("{key}: is not a key of a volume with a file"));
        }
        match kind(file)? {
            Kind::Raw => {
                self.size.ok_or("size: a .raw file needs it, [x, y, z] in voxels")?;
                let element = self.element.as_deref();
                Element::named(element.ok_or("type: a .raw file needs it, like \"u8\"")?).map(drop)
            }
            Kind::Npy | Kind::Nrrd => self.raw_keys("a file with a header"),
        }
    }

    /// What only a `.raw` file has.
    fn raw_keys(&self, what: &str) -> Unplaced<()> {
        let given = [("size", self.size.is_some()), ("type", self.element.is_some())];
        match given.iter().find(|(_, given)| *given) {
            Some((name, _)) => Err(format!("{name}: is not a key of {what}")),
            None => Ok(()),
        }
    }

    fn transfer(&self) -> Unplaced<Transfer> {
        match &self.transfer {
            None => Transfer::named("grey"),
            Some(TransferValue::Name(name)) => Transfer::named(name),
            Some(TransferValue::Points(points)) => Transfer::new(points),
        }
    }

    /// The volume, with the files that `read` gives.
    ///
    /// # Errors
    /// `read`'s, and what is wrong with the file.
    pub(in crate::scene) fn build(
        &self,
        read: &mut dyn FnMut(&str) -> Result<Vec<u8>>,
    ) -> Result<Volume> {
        let grid = self.grid(read)?;
        self.placed(grid).map_err(|problem| {
            let name = self.file.as_ref().or(self.procedural.as_ref());
            Error::new(name.map_or("volume", String::as_str), problem)
        })
    }

    fn grid(&self, read: &mut dyn FnMut(&str) -> Result<Vec<u8>>) -> Result<Grid> {
        let Some(file) = &self.file else {
            return procedural::generate(
                self.procedural.as_deref().unwrap_or_default(),
                &self.keys,
            );
        };
        let wrong = |problem: String| Error::new(file, problem);
        match kind(file).map_err(wrong)? {
            Kind::Npy => npy::parse(&read(file)?, file),
            Kind::Nrrd => {
                let bytes = read(file)?;
                nrrd::parse(&bytes, file, &mut |name| read(&sibling(file, name)))
            }
            Kind::Raw => {
                let size = self.size.unwrap_or_default();
                let element = Element::named(self.element.as_deref().unwrap_or_default());
                let element = element.map_err(wrong)?;
                let values = element.decode(&read(file)?, size, false).map_err(wrong)?;
                Grid::new(size.map(|n| n as usize), values).map_err(wrong)
            }
        }
    }

    fn placed(&self, grid: Grid) -> Unplaced<Volume> {
        let grid = match self.range {
            Some(range) => grid.ranged(range)?,
            None => grid,
        };
        let extent = DVec3::from(self.extent.unwrap_or_else(|| grid.extent()));
        let scale = self.scale.unwrap_or(1.0).abs();
        let edges = (0..3).map(|i| extent[i] * scale / grid.size()[i] as f64);
        let step = self.step.unwrap_or_else(|| edges.fold(f64::INFINITY, f64::min) * 0.5);
        let centred = DMat4::from_translation(extent * -0.5) * DMat4::from_scale(extent);
        let place = self.placement().transform()? * centred;
        if !(place.is_finite() && place.inverse().is_finite()) {
            return Err("extent: the box is too large or too small for 64-bit numbers".to_owned());
        }
        let steps = extent.length() * scale / step;
        if steps.is_nan() || steps > MAX_STEPS {
            return Err(format!(
                "step: {step:?} makes more than {MAX_STEPS} steps through the box"
            ));
        }
        let (transfer, interpolation) = (self.transfer()?, self.interpolation);
        let (density, step_unit) = (self.density.unwrap_or(1.0), self.step_unit.unwrap_or(1.0));
        let grid = Arc::new(grid);
        Ok(Volume { grid, place, transfer, density, step_unit, step, interpolation })
    }
}

fn kind(file: &str) -> Unplaced<Kind> {
    let lower = file.to_ascii_lowercase();
    match lower.rsplit_once('.').map(|(_, extension)| extension) {
        Some("npy") => Ok(Kind::Npy),
        Some("nrrd" | "nhdr") => Ok(Kind::Nrrd),
        Some("raw") => Ok(Kind::Raw),
        _ => Err(format!("file: {file:?} must end in .npy, .nrrd, .nhdr or .raw")),
    }
}

/// The name of a file named in another file.
fn sibling(file: &str, name: &str) -> String {
    let folder = std::path::Path::new(file).parent();
    folder.map_or_else(|| name.to_owned(), |folder| folder.join(name).display().to_string())
}
