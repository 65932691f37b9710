//! A process that runs one method on one path of one adapter, and tells of each row as it finishes: a line of JSON.
//! If the device is lost, the process ends with it, and nobody else is hurt.

use std::io::Write;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use super::asked::{self, Subject};
use super::process::Line;
use super::{Args, row_without};
use crate::cli::Verdict;
use crate::error::{Error, Result};
use crate::gpu::check::backend::Backend;
use crate::gpu::check::crosscheck::{self, Agreement, Options, Status};
use crate::gpu::check::double::Double;
use crate::gpu::check::open::{self, Opened};
use crate::gpu::driver::device::AdapterName;
use crate::gpu::driver::failure::Failure;
use crate::gpu::twin::picture::Picture;

/// An adapter, as a worker is told of it.
pub(super) fn named(adapter: &AdapterName) -> String {
    format!("{}\n{}", adapter.name, adapter.driver)
}

/// Open it; from then on, there are signs of life.
///
/// # Errors
/// The name is none.
pub(super) fn open(args: &Args, name: &str) -> Result<std::result::Result<Opened, Failure>> {
    let (name, driver) = name
        .split_once('\n')
        .ok_or_else(|| Error::new("--worker", "must be a name and a driver"))?;
    Ok(open::one(name, driver).map(|mut opened| {
        opened.device.patience = args.limit;
        give_signs_of_life(Arc::clone(&opened.device.submissions));
        opened
    }))
}

/// Say it; without a reader there is no reason to go on.
pub(super) fn tell(line: &Line) {
    let mut text = serde_json::to_string(line).unwrap_or_default();
    text.push('\n');
    let mut out = std::io::stdout().lock();
    if out.write_all(text.as_bytes()).and_then(|()| out.flush()).is_err() {
        std::process::exit(2);
    }
}

/// Say once a second that submissions have come back, as long as they do.
fn give_signs_of_life(submissions: Arc<Mutex<u64>>) {
    let count = move || *submissions.lock().unwrap_or_else(PoisonError::into_inner);
    thread::spawn(move || {
        let mut known = count();
        loop {
            thread::sleep(Duration::from_secs(1));
            let now = count();
            if now != known {
                tell(&Line::Alive);
            }
            known = now;
        }
    });
}

/// The device of a worker.
enum Device {
    Real(Box<Opened>),
    Double(Double),
}

impl Device {
    fn open(args: &Args, name: &str) -> Result<std::result::Result<Self, Failure>> {
        if let Some(faults) = &args.test_double {
            return Double::open(faults).map(|double| Ok(Self::Double(double)));
        }
        Ok(open(args, name)?.map(|opened| Self::Real(Box::new(opened))))
    }

    fn backend(&self) -> &dyn Backend {
        match self {
            Self::Real(opened) => &opened.device,
            Self::Double(double) => double,
        }
    }

    fn bits(&self) -> u32 {
        match self {
            Self::Real(opened) => opened.bits(),
            Self::Double(_) => 8,
        }
    }

    /// Why there is no raster path, if it was asked for and there is none.
    fn no_raster(&self, options: &Options) -> Option<Failure> {
        match self {
            Self::Real(opened) => opened.no_raster(options),
            Self::Double(_) => None,
        }
    }
}

/// Run the one method on the one path that `options` has, over the pictures from `--from` on.
///
/// # Errors
/// Wrong options, or a scene that cannot be read any more.
pub(super) fn run(
    args: &Args,
    options: &Options,
    subjects: &[Subject],
    name: &str,
) -> Result<Verdict> {
    let device = match Device::open(args, name)? {
        Ok(device) => device,
        Err(failure) => {
            tell(&Line::Refused(failure.to_string()));
            return Ok(Verdict::Clean);
        }
    };
    tell(&Line::Opened);
    let (backend, bits) = (device.backend(), device.bits());
    let thickness = asked::thickness(args)?;
    for subject in &subjects[args.from.min(subjects.len())..] {
        let rows = if let Some(failure) = device.no_raster(options) {
            row_without(backend.name(), options, subject, &failure)
        } else {
            let scene = subject.load()?;
            let picture = Picture::new(&scene, bits).thick(&scene, thickness);
            crosscheck::run(backend, &scene, &picture, bits, options)
        };
        for row in rows {
            let is_over = matches!(row.status, Status::Hung | Status::Lost);
            tell(&Line::Row(Box::new(Agreement { asked: subject.asked.clone(), ..row })));
            if is_over {
                // Nothing is dropped: that could wait for the device again.
                std::process::exit(0);
            }
        }
    }
    Ok(Verdict::Clean)
}
