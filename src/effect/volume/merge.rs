//! Where samples and layers meet on a ray.
//!
//! Where a sample and a layer overlap, the parts of both there are mixed, as in smooth fragment merging, and the rest is
//! in front or behind: for one of each, this is [`Slab::smooth`] to the bit. All cuts are measured on the whole slab. A
//! layer longer than a sample goes on into the next one. A surface of no thickness cuts the sample in two and stands
//! between, which is the limit of thinner and thinner layers. Layers that meet no sample stand over each other whole, in
//! the order of their far ends, as in the picture without volumes.

use crate::scheme::merging::Blending;
use crate::scheme::merging::slab::{Slab, Visibility, mix};

/// A ray so far.
pub(super) struct Meeting<'a> {
    /// Sorted by their far ends.
    layers: &'a [Slab],
    /// Up to where each layer has been taken; its near end, if not at all.
    taken: Vec<f64>,
    /// Layers before this one are behind us.
    next: usize,
    light: Visibility,
    met: bool,
    blending: Blending,
}

impl<'a> Meeting<'a> {
    /// Before these layers, which are sorted by their far ends.
    pub(super) fn new(layers: &'a [Slab], blending: Blending) -> Self {
        let taken = layers.iter().map(|layer| layer.near).collect();
        Self { layers, taken, next: 0, light: Visibility::default(), met: false, blending }
    }

    /// The share of light that is left.
    pub(super) fn through(&self) -> f64 {
        1.0 - self.light.opacity
    }

    /// Go through the next sample, merging it with the layers that it overlaps. Samples come front to back.
    pub(super) fn merge(&mut self, sample: &Slab) {
        self.met = true;
        self.reach(sample.near);
        self.leave(sample.near);
        let mut from = sample.near;
        while from < sample.far {
            let to = self.next_end(from, sample.far);
            let whole = from <= sample.near && to >= sample.far;
            let mut mixed = None;
            for (layer, taken) in self.layers.iter().zip(&mut self.taken).skip(self.next) {
                if layer.near <= from && to <= layer.far {
                    let (here, sum) =
                        mixed.unwrap_or_else(|| sample.part(from, to, &self.blending));
                    let part = layer.part(from, to, &self.blending);
                    mixed = Some((mix((here, sum), part), sum + part.1));
                    *taken = to;
                }
            }
            let here = match mixed {
                Some((here, _)) => here,
                None if whole => sample.visibility,
                None => sample.part(from, to, &self.blending).0,
            };
            self.light = self.light.over(here);
            self.reach(to);
            from = to;
        }
    }

    /// Go through the next sample, behind all layers that end no later.
    pub(super) fn pass(&mut self, sample: &Slab) {
        self.met = true;
        self.reach(sample.far);
        self.light = self.light.over(sample.visibility);
    }

    /// All that is left; `None` if there was no sample. Below `until`, the rest does not matter.
    pub(super) fn finish(mut self, until: f64) -> Option<Visibility> {
        if self.met && self.through() >= until {
            self.reach(f64::INFINITY);
        }
        self.met.then_some(self.light)
    }

    /// The first end of a layer between two distances, or the second distance.
    fn next_end(&self, from: f64, to: f64) -> f64 {
        let ends = self.layers[self.next..].iter().flat_map(|layer| [layer.near, layer.far]);
        ends.filter(|end| *end > from).fold(to, f64::min)
    }

    /// Put what is left of the layers that end up to a distance behind the rest.
    fn reach(&mut self, distance: f64) {
        while let Some(layer) = self.layers.get(self.next).filter(|layer| layer.far <= distance) {
            let taken = self.taken[self.next];
            let rest = if taken > layer.near {
                layer.part(taken, layer.far, &self.blending).0
            } else {
                layer.visibility
            };
            if taken < layer.far || taken <= layer.near {
                self.light = self.light.over(rest);
            }
            self.next += 1;
        }
    }

