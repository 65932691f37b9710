//! Whole scenes: many executions on the simulated device, and one pixel of a scene as a litmus pixel.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::case::Subject;
use super::check::Survey;
use super::exhaustive::{self, Found, Limits};
use super::litmus::Litmus;
use super::machine::{Device, MOST_INVOCATIONS};
use super::model::MemoryModel;
use super::property::Property;
use super::sites;
use super::token::{SceneToken, Token};
use super::verdict::{Row, Verdict};
use super::walk::walk;
use crate::error::{Error, Result};
use crate::exec::sim::policy::{self, Settings};
use crate::fragment::Fragment;
use crate::raster::primitive::Rect;
use crate::raster::{Batch, FrontEnd, Grid, Record};
use crate::render::{Exec, Options, Sim, reference, render};
use crate::resolve::digest::kept_hash;
use crate::scene::Scene;
use crate::scheme::Keeps;

/// Many executions of a scene.
#[derive(Clone, Debug)]
pub struct Executions {
    /// How the scene is named on the command line: tokens name it so.
    pub name: String,
    /// `--schedule`, as typed: tokens repeat it.
    pub schedule: String,
    /// How it is drawn; the executor is the simulated device, and its seed the first of the seeds.
    pub options: Options,
    /// How many, with seeds one after another.
    pub count: u64,
}

/// What one execution gave.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Executed {
    seed: u64,
    fragments_hash: Option<String>,
    image_hash: String,
    lost: u64,
    wrong: Vec<String>,
}

impl Executions {
    /// Run them all; one row for the kept fragments and one for the result being the same.
    ///
    /// # Errors
    /// The scene cannot be drawn so.
    pub fn check(&self, subject: &Subject, scene: &Scene, limits: &Limits<'_>) -> Result<Vec<Row>> {
        let sim = self.sim()?;
        let right = reference(scene, &self.options)?;
        let expected = right.kept.as_ref().and_then(kept_hash);
        let run = |i: u64| self.run(scene, &sim, i, limits);
        let all: Vec<Option<Executed>> =
            (0..self.count).into_par_iter().map(run).collect::<Result<_>>()?;
        let done: Vec<&Executed> = all.iter().flatten().collect();
        Ok(vec![
            self.keeps(subject, scene, &done, expected.as_deref()),
            self.one_outcome(subject, scene, &done),
        ])
    }

    fn sim(&self) -> Result<Sim> {
        match &self.options.exec {
            Exec::Sim(sim) => Ok(sim.clone()),
            _ => Err(Error::new("--exec", "executions are counted on the simulated device")),
        }
    }

    fn run(
        &self,
        scene: &Scene,
        sim: &Sim,
        i: u64,
        limits: &Limits<'_>,
    ) -> Result<Option<Executed>> {
        if (limits.cancelled)() {
            return Ok(None);
        }
        let seed = sim.seed.wrapping_add(i);
        let exec = Exec::Sim(Sim { seed, ..sim.clone() });
        let options = Options { exec, threads: 1, counters: false, ..self.options.clone() };
        let report = render(scene, &options)?.report;
        Ok(Some(Executed {
            seed,
            fragments_hash: report.fragments_hash,
            image_hash: report.image_hash,
            lost: report.dropped.get("lost").copied().unwrap_or(0),
            wrong: report.violations,
        }))
    }

