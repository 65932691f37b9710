//! Scenes on devices, against the expected results.

use std::fmt;

use serde::{Deserialize, Serialize};

pub use super::backend::Path;
use super::backend::{Backend, Job};
use super::compare::{Differences, compare};
use super::split::split;
use crate::error::{self, Error};
use crate::exec::Method;
use crate::explore::{Expects, Prediction};
use crate::fragment::Data;
use crate::gpu::driver::device::AdapterName;
use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::twin::band::Band;
use crate::gpu::twin::bounds::Bounds;
use crate::gpu::twin::picture::Picture;
use crate::gpu::twin::source::{Twin, twin, twins};
use crate::raster::Record;
use crate::scene::Scene;
use crate::scheme::Config;
use crate::scheme::contract::{Contract, Keeps};

/// The result of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// No difference.
    Equal,
    /// Differences; the reason says whether they are allowed.
    Different,
    /// The device cannot run it.
    Unsupported,
    /// The device began, and failed.
    Failed,
    /// It did not come back in time.
    Hung,
    /// It is gone, or was given up before.
    #[serde(rename = "device lost")]
    Lost,
}

impl Status {
    /// All.
    pub const ALL: [Self; 6] =
        [Self::Equal, Self::Different, Self::Unsupported, Self::Failed, Self::Hung, Self::Lost];
}

impl fmt::Display for Status {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Equal => "equal",
            Self::Different => "different",
            Self::Unsupported => "unsupported",
            Self::Failed => "failed",
            Self::Hung => "hung",
            Self::Lost => "device lost",
        })
    }
}

/// One method on one device, over a whole scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Agreement {
    /// The adapter.
    pub adapter: String,
    /// Its driver.
    pub driver: String,
    /// The method.
    pub method: String,
    /// The scene.
    pub scene: String,
    /// How it was asked for: a file, or a built-in scene with its parameters.
    pub asked: String,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// How fragments reached the store pass.
    pub path: Path,
    /// Sub-pixel bits that vertices were snapped to.
    pub sub_pixel_bits: u32,
    /// The counts.
    #[serde(flatten)]
    pub differences: Differences,
    /// Fragments of the raster path that took the compute path.
    pub by_compute: u64,
    /// Invocations that gave up waiting for a lock and were rerun on the compute path.
    pub repeated: u64,
    /// Equal, different, unsupported or failed.
    pub status: Status,
    /// The reason, or what equality does not prove.
    pub reason: String,
    /// A difference that neither the method's contract nor, once it has been asked, the checker allows; or a failure.
    #[serde(rename = "finding")]
    pub is_finding: bool,
    /// What the checker expects.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<Prediction>,
}

impl Agreement {
    /// What the checker expects of the method; what it excludes is a finding, and what it allows is none.
    #[must_use]
    pub fn against(mut self, prediction: &Prediction) -> Self {
        if self.status == Status::Different && self.is_finding {
            let Differences { lost, duplicated, torn, .. } = self.differences;
            let counts = format!("{lost} lost, {duplicated} duplicated, {torn} torn");
            self.is_finding = prediction.expects != Expects::Loss;
            self.reason = if self.is_finding {
                format!("excluded by the checker: {counts}")
            } else {
                format!("as the checker expects, {counts}")
            };
        }
        self.expected = Some(prediction.clone());
        self
    }

    /// Whether there was something to compare.
    #[must_use]
    pub fn is_compared(&self) -> bool {
        matches!(self.status, Status::Equal | Status::Different)
    }
}

/// What to compare.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Options {
    /// The twins.
    pub twins: Vec<Twin>,
    /// `-k`.
    pub k: Option<u32>,
    /// Which paths.
    pub paths: Vec<Path>,
    /// The compute path's order: submission, or shuffled by this seed.
    pub shuffle: Option<u64>,
}

impl Default for Options {
    fn default() -> Self {
        Self { twins: twins(), k: None, paths: Path::ALL.to_vec(), shuffle: Some(0) }
    }
}

/// The twin of a method.
///
/// # Errors
/// It has no twin.
pub fn find(method: Method) -> error::Result<Twin> {
    twin(method).ok_or_else(|| {
        let names: Vec<&str> = twins().iter().map(|twin| twin.method.name()).collect();
        let problem = format!("{method} has no twin in WGSL; these have one: {}", names.join(", "));
        Error::new("-m", problem)
    })
}

/// What a method stores in comparisons: depths as exact as its records have room for, and triangles if they have room.
#[must_use]
pub fn record(contract: &Contract) -> Record {
    contract.record(None, Data::Primitive)
}

/// Draw a scene with every method on every path, and compare. If the device is lost, the remaining rows say so.
///
pub fn run(
    device: &dyn Backend,
    scene: &Scene,
    picture: &Picture,
    sub_pixel_bits: u32,
    options: &Options,
) -> Vec<Agreement> {
    let mut runs = Vec::new();
    for &twin in &options.twins {
        let contract = twin.method.contract();
        runs.extend(options.paths.iter().map(|&path| BandRun {
            device,
            scene,
            twin,
            contract,
            path,
            k: options.k,
            shuffle: options.shuffle,
            sum: Differences::default(),
            by_compute: 0,
            repeated: 0,
            failure: None,
        }));
    }
    for band in picture.bands() {
        runs.iter_mut().for_each(|run| run.band(&band));
    }
    let size = [picture.front.grid.width, picture.front.grid.height];
    runs.iter().map(|run| run.row(size, sub_pixel_bits)).collect()
}

