//! Normals and radii from neighbours.
//!
//! Points at the same place count once. The neighbours of a point are the [`NEIGHBOURS`] others nearest to it, by
//! distance and then by place in the order of coordinates, so that they depend on nothing but the places. The normal is
//! the direction in which they and the point vary least: the eigenvector of the smallest eigenvalue of their
//! covariance. It is turned away from the middle of the whole set. The radius is [`REACH`] times the distance to the
//! [`RING`]th neighbour (or the last, if there are fewer), but at most [`LARGEST`] times the median of them all, so that
//! a stray point does not become a large one. All sums are f64 in the order of the neighbours.

use std::cmp::Ordering;

use glam::DVec3;
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::eigen;

/// Neighbours that make the normal.
const NEIGHBOURS: usize = 12;

/// Which neighbour makes the radius.
const RING: usize = 6;

/// On a square grid the sixth neighbour is at the diagonal, 1.41 steps: discs that touch no hole need at least 0.77.
const REACH: f64 = 0.75;

/// The largest radius in medians.
const LARGEST: f64 = 4.0;

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
    pub(super) fn new(positions: &[[f32; 3]]) -> Self {
        let wide = |i: u32| positions[i as usize].map(f64::from);
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
            let near = neighbours(&tree, *at, number as u32);
            let spread: Vec<DVec3> = near
                .iter()
                .map(|&(_, other)| DVec3::from(places[other as usize]) - DVec3::from(*at))
                .collect();
            let normal = normal(&spread, DVec3::from(*at) - middle);
            let ring = near.get(RING - 1).or(near.last());
            (normal, ring.map(|&(square, _)| square.sqrt() * REACH))
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

/// The squared distances and numbers of the places nearest to one of them, in order.
fn neighbours(tree: &RTree<Place>, at: [f64; 3], own: u32) -> Vec<(f64, u32)> {
    let mut near: Vec<(f64, u32)> = Vec::with_capacity(NEIGHBOURS + 4);
    for (place, square) in tree.nearest_neighbor_iter_with_distance_2(at) {
        // All that are as far as the last one wanted, to choose among them by number.
        if near.len() >= NEIGHBOURS && near.last().is_some_and(|last| square > last.0) {
            break;
        }
        if place.data != own {
            near.push((square, place.data));
        }
    }
    near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    near.truncate(NEIGHBOURS);
    near
}

/// The direction in which a point (at 0) and its neighbours vary least, on the side of `outwards`.
fn normal(neighbours: &[DVec3], outwards: DVec3) -> DVec3 {
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
    let normal = eigen::least(covariance);
    if normal.dot(outwards) < 0.0 { -normal } else { normal }
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