    fn keeps(
        &self,
        subject: &Subject,
        scene: &Scene,
        done: &[&Executed],
        expected: Option<&str>,
    ) -> Row {
        // Which of the hidden fragments are culled is nobody's business; each run has judged that they are hidden.
        let culls = subject.contract.keeps == Keeps::Visible;
        let wrong = |e: &&&Executed| {
            let found = e.fragments_hash.as_deref();
            let differs = if culls { e.lost > 0 } else { expected.is_some() && found != expected };
            differs || !e.wrong.is_empty()
        };
        let failed: Vec<&&Executed> = done.iter().filter(wrong).collect();
        let mut row = self.row(subject, scene, Property::Keeps, done.len());
        let promised = match subject.contract.keeps {
            Keeps::Layers => "the nearest fragment of every depth",
            Keeps::Visible => "the exact fragments that can be seen",
            _ => "the exact fragments",
        };
        match failed.first() {
            Some(first) => {
                row.verdict = Verdict::Violated;
                row.token = Some(self.token(scene, first));
                row.message = format!(
                    "{} of {} executions differ from {promised}; seed {} loses {}",
                    failed.len(),
                    done.len(),
                    first.seed,
                    first.lost
                );
                if let Some(wrong) = first.wrong.first() {
                    row.message += &format!("; {wrong}");
                }
            }
            None => {
                row.message =
                    format!("{} executions equal {promised}; a sample, no proof", done.len());
            }
        }
        row
    }

    fn one_outcome(&self, subject: &Subject, scene: &Scene, done: &[&Executed]) -> Row {
        let mut images: BTreeMap<&str, &Executed> = BTreeMap::new();
        done.iter().for_each(|e| {
            images.entry(&e.image_hash).or_insert(e);
        });
        let mut row = self.row(subject, scene, Property::OneOutcome, done.len());
        if images.len() > 1 && subject.contract.keeps == Keeps::Visible {
            row.message = format!(
                "{} different images in {} executions: who is culled may depend on arrival",
                images.len(),
                done.len()
            );
        } else if images.len() > 1 {
            row.verdict = Verdict::Violated;
            row.message = format!("{} different images in {} executions", images.len(), done.len());
            let first = done.first().map(|e| e.image_hash.as_str());
            let other = done.iter().find(|e| Some(e.image_hash.as_str()) != first);
            row.token = other.map(|e| self.token(scene, e));
        } else if let Some(hash) = images.keys().next() {
            row.message =
                format!("one image in {} executions, {hash}; a sample, no proof", done.len());
        }
        row
    }

    fn row(&self, subject: &Subject, scene: &Scene, property: Property, done: usize) -> Row {
        let [w, h] = scene.size;
        Row {
            method: subject.contract.name.to_owned(),
            property: Some(property.name().to_owned()),
            claim: None,
            verdict: Verdict::Unknown,
            exhaustive: false,
            bound: format!("{done} of {} executions, {}", self.count, self.schedule),
            memory: MemoryModel::Sequential.name().to_owned(),
            profile: None,
            progress: None,
            instance: format!("{} at {w}x{h}", self.name),
            initial: "a pattern, but for the clear pass".to_owned(),
            executions: Some(done as u64),
            states: 0,
            token: None,
            steps: None,
            message: String::new(),
            outcomes: Vec::new(),
        }
    }

    fn token(&self, scene: &Scene, executed: &Executed) -> String {
        let resident = self.sim().map_or(0, |sim| sim.resident as u64);
        let token = SceneToken {
            method: self.options.method.name().to_owned(),
            scene: self.name.clone(),
            size: scene.size,
            k: self.options.k,
            schedule: self.schedule.clone(),
            seed: executed.seed,
            resident,
            fragments_hash: executed.fragments_hash.clone().unwrap_or_default(),
        };
        Token::Scene(token).to_string()
    }
}

/// The fragments of one pixel in submission order, as a litmus pixel.
///
/// # Errors
/// The pixel is outside of the picture, has no fragments, or too many to be explored.
pub fn cut(
    subject: &Subject,
    scene: &Scene,
    options: &Options,
    [x, y]: [u32; 2],
) -> Result<Litmus> {
    let [width, height] = scene.size;
    let wrong = |problem: String| Error::new("--pixel", problem);
    if x >= width || y >= height {
        return Err(wrong(format!("{x},{y} is outside of the picture of {width}x{height}")));
    }
    let grid = Grid { width, height, tile: options.tile };
    let front = FrontEnd::new(scene, grid, options.sub_pixel_bits, options.cull_face);
    let fragments = pixel(&front, options.record(), [x, y]);
    let most = MOST_INVOCATIONS - 4;
    if fragments.is_empty() || fragments.len() > most {
        let n = fragments.len();
        let right = format!("1 to {most} can be explored; --executions samples the whole scene");
        return Err(wrong(format!("{x},{y} has {n} fragments: {right}")));
    }
    Ok(litmus_of(&fragments, options.k.or(subject.contract.default_k)))
}