    /// Put what lies in front of a distance, of the layers that go on behind it, behind the rest.
    fn leave(&mut self, distance: f64) {
        for (layer, taken) in self.layers.iter().zip(&mut self.taken).skip(self.next) {
            if *taken < distance {
                self.light = self.light.over(layer.part(*taken, distance, &self.blending).0);
                *taken = distance;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn slab(near: f64, far: f64, opacity: f64, red: f64) -> Slab {
        let visibility = Visibility { color: [red * opacity, 0.0, 0.25 * opacity], opacity };
        Slab { near, far, visibility, sum: opacity, ..Slab::default() }
    }

    fn merged(layers: &[Slab], samples: &[Slab], beta: f64) -> Visibility {
        let blending = Blending { beta, ..Blending::default() };
        let mut meeting = Meeting::new(layers, blending);
        samples.iter().for_each(|sample| meeting.merge(sample));
        meeting.finish(0.0).unwrap()
    }

    fn apart(a: Visibility, b: Visibility) -> f64 {
        a.rgba().iter().zip(b.rgba()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    }

    /// The samples of an even medium: A per unit of length, from `near` on.
    fn medium(near: f64, length: f64, steps: u32, opacity: f64) -> Vec<Slab> {
        let step = length / f64::from(steps);
        let alpha = 1.0 - libm::pow(1.0 - opacity, step);
        let at = |i: u32| near + f64::from(i) * step;
        (0..steps).map(|i| slab(at(i), at(i + 1), alpha, 0.5)).collect()
    }

    proptest! {
        /// One sample and one layer that overlap are merged smoothly, to the bit.
        #[test]
        fn one_of_each_is_smooth_merging(
            ends in prop::array::uniform4(0.0..1.0_f64),
            a in 0.0..1.0_f64,
            b in 0.0..1.0_f64,
            beta in prop::sample::select(vec![0.0, 0.5, 1.0]),
        ) {
            let [layer, sample] = [[ends[0], ends[1]], [ends[2], ends[3]]];
            let make = |[x, y]: [f64; 2], opacity, red| slab(x.min(y), x.max(y), opacity, red);
            let (layer, sample) = (make(layer, a, 0.75), make(sample, b, 0.125));
            let blending = Blending { beta, ..Blending::default() };
            prop_assume!(layer.overlaps(&sample, false));
            let (first, second) =
                if layer.far <= sample.far { (&layer, &sample) } else { (&sample, &layer) };
            let expected = first.smooth(second, &blending).visibility;
            prop_assert_eq!(merged(&[layer], &[sample], beta), expected);
        }
    }

    /// Cut optically, a surface anywhere in a medium is what closed form says, whatever the step.
    #[test]
    fn a_surface_in_a_medium() {
        let surface = slab(2.3, 2.3, 0.5, 1.0);
        let medium_to = |length: f64| {
            let opacity = 1.0 - libm::pow(0.25, length);
            slab(0.0, 0.0, opacity, 0.5).visibility
        };
        let expected = medium_to(1.3).over(surface.visibility).over(medium_to(1.7));
        for steps in [1, 2, 7, 300] {
            let found = merged(&[surface], &medium(1.0, 3.0, steps, 0.75), 0.0);
            assert!(apart(found, expected) < 1e-13, "{steps}: {found:?} {expected:?}");
        }
        // With the linear cut of β = 1, the error falls with the square of the step.
        let error =
            |steps| apart(merged(&[surface], &medium(1.0, 3.0, steps, 0.75), 1.0), expected);
        assert!(error(20) < 1e-2 && error(40) < error(20) / 2.0 && error(320) < 1e-4);
    }

    /// A layer that reaches over many samples is all there: without the medium's colour, their transmittances multiply.
    #[test]
    fn a_long_layer_goes_through_many_samples() {
        for beta in [0.0, 1.0] {
            for [near, far] in [[0.0, 5.0], [1.5, 2.5], [0.0, 2.0], [2.0, 9.0]] {
                let layer = slab(near, far, 0.6, 1.0);
                let found = merged(&[layer], &medium(1.0, 3.0, 50, 0.75), beta);
                let expected = 1.0 - 0.4 * libm::pow(0.25, 3.0);
                assert!((found.opacity - expected).abs() < 1e-13, "{near} {far}: {found:?}");
            }
        }
    }

    #[test]
    fn what_does_not_overlap_is_in_front_or_behind() {
        let layers = [slab(0.0, 1.0, 1.0, 1.0), slab(4.0, 5.0, 0.5, 0.25)];
        let sample = slab(1.0, 4.0, 0.5, 0.5);
        let found = merged(&layers, &[sample], 1.0);
        assert_eq!(found, layers[0].visibility, "an opaque layer is not clamped");
        let found = merged(&layers[1..], &[sample], 1.0);
        assert_eq!(found, sample.visibility.over(layers[1].visibility));
        assert!(Meeting::new(&layers, Blending::default()).finish(0.0).is_none(), "no sample");
    }

    /// Without merging, a surface in a sample is in front of all of it.
    #[test]
    fn without_merging_samples_are_not_cut() {
        let surface = slab(2.3, 2.3, 0.5, 1.0);
        let sample = slab(1.0, 3.0, 0.75, 0.5);
        let layers = [surface];
        let mut meeting = Meeting::new(&layers, Blending::default());
        meeting.pass(&sample);
        let found = meeting.finish(0.0).unwrap();
        assert_eq!(found, surface.visibility.over(sample.visibility));
    }
}
