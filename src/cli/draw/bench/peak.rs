//! The peak of the process's memory, where the system says it: on Linux, `VmHWM`, which a process may reset.

use std::fs;

/// Bytes of a MiB, in KiB.
const KIB: f64 = 1_024.0;

/// Watch `work`: what it gives, and the largest resident set meanwhile in MiB, if that can be known. It is that of the
/// whole process, scenes and drivers included.
pub(super) fn during<T>(work: impl FnOnce() -> T) -> (T, Option<f64>) {
    // Without a reset, the peak may be an earlier one.
    let is_reset = cfg!(target_os = "linux") && fs::write("/proc/self/clear_refs", "5").is_ok();
    let done = work();
    let status = fs::read_to_string("/proc/self/status").ok().filter(|_| is_reset);
    (done, status.as_deref().and_then(peak_in))
}

/// The peak in MiB that a status file says.
fn peak_in(status: &str) -> Option<f64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u32 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(f64::from(kib) / KIB)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_peak_is_read_from_the_status() {
        let status = "Name:\tx\nVmPeak:\t  999999 kB\nVmHWM:\t    3072 kB\nVmRSS:\t    1024 kB\n";
        assert_eq!(peak_in(status).map(f64::to_bits), Some(3.0f64.to_bits()));
        for other in ["", "VmPeak:\t 8 kB\n", "VmHWM:\t 8 pages\n", "VmHWM:\t many kB\n"] {
            assert_eq!(peak_in(other), None, "{other}");
        }
    }

    /// What is there for a while only is in the peak, and a later peak is without it.
    #[cfg(target_os = "linux")]
    #[test]
    fn a_peak_is_that_of_the_work() {
        let (_, small) = during(|| std::hint::black_box(1));
        let (bytes, large) = during(|| std::hint::black_box(vec![1u8; 256 << 20]).len());
        assert_eq!(bytes, 256 << 20);
        if let (Some(small), Some(large)) = (small, large) {
            assert!(large >= 256.0 && large > small, "{small} {large}");
        }
    }
}