/// A litmus pixel of some fragments.
#[must_use]
pub fn litmus_of(fragments: &[Fragment], k: Option<u32>) -> Litmus {
    Litmus {
        pixels: 1,
        k,
        room: fragments.len() as u32,
        fragments: fragments.iter().map(|f| (0, f.depth, f.data)).collect(),
        helpers: 0,
        table: None,
        inputs: Vec::new(),
    }
}

/// A pixel's fragments in submission order.
fn pixel(front: &FrontEnd, record: Record, [x, y]: [u32; 2]) -> Vec<Fragment> {
    let window = Rect { x0: x, y0: y, x1: x + 1, y1: y + 1 };
    let mut found = Vec::new();
    let mut batch = Batch::default();
    for primitive in 0..front.primitives().len() as u32 {
        let mut packets = Vec::new();
        front.primitive_packets(primitive, window, |packet| packets.push(packet));
        for packet in packets {
            front.fragments(packet, record, 0, &mut batch);
            found.extend_from_slice(batch.fragments());
        }
    }
    found
}

/// Explore one given instance, for one row per property.
#[must_use]
pub fn survey(subject: &Subject, litmus: &Litmus, device: Device, limits: &Limits<'_>) -> Survey {
    let explored = exhaustive::explore(&subject.case(litmus), device, limits);
    let n = litmus.fragments.len() as u32;
    let k = litmus.k.map(|k| format!(", k = {k}")).unwrap_or_default();
    let given = Some(format!("these {n} fragments{k}"));
    let explored = vec![(litmus.clone(), explored)];
    // One pixel need not show all of the method: what it shows is only of these fragments.
    let reached_elsewhere = sites::operations(subject.contract.source)
        .into_keys()
        .map(|(line, column)| ("", line, column))
        .collect();
    Survey { subject: *subject, device, explored, planned: n, size: n, given, reached_elsewhere }
}

/// As [`survey`]; where a bound keeps it from an answer, so many random runs look for a violation, which is then cut
/// down. What they do not find stays unknown.
///
/// # Errors
/// None that a random policy has.
pub fn sampled(
    subject: &Subject,
    litmus: &Litmus,
    device: Device,
    runs: u64,
    limits: &Limits<'_>,
) -> Result<Survey> {
    let mut survey = survey(subject, litmus, device, limits);
    let explored = &mut survey.explored[0].1;
    if explored.complete {
        return Ok(survey);
    }
    let case = subject.case(litmus);
    let one = |seed: u64| {
        let settings = Settings {
            policy: policy::Kind::Random,
            seed,
            resident: MOST_INVOCATIONS,
            record: false,
            fingerprint: 0,
            watch: None,
            check: false,
        };
        walk(&case, device, &settings, limits)
    };
    let all: Vec<_> = (0..runs).into_par_iter().map(one).collect::<Result<_>>()?;
    let mut ended = 0;
    for (schedule, run) in all.into_iter().flatten() {
        ended += 1;
        for (property, message) in run.violations() {
            let found = Found { message: message.clone(), schedule: schedule.clone() };
            explored.violations.entry(*property).or_insert(found);
        }
        if let Some(end) = &run.end {
            explored.outcomes.entry(end.pixels.clone()).or_insert(schedule);
        }
    }
    if let Some(given) = &mut survey.given {
        *given += &format!(", and {ended} random runs");
    }
    Ok(survey)
}