/// One method on one path, band by band.
struct BandRun<'d> {
    device: &'d dyn Backend,
    scene: &'d Scene,
    twin: Twin,
    contract: &'static Contract,
    path: Path,
    k: Option<u32>,
    shuffle: Option<u64>,
    sum: Differences,
    by_compute: u64,
    repeated: u64,
    failure: Option<Failure>,
}

impl BandRun<'_> {
    fn band(&mut self, band: &Band<'_>) {
        if self.failure.is_some() {
            return;
        }
        let drawn = split(band, &mut |band| {
            let (differences, by_compute, repeated) = self.draw(band)?;
            self.sum.add(&differences);
            self.by_compute += by_compute;
            self.repeated += repeated;
            Ok(())
        });
        self.failure = drawn.err();
    }

    fn draw(&self, band: &Band<'_>) -> Result<(Differences, u64, u64)> {
        if self.device.is_lost() {
            return Err(Failure::Lost("by an earlier run; this one was not started".to_owned()));
        }
        self.device.can(self.twin, self.path)?;
        let record = record(self.contract);
        let expected = band.expected(self.twin.method, record, self.k);
        let Self { twin, path, k, shuffle, .. } = *self;
        let (scene, expected) = (self.scene.name.as_str(), &*expected);
        let job = Job { twin, path, k, shuffle, record, scene, band, expected };
        let drawn = self.device.draw(&job)?;
        let differences = compare(self.contract, self.k, expected, &drawn.got);
        Ok((differences, drawn.by_compute, drawn.repeated))
    }

    fn row(&self, size: [u32; 2], sub_pixel_bits: u32) -> Agreement {
        let name = &self.scene.name;
        let blank = blank(self.device.name(), &self.twin.name(), name, self.path, size);
        let (status, is_finding, reason) = self.verdict();
        Agreement {
            sub_pixel_bits,
            differences: self.sum,
            by_compute: self.by_compute,
            repeated: self.repeated,
            status,
            reason,
            is_finding,
            ..blank
        }
    }

    fn verdict(&self) -> (Status, bool, String) {
        let sum = &self.sum;
        if let Some(failure) = &self.failure {
            return failed(failure);
        }
        if !sum.is_equal() {
            if sum.not_allowed > 0
                || !(self.contract.is_racy() || self.contract.is_arrival_dependent())
            {
                return (Status::Different, true, "not allowed by the contract".to_owned());
            }
            let [lost, duplicated, torn] = [sum.lost, sum.duplicated, sum.torn];
            let why = if self.contract.has_right_depths() {
                "any of several fragments of equal depth may be kept"
            } else if self.contract.is_racy() {
                "it races"
            } else {
                "it depends on arrival"
            };
            let reason =
                format!("allowed, {why}: {lost} lost, {duplicated} duplicated, {torn} torn");
            return (Status::Different, false, reason);
        }
        let approximates = self.contract.keeps.is_approximate();
        let common =
            if approximates { "the number of nodes and the transmittance" } else { "the sum" };
        let unsettled = format!("of {} pixels only {common}: arrival decides", sum.unsettled);
        let bounds = Bounds::of(self.twin.method, &Config::default()).says();
        let (racy, raster) = (self.contract.is_racy(), self.path == Path::Raster);
        let reasons = [
            (
                racy && raster,
                "proves nothing about races: a driver may draw a tile in order, on one thread",
            ),
            (racy && !raster, "this time; it races"),
            (!racy && !self.twin.not_guaranteed().is_empty(), self.twin.not_guaranteed()),
            (self.contract.keeps == Keeps::Merged, "records without colours"),
            (!bounds.is_empty(), bounds),
            (sum.unsettled > 0, &unsettled),
        ];
        (Status::Equal, false, holding(&reasons))
    }
}

/// What holds of some reasons.
pub(super) fn holding(reasons: &[(bool, &str)]) -> String {
    let holding: Vec<&str> =
        reasons.iter().filter(|(holds, _)| *holds).map(|(_, why)| *why).collect();
    holding.join("; ")
}

/// A row of which nothing is known yet.
#[must_use]
pub fn blank(
    adapter: &AdapterName,
    method: &str,
    scene: &str,
    path: Path,
    size: [u32; 2],
) -> Agreement {
    Agreement {
        adapter: adapter.name.clone(),
        driver: adapter.driver.clone(),
        method: method.to_owned(),
        scene: scene.to_owned(),
        asked: scene.to_owned(),
        size,
        path,
        sub_pixel_bits: 0,
        differences: Differences::default(),
        by_compute: 0,
        repeated: 0,
        status: Status::Failed,
        reason: String::new(),
        is_finding: true,
        expected: None,
    }
}

/// The contents of a row whose run ended early: its status, whether it is a finding, and the reason.
#[must_use]
pub fn failed(failure: &Failure) -> (Status, bool, String) {
    match failure {
        Failure::Unsupported(why) => (Status::Unsupported, false, why.clone()),
        Failure::TimedOut(_) => (Status::Hung, true, failure.to_string()),
        Failure::Lost(why) => (Status::Lost, true, why.clone()),
        failure => (Status::Failed, true, failure.to_string()),
    }
}
