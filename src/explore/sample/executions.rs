//! Many executions of a scene on the simulated device.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::error::{Error, Result};
use crate::explore::memory::model::MemoryModel;
use crate::explore::program::subject::Subject;
use crate::explore::replay::token::{SceneToken, Token};
use crate::explore::search::explored::Limits;
use crate::explore::search::property::Property;
use crate::explore::verdict::{Finding, Scope, Verdict};
use crate::render::{Exec, Options, Rendering, Sim, reference, render};
use crate::resolve::Kept;
use crate::scene::Scene;
use crate::scheme::Keeps;

/// Many executions of a scene.
#[derive(Clone, Debug)]
pub struct Executions {
    /// The scene's name on the command line, which tokens use.
    pub name: String,
    /// `--schedule`, as typed: tokens repeat it.
    pub schedule: String,
    /// How it is drawn; the executor is the simulated device, and its seed the first of the seeds.
    pub options: Options,
    /// How many, with consecutive seeds.
    pub count: u64,
}

/// The result of one execution.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Executed {
    seed: u64,
    /// It holds something else than the method must keep, where that is known.
    differs: bool,
    result_hash: String,
    image_hash: String,
    lost: u64,
    wrong: Vec<String>,
}

impl Executions {
    /// Run them all; give one row for the kept fragments and one for whether all results are the same.
    ///
    /// # Errors
    /// The scene cannot be drawn in this way.
    pub fn check(
        &self,
        subject: &Subject,
        scene: &Scene,
        limits: &Limits<'_>,
    ) -> Result<Vec<Finding>> {
        let sim = self.sim()?;
        let right = reference(scene, &self.options)?;
        let run = |i: u64| self.run(scene, &sim, i, right.kept.as_ref(), limits);
        let all: Vec<Option<Executed>> =
            (0..self.count).into_par_iter().map(run).collect::<Result<_>>()?;
        let done: Vec<&Executed> = all.iter().flatten().collect();
        Ok(vec![self.keeps(subject, scene, &done), self.one_outcome(subject, scene, &done)])
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
        right: Option<&Kept>,
        limits: &Limits<'_>,
    ) -> Result<Option<Executed>> {
        if (limits.cancelled)() {
            return Ok(None);
        }
        let seed = sim.seed.wrapping_add(i);
        let exec = Exec::Sim(Sim { seed, ..sim.clone() });
        let options = Options { exec, threads: 1, counters: false, ..self.options.clone() };
        let Rendering { kept, report, .. } = render(scene, &options)?;
        Ok(Some(Executed {
            seed,
            differs: right.is_some_and(|right| *right != kept),
            result_hash: report.result_hash().to_owned(),
            image_hash: report.image_hash,
            lost: report.dropped.get("lost").copied().unwrap_or(0),
            wrong: report.violations,
        }))
    }

    fn keeps(&self, subject: &Subject, scene: &Scene, done: &[&Executed]) -> Finding {
        // Which hidden fragments are culled does not matter; each run has judged that they are hidden.
        let culls = subject.contract.keeps == Keeps::Visible;
        let wrong = |e: &&&Executed| {
            let differs = if culls { e.lost > 0 } else { e.differs };
            differs || !e.wrong.is_empty()
        };
        let failed: Vec<&&Executed> = done.iter().filter(wrong).collect();
        let mut row = self.row(subject, scene, Property::Keeps, done.len());
        let promised = match subject.contract.keeps {
            Keeps::Layers => "the nearest fragment of every depth",
            Keeps::Visible => "the exact fragments that can be seen",
            Keeps::Merged | Keeps::Approximate(_) => "what the method says that pixels must hold",
            _ => "the exact fragments",
        };
        match failed.first() {
            Some(first) => {
                row.verdict = Verdict::Violated;
                row.token = self.token(scene, first);
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

    fn one_outcome(&self, subject: &Subject, scene: &Scene, done: &[&Executed]) -> Finding {
        let mut images: BTreeMap<&str, &Executed> = BTreeMap::new();
        done.iter().for_each(|e| {
            images.entry(&e.image_hash).or_insert(e);
        });
        let mut row = self.row(subject, scene, Property::OneOutcome, done.len());
        let merges =
            subject.contract.keeps == Keeps::Merged && subject.contract.is_arrival_dependent();
        if images.len() > 1 && (merges || subject.contract.keeps == Keeps::Visible) {
            let what = if merges { "merged" } else { "culled" };
            row.message = format!(
                "{} different images in {} executions: which fragments are {what} may depend on arrival",
                images.len(),
                done.len()
            );
        } else if images.len() > 1 {
            row.verdict = Verdict::Violated;
            row.message = format!("{} different images in {} executions", images.len(), done.len());
            let first = done.first().map(|e| e.image_hash.as_str());
            let other = done.iter().find(|e| Some(e.image_hash.as_str()) != first);
            row.token = other.and_then(|e| self.token(scene, e));
        } else if let Some(hash) = images.keys().next() {
            row.message =
                format!("one image in {} executions, {hash}; a sample, no proof", done.len());
        }
        row
    }

    fn row(&self, subject: &Subject, scene: &Scene, property: Property, done: usize) -> Finding {
        let [w, h] = scene.size;
        Finding {
            method: subject.contract.name.to_owned(),
            property: Some(property.name().to_owned()),
            found: None,
            claim: None,
            verdict: Verdict::Unknown,
            exhaustive: false,
            bound: format!("{done} of {} executions, {}", self.count, self.schedule),
            scope: Scope {
                interleavings: "random",
                ks: self.options.k.into_iter().collect(),
                random_runs: done as u64,
                ..Scope::default()
            },
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

    /// `None` where inputs were given: a scene's token has no place for them.
    fn token(&self, scene: &Scene, executed: &Executed) -> Option<String> {
        if !self.options.inputs.is_empty() {
            return None;
        }
        let resident = self.sim().map_or(0, |sim| sim.resident as u64);
        let token = SceneToken {
            method: self.options.method.name().to_owned(),
            scene: self.name.clone(),
            size: scene.size,
            k: self.options.k,
            schedule: self.schedule.clone(),
            seed: executed.seed,
            resident,
            fragments_hash: executed.result_hash.clone(),
        };
        Some(Token::Scene(token).to_string())
    }
}
