//! A ray's way through boxes, and the samples on it. Distances are along the line of sight, as records have them.

use glam::{DMat4, DVec3};

use crate::effect::lens::Sight;
use crate::num::planes::Planes;
use crate::scene::Volume;
use crate::scheme::merging::slab::{Slab, Visibility, mix};

/// The volumes of a scene, ready for rays.
pub(super) struct Path<'a> {
    volumes: Vec<(&'a Volume, DMat4)>,
    planes: Planes,
    step: Option<f64>,
}

/// A ray within a volume's box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    volume: usize,
    from: f64,
    to: f64,
    /// Where the ray begins in the box, and one step along the line of sight.
    origin: DVec3,
    direction: DVec3,
}

impl<'a> Path<'a> {
    /// Through these volumes, between the planes; `step` is theirs, if it is not given.
    pub(super) fn new(volumes: &'a [Volume], planes: Planes, step: Option<f64>) -> Self {
        let volumes = volumes.iter().map(|volume| (volume, volume.place.inverse())).collect();
        Self { volumes, planes, step }
    }

    /// The boxes that a ray goes through.
    pub(super) fn enter(&self, sight: Sight, passages: &mut Vec<Passage>) {
        passages.clear();
        let [origin, direction] = sight.ray();
        for (volume, (_, into)) in self.volumes.iter().enumerate() {
            let origin = into.transform_point3(origin);
            let direction = into.transform_vector3(direction);
            let (mut from, mut to) = (self.planes.near, self.planes.far);
            for i in 0..3 {
                if direction[i] == 0.0 {
                    if !(0.0..=1.0).contains(&origin[i]) {
                        to = f64::NEG_INFINITY;
                    }
                    continue;
                }
                let ends = [-origin[i] / direction[i], (1.0 - origin[i]) / direction[i]];
                from = from.max(ends[0].min(ends[1]));
                to = to.min(ends[0].max(ends[1]));
            }
            if from < to {
                passages.push(Passage { volume, from, to, origin, direction });
            }
        }
    }

    /// Samples that stop light, front to back, until `take` wants no more.
    pub(super) fn walk(
        &self,
        sight: Sight,
        passages: &[Passage],
        mut take: impl FnMut(Slab) -> bool,
    ) {
        let mut ends: Vec<f64> = passages.iter().flat_map(|p| [p.from, p.to]).collect();
        ends.sort_by(f64::total_cmp);
        let mut inside: Vec<Passage> = Vec::with_capacity(passages.len());
        for pair in ends.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            inside.clear();
            inside.extend(passages.iter().filter(|p| p.from <= from && to <= p.to));
            if inside.is_empty() || from >= to {
                continue;
            }
            let own = inside.iter().map(|p| self.volumes[p.volume].0.step);
            let step = self.step.unwrap_or_else(|| own.fold(f64::INFINITY, f64::min));
            let step = step / sight.length();
            let steps = ((to - from) / step).ceil().max(1.0) as u64;
            for i in 0..steps {
                let near = from + i as f64 * step;
                let far = if i + 1 < steps { from + (i + 1) as f64 * step } else { to };
                if let Some(sample) = self.sample(&inside, [near, far], sight.length())
                    && !take(sample)
                {
                    return;
                }
            }
        }
    }

    /// What is in the middle of a step, if it stops light.
    fn sample(&self, inside: &[Passage], [near, far]: [f64; 2], length: f64) -> Option<Slab> {
        let middle = near + (far - near) * 0.5;
        let mut found: Option<(Visibility, f64)> = None;
        for Passage { volume, origin, direction, .. } in inside {
            let volume = self.volumes[*volume].0;
            let point = (*origin + *direction * middle).clamp(DVec3::ZERO, DVec3::ONE);
            let [r, g, b, opacity] = volume.at(point);
            let opacity = volume.opacity(opacity, (far - near) * length);
            if opacity > 0.0 {
                let color = [r, g, b].map(|c| c * opacity);
                let new = (Visibility { color, opacity }, opacity);
                found = Some(found.map_or(new, |old| (mix(old, new), old.1 + new.1)));
            }
        }
        let (visibility, sum) = found?;
        Some(Slab { near, far, visibility, sum, depth: 0, weight: 0.0 })
    }
}
