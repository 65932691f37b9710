//! `render --reference`: another picture that the drawn one is compared with.

use std::fs::File;
use std::io::BufReader;

use serde::Serialize;

use crate::catalogue::Catalogue;
use crate::cli::terminal::wait;
use crate::error::{Error, Result};
use crate::exec::Method;
use crate::image::metrics::Metrics;
use crate::image::{Image, png};
use crate::render::{Exec, Options, Rendering, Report, render};
use crate::report::errors::Errors;
use crate::scene::{MAX_SIZE, Scene};

const OPTION: &str = "--reference";

/// What a picture is compared with.
pub(super) enum Reference {
    File(Image),
    Method(Method),
}

/// How far the drawn picture is from it.
#[derive(Debug, Serialize)]
pub(super) struct Against {
    /// As typed.
    reference: String,
    #[serde(flatten)]
    metrics: Metrics,
}

/// The accounting, with the errors if there is a reference.
#[derive(Serialize)]
pub(super) struct Document<'a> {
    #[serde(flatten)]
    pub(super) report: &'a Report,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) errors: Option<&'a Against>,
}

impl Against {
    /// As a row of the table.
    pub(super) fn errors<'a>(&'a self, report: &'a Report) -> Errors<'a> {
        let pixels = u64::from(report.width) * u64::from(report.height);
        let Self { reference, metrics } = self;
        Errors { method: &report.method, reference, metrics, pixels }
    }
}

impl Reference {
    /// A file that ends in `.png`, or a method.
    ///
    /// # Errors
    /// Neither, or a file that cannot be read.
    pub(super) fn read(catalogue: &Catalogue, typed: &str) -> Result<Self> {
        let wrong = |problem: String| Error::new(OPTION, format!("{typed} {problem}"));
        if typed.to_ascii_lowercase().ends_with(".png") {
            let file =
                File::open(typed).map_err(|error| wrong(format!("cannot be opened: {error}")))?;
            return png::decode(BufReader::new(file), MAX_SIZE).map(Self::File).map_err(wrong);
        }
        if typed.contains(['.', '/', '\\']) {
            return Err(wrong("must be a PNG file, FILE.png, or a method, like exact".to_owned()));
        }
        catalogue.find(OPTION, typed).map(Self::Method)
    }

    /// Check, before anything is drawn, that the picture will be as large.
    ///
    /// # Errors
    /// Both sizes.
    pub(super) fn check_size(&self, typed: &str, [width, height]: [u32; 2]) -> Result<()> {
        match self {
            Self::File(image) if [image.width, image.height] != [width, height] => {
                let own = format!("{}x{}", image.width, image.height);
                let problem = format!("{typed} has {own} pixels, the picture {width}x{height}");
                Err(Error::new(OPTION, format!("{problem}: both must be equal (see --size)")))
            }
            _ => Ok(()),
        }
    }

    /// Compare what was drawn with it. A method draws the same with its default k (exact: all fragments), in tiles, without
    /// a budget and without culling.
    ///
    /// # Errors
    /// What the method refuses.
    pub(super) fn against(
        &self,
        typed: &str,
        scene: &Scene,
        options: &Options,
        drawn: &Rendering,
        (threshold, quiet): (u8, bool),
    ) -> Result<Against> {
        let rendered;
        let image = match self {
            Self::File(image) => image,
            Self::Method(method) => {
                let record = options.record();
                let options = Options {
                    method: *method,
                    k: None,
                    exec: Exec::Tile,
                    depth_format: Some(record.depth),
                    data: record.data,
                    memory_budget: None,
                    cull: None,
                    k_average: None,
                    counters: false,
                    linear: false,
                    ..options.clone()
                };
                let message = format!("drawing {} with {method}", scene.name);
                rendered = wait::during(quiet, &message, || render(scene, &options))?;
                &rendered.image
            }
        };
        let measure = || Metrics::measure(image, &drawn.image, threshold);
        let metrics = wait::during(quiet, "measuring errors", measure)?;
        Ok(Against { reference: typed.to_owned(), metrics })
    }
}
