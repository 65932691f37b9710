//! What is seen after one step of an invocation: words of memory, of a device or of the simulator.

use crate::gpu::twin::bounds::Bounds;

/// All words by binding, and a store invocation's outcome.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Seen {
    pub(super) words: [Vec<u8>; 4],
    pub(super) outcome: Option<u32>,
}

/// How words are judged.
pub(super) struct Judged {
    pub(super) bounds: Bounds,
    /// 64-bit words of a pixel.
    pub(super) words: usize,
    /// How many fragments there are.
    pub(super) fragments: u64,
}

/// What differs, if anything: more than a bound allows, where a twin's floats are in a pixel's 64-bit words.
pub(super) fn difference(judged: &Judged, right: &Seen, found: &Seen) -> Option<String> {
    const NAMES: [&str; 4] = ["pixels'", "pixels' 64-bit", "the frame's", "the frame's 64-bit"];
    let words = |bytes: &[u8]| -> Vec<u64> { bytemuck::pod_collect_to_vec(bytes) };
    let (all, others) = (words(&right.words[1]), words(&found.words[1]));
    let pixels = all.chunks(judged.words.max(1)).zip(others.chunks(judged.words.max(1)));
    for (pixel, (right, found)) in pixels.enumerate() {
        if let Some(at) = judged.bounds.first_apart(right, found, judged.fragments) {
            let [right, found] = [right, found].map(|words| words.get(at).copied().unwrap_or(0));
            return Some(format!(
                "64-bit word {at} of pixel {pixel} is {found:x} instead of {right:x}"
            ));
        }
    }
    for (place, (right, found)) in right.words.iter().zip(&found.words).enumerate() {
        if place == 1 || right == found {
            continue;
        }
        let words = |bytes: &[u8]| -> Vec<u32> { bytemuck::pod_collect_to_vec(bytes) };
        let (right, found) = (words(right), words(found));
        let at = (0..right.len()).find(|&i| found.get(i) != right.get(i)).unwrap_or_default();
        let [right, found] = [right, found].map(|words| words.get(at).copied().unwrap_or(0));
        let name = NAMES[place];
        return Some(format!("{name} words, [{at}] is {found:x} instead of {right:x}"));
    }
    (right.outcome != found.outcome)
        .then(|| format!("the outcome is {:?} instead of {:?}", found.outcome, right.outcome))
}
