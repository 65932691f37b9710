//! Normals and radii from neighbours.
//!
//! Points at the same place count once. The neighbours of a point are the nearest others, by distance and then by place
//! in the order of coordinates, so that they depend on nothing but the places. There are as many as the first of
//! [`STAGES`] with which they surround the point: in the plane that it makes with them, each quarter has one. Scanners
//! sample a surface densely in one direction and sparsely in another; so few would often lie on one line.
//!
//! The normal is the direction in which the point and its neighbours vary least: the eigenvector of the smallest
//! eigenvalue of their covariance. It is turned away from the middle of the whole set. The radius is the distance to
//! the neighbour that completes the ring, so that discs reach each other on all sides: the first in the fourth quarter;
//! at a border, where there is none, in the third; else the [`CHAIN`]th neighbour, or the last. It is at most
//! [`LARGEST`] times the median of all, so that a stray point does not become a large one. All sums are f64 in the order
//! of the neighbours.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::{axes, eigen};

/// How many neighbours are looked at, one stage after another.
const STAGES: [usize; 3] = [12, 24, 48];

/// Which neighbour makes the radius on a line of points or at a corner.
const CHAIN: usize = 4;

/// The largest radius in medians: what one scan sees near and far differs by about ten.
const LARGEST: f64 = 16.0;

/// A place with its number in the order of coordinates.
type Place = GeomWithData<[f64; 3], u32>;

/// What the neighbourhoods of some points say.
pub(super) struct Estimate {
    /// By point, the number of its place.
    place: Vec<u32>,
    /// By place.
    normals: Vec<DVec3>,
    radii: Option<Vec<f64>>,
}

impl Estimate {
    /// Of finite positions.
    pub(super) fn new(positions: &[[f64; 3]]) -> Self {
        let wide = |i: u32| positions[i as usize];
        let mut order: Vec<u32> = (0..positions.len() as u32).collect();
        order.par_sort_unstable_by(|&a, &b| compare(&wide(a), &wide(b)).then(a.cmp(&b)));
        let mut places: Vec<[f64; 3]> = Vec::new();
        let mut place = vec![0; positions.len()];
        for &point in &order {
            if places.last() != Some(&wide(point)) {
                places.push(wide(point));
            }
            place[point as usize] = places.len() as u32 - 1;
        }
        let middle = middle(&places);
        let tree = RTree::bulk_load(
            places.iter().zip(0..).map(|(&at, number)| Place::new(at, number)).collect(),
        );
        let around = |(number, at): (usize, &[f64; 3])| {
            let (normal, radius) = surroundings(&tree, *at, number as u32);
            let outwards = DVec3::from(*at) - middle;
            (if normal.dot(outwards) < 0.0 { -normal } else { normal }, radius)
        };
        let found: Vec<_> = places.par_iter().enumerate().map(around).collect();
        let (normals, radii): (Vec<_>, Vec<_>) = found.into_iter().unzip();
        Self { place, normals, radii: radii.into_iter().collect::<Option<_>>().map(clamped) }
    }

    /// Of a point.
    pub(super) fn normal(&self, point: usize) -> DVec3 {
        self.normals[self.place[point] as usize]
    }

    /// Of all points; `None` if there is only one place.
    pub(super) fn radii(&self) -> Option<Vec<f64>> {
        let radii = self.radii.as_ref()?;
        Some(self.place.iter().map(|&place| radii[place as usize]).collect())
    }
}

/// By x, then y, then z. Zeros are equal.
fn compare(a: &[f64; 3], b: &[f64; 3]) -> Ordering {
    a.partial_cmp(b).unwrap_or(Ordering::Equal)
}

/// What the neighbours of a place say: the normal, and the radius if there are any.
fn surroundings(tree: &RTree<Place>, at: [f64; 3], own: u32) -> (DVec3, Option<f64>) {
    let mut others = tree.nearest_neighbor_iter_with_distance_2(at).peekable();
    let mut near: Vec<(f64, &Place)> = Vec::with_capacity(STAGES[0] + 4);
    let mut found = (DVec3::Z, None);
    for wanted in STAGES {
        // Also all that are as far as the last one wanted, to choose among them by number.
        while let Some((place, square)) = others
            .next_if(|next| near.len() < wanted || near.last().is_none_or(|last| next.1 <= last.0))
        {
            if place.data != own {
                near.push((square, place));
            }
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.data.cmp(&b.1.data)));
        let chosen = &near[..near.len().min(wanted)];
        let arms: Vec<DVec3> =
            chosen.iter().map(|(_, place)| DVec3::from(*place.geom()) - DVec3::from(at)).collect();
        let normal = normal(&arms);
        let Some((last, complete)) = ring(&arms, normal) else { break };
        found = (normal, Some(near[last].0.sqrt()));
        if complete {
            break;
        }
    }
    found
}

/// Which neighbour completes the ring around a point (at 0), and whether it is one.
fn ring(neighbours: &[DVec3], normal: DVec3) -> Option<(usize, bool)> {
    let [a, b] = axes(normal);
    let (mut met, mut quarters, mut third) = ([false; 4], 0, None);
    for (i, arm) in neighbours.iter().enumerate() {
        let (s, t) = (arm.dot(a), arm.dot(b));
        let quarter = if s > 0.0 && t >= 0.0 {
            0
        } else if s <= 0.0 && t > 0.0 {
            1
        } else if s < 0.0 {
            2
        } else if t < 0.0 {
            3
        } else {
            continue;
        };
        if !met[quarter] {
            met[quarter] = true;
            quarters += 1;
            match quarters {
                3 => third = Some(i),
                4 => return Some((i, true)),
                _ => {}
            }
        }
    }
    let last = neighbours.len().min(CHAIN).checked_sub(1)?;
    Some((third.unwrap_or(last), false))
}

/// The direction in which a point (at 0) and its neighbours vary least.
fn normal(neighbours: &[DVec3]) -> DVec3 {
    // Scaled to at most 1, so that no square leaves the range.
    let largest = neighbours.iter().map(|v| v.abs().max_element()).fold(0.0, f64::max);
    if largest == 0.0 {
        return DVec3::Z;
    }
    let scaled = || neighbours.iter().map(|&v| v / largest);
    let count = neighbours.len() as f64 + 1.0;
    let mean = scaled().fold(DVec3::ZERO, |sum, v| sum + v) / count;
    let mut covariance = [[0.0; 3]; 3];
    for v in std::iter::once(DVec3::ZERO).chain(scaled()) {
        let d = v - mean;
        for (i, row) in covariance.iter_mut().enumerate() {
            for (j, sum) in row.iter_mut().enumerate() {
                *sum += d[i] * d[j];
            }
        }
    }
    eigen::least(covariance)
}

/// Each at most [`LARGEST`] medians.
fn clamped(mut radii: Vec<f64>) -> Vec<f64> {
    let mut sorted = radii.clone();
    sorted.sort_unstable_by(f64::total_cmp);
    let largest = sorted[sorted.len() / 2] * LARGEST;
    radii.iter_mut().for_each(|radius| *radius = radius.min(largest));
    radii
}

/// The middle of the smallest box around all places.
fn middle(places: &[[f64; 3]]) -> DVec3 {
    let points = || places.iter().map(|&place| DVec3::from(place));
    let min = points().fold(DVec3::INFINITY, DVec3::min);
    let max = points().fold(DVec3::NEG_INFINITY, DVec3::max);
    min * 0.5 + max * 0.5
}
