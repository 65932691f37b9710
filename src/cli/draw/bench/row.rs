//! What a timing is: the fields of a row, by the names that `--json` and `--csv` use.

use std::collections::BTreeMap;

/// One method on one scene, by one executor, and by a device if requested.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub(super) struct Timing {
    pub(super) method: String,
    pub(super) scene: String,
    /// The scene as it was named: a file, or a built-in scene with its keys.
    pub(super) asked: String,
    pub(super) exec: String,
    pub(super) threads: usize,
    pub(super) fragments: u64,
    pub(super) triangles: u64,
    /// Medians, by phase.
    pub(super) seconds: BTreeMap<String, f64>,
    /// Of clear, store and resolve.
    pub(super) mfrag_per_s: f64,
    /// Set-up and binning, million triangles a second and core.
    pub(super) setup_mtri_per_s: f64,
    /// Coverage alone, 10^9 fragments a second and core.
    pub(super) coverage_gfrag_per_s: f64,
    /// The largest resident set of the process during the row, in MiB.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) peak_mib: Option<f64>,
    /// Atomic operations and bytes of words touched, by fragment.
    pub(super) atomics_per_fragment: f64,
    pub(super) bytes_per_fragment: f64,
    /// What the machine takes at least, and our time over that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) limit_seconds: Option<f64>,
    /// What that is: `emit`, `atomics`, `cache` or `memory`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) limit_by: Option<&'static str>,
    pub(super) limit_ratio: Option<f64>,
    /// On the simulated device, million memory operations a second in the frame's passes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) mops_per_s: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) adapter: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) gpu_seconds: Option<f64>,
    /// Bands that the device's picture is split into.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) parts: Option<usize>,
    /// The device's time over ours, median of alternating runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) ratio: Option<f64>,
    /// The smallest and the largest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) ratio_spread: Option<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) unsupported: Option<String>,
    /// Intervals of the culling passes, if there are any: the seconds of `culling` are theirs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) cull_intervals: Option<u32>,
    /// Time with culling over time without, median of alternating runs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) cull_ratio: Option<f64>,
}

impl Timing {
    /// Seconds of a phase; 0 if it has none.
    pub(super) fn phase(&self, name: &str) -> f64 {
        self.seconds.get(name).copied().unwrap_or_default()
    }

    /// Seconds of the whole frame, from a scene in memory to hashed results.
    pub(super) fn frame(&self) -> f64 {
        FRAME.iter().map(|phase| self.phase(phase)).sum()
    }
}

/// The phases that follow each other in a frame; all others are parts of these, or timed beside it.
const FRAME: [&str; 7] = ["setup", "count", "culling", "draw", "judge", "assemble", "hash"];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_its_phases_once() {
        let seconds = [
            ("load", 64.0),
            ("setup", 1.0),
            ("count", 2.0),
            ("coverage", 64.0),
            ("emit", 64.0),
            ("draw", 4.0),
            ("draw.store", 64.0),
            ("store_resolve", 64.0),
            ("assemble", 8.0),
            ("hash", 16.0),
        ];
        let seconds = seconds.map(|(name, seconds)| (name.to_owned(), seconds)).into();
        let row = Timing { seconds, ..Timing::default() };
        assert_eq!(row.frame().to_bits(), 31.0f64.to_bits());
        assert_eq!(row.phase("culling").to_bits(), 0);
    }
}
