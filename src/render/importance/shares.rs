//! What a frame gave its pixels: importance and records.

use serde::Serialize;

use super::{ImportanceMap, pixels};
use crate::exec::Job;
use crate::render::{Options, Report};
use crate::scheme::kplus_buffer::k_variable::{BIAS_INPUT, FACTOR_INPUT};

/// What a frame gave its pixels, row by row.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shares {
    /// The importance of every pixel, in units of 2^-16.
    pub importance: Vec<u32>,
    /// k of every pixel.
    pub k: Vec<u32>,
    /// Fragments of every pixel.
    pub fragments: Vec<u32>,
}

/// A frame's importance and records, by the names that `--json` uses.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ImportanceReport {
    /// The factors that were multiplied, and noise.
    pub factors: Vec<&'static str>,
    /// Whether the Fresnel term had a frame before this one to be taken from; otherwise it is 1 everywhere.
    pub fresnel_known: bool,
    /// Records that were to be divided.
    pub records: u64,
    /// The sum of k over all pixels: never above that.
    pub shared: u64,
    /// The smallest k of a pixel with fragments.
    pub smallest_k: u32,
    /// The largest.
    pub largest_k: u32,
}

impl Shares {
    /// Of a frame whose storage pixels have so many fragments each, and share `records`.
    pub(in crate::render) fn of(
        options: &Options,
        job: &Job<'_>,
        records: u64,
        counts: &[u32],
    ) -> (Self, ImportanceReport) {
        let (importance, grid) = (&options.importance, &job.front.grid);
        let weighting = importance.weighting();
        let mut shares = Self::default();
        for (x, y) in pixels([grid.width, grid.height]) {
            let pixel = grid.pixel(x, y);
            let count = counts[pixel as usize];
            let [factor, bias] =
                [FACTOR_INPUT, BIAS_INPUT].map(|input| job.inputs.word(input, pixel));
            shares.importance.push(weighting.weight(factor, bias, count));
            shares.k.push(job.nearest.at(pixel as usize).unwrap_or(0));
            shares.fragments.push(count);
        }
        let filled = || shares.k.iter().zip(&shares.fragments).filter(|(_, n)| **n > 0);
        let report = ImportanceReport {
            factors: importance.factors.names(),
            fresnel_known: importance.factors.fresnel && importance.fresnel.is_some(),
            records,
            shared: shares.k.iter().map(|&k| u64::from(k)).sum(),
            smallest_k: filled().map(|(&k, _)| k).min().unwrap_or(0),
            largest_k: filled().map(|(&k, _)| k).max().unwrap_or(0),
        };
        (shares, report)
    }
}

impl ImportanceReport {
    /// Add it to the frame's report, with what follows from it.
    pub(in crate::render) fn add_to(self, report: &mut Report, options: &Options, shares: &Shares) {
        if let Some(budget) = &mut report.budget {
            let beyond = shares.fragments.iter().zip(&shares.k);
            budget.beyond = beyond.map(|(n, k)| u64::from(n.saturating_sub(*k))).sum();
        }
        let (records, pixels) = (self.records, shares.k.len() as u64);
        if records < pixels {
            report.warnings.push(format!(
                "{records} records for {pixels} pixels: most pixels of an even picture get none"
            ));
        }
        let picture = [report.width, report.height];
        let map = options.importance.map.as_ref().map(ImportanceMap::size);
        if let Some([width, height]) = map.filter(|size| *size != picture) {
            report.warnings.push(format!(
                "the importance map has {width}x{height} pixels and the picture {}x{}: it is stretched",
                picture[0], picture[1]
            ));
        }
        report.importance = Some(self);
    }
}
