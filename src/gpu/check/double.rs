//! A test double of a device: it holds what must be held, and fails where it is told to. So a run that survives a lost
//! device is tested without one.

use std::path::PathBuf;

use super::backend::{Backend, Drawn, Job, Path};
use crate::error;
use crate::gpu::driver::device::AdapterName;
use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::twin::resolve::Downloaded;
use crate::gpu::twin::source::Twin;

/// What goes wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The call never comes back.
    Hangs,
    /// The call never comes back, and no later process can open the device: a file remembers it.
    Dies(PathBuf),
    /// The driver notices that a submission takes too long.
    TimesOut,
    /// The device is lost.
    IsLost,
    /// The process ends.
    Crashes,
    /// What comes back is wrong.
    GivesGarbage,
}

/// A fault, and the row that has it.
#[derive(Clone, Debug, PartialEq, Eq)]
struct At {
    fault: Fault,
    method: String,
    scene: String,
    path: Path,
}

/// The double.
#[derive(Debug)]
pub struct Double {
    name: AdapterName,
    faults: Vec<At>,
    lost: std::cell::Cell<bool>,
}

impl Double {
    /// Its name as an adapter.
    #[must_use]
    pub fn adapter() -> AdapterName {
        AdapterName {
            name: "test double".to_owned(),
            driver: "of fragloom".to_owned(),
            backend: "none".to_owned(),
            kind: "Double".to_owned(),
        }
    }

    /// One with faults, separated by commas: `hangs=METHOD/SCENE/PATH`, and `times-out`, `is-lost`, `crashes`,
    /// `gives-garbage`, `dies:FILE` in the same way; or `none`. If it has died before, this never returns.
    ///
    /// # Errors
    /// It is none of these.
    pub fn open(faults: &str) -> error::Result<Self> {
        let wrong = |text: &str| error::Error::new("--test-double", format!("\"{text}\""));
        let mut all = Vec::new();
        for text in faults.split(',').filter(|text| *text != "none") {
            let (fault, row) = text.split_once('=').ok_or_else(|| wrong(text))?;
            let fault = match fault.split_once(':') {
                Some(("dies", file)) => Fault::Dies(file.into()),
                _ => match fault {
                    "hangs" => Fault::Hangs,
                    "times-out" => Fault::TimesOut,
                    "is-lost" => Fault::IsLost,
                    "crashes" => Fault::Crashes,
                    "gives-garbage" => Fault::GivesGarbage,
                    _ => return Err(wrong(text)),
                },
            };
            let [method, scene, path]: [&str; 3] = row
                .split('/')
                .collect::<Vec<_>>()
                .try_into()
                .map_err(|_: Vec<&str>| wrong(text))?;
            let path = Path::ALL.into_iter().find(|known| known.to_string() == path);
            let path = path.ok_or_else(|| wrong(text))?;
            let (method, scene) = (method.to_owned(), scene.to_owned());
            all.push(At { fault, method, scene, path });
        }
        if all.iter().any(|at| matches!(&at.fault, Fault::Dies(file) if file.exists())) {
            hang();
        }
        Ok(Self { name: Self::adapter(), faults: all, lost: std::cell::Cell::new(false) })
    }
}

fn hang() -> ! {
    loop {
        std::thread::park();
    }
}

impl Backend for Double {
    fn name(&self) -> &AdapterName {
        &self.name
    }

    fn is_lost(&self) -> bool {
        self.lost.get()
    }

    fn can(&self, twin: Twin, _: Path) -> Result<()> {
        let contract = twin.method.contract();
        if contract.has_slabs() || contract.keeps.is_approximate() {
            return Err(Failure::Unsupported("only lists of fragments".to_owned()));
        }
        Ok(())
    }

    fn draw(&self, job: &Job<'_>) -> Result<Drawn> {
        let method = job.twin.method.name();
        let of_row = |at: &&At| at.method == method && at.scene == job.scene && at.path == job.path;
        let fault = self.faults.iter().find(of_row).map(|at| &at.fault);
        let kept = &job.expected.kept;
        let rooms: Vec<(u32, u32)> =
            kept.starts.windows(2).map(|ends| (ends[0], ends[1] - ends[0])).collect();
        let mut got = Downloaded {
            counts: rooms.iter().map(|room| room.1).collect(),
            keys: kept.keys.clone(),
            colors: job.expected.colors.clone(),
            rooms,
        };
        match fault {
            None => {}
            Some(Fault::Hangs) => hang(),
            Some(Fault::Dies(file)) => {
                std::fs::write(file, "").map_err(|error| Failure::Invalid(error.to_string()))?;
                hang()
            }
            Some(Fault::TimesOut) => {
                self.lost.set(true);
                return Err(Failure::TimedOut(1));
            }
            Some(Fault::IsLost) => {
                self.lost.set(true);
                return Err(Failure::Lost("the double was told to".to_owned()));
            }
            Some(Fault::Crashes) => std::process::abort(),
            Some(Fault::GivesGarbage) => got.keys.iter_mut().for_each(|key| *key ^= 1 << 40),
        }
        Ok(Drawn { got, ..Drawn::default() })
    }
}
