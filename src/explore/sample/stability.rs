//! The stability matrix, derived: what each method's result was observed to depend on.
//!
//! Every method draws three small scenes: one with distinct depths, one with coplanar layers of different colours, and
//! one with more layers than a method with limited room was configured for. Each is drawn with its triangles in many
//! orders, one invocation after another; and in one order under many schedules of the simulated device. A difference is
//! an *observed* dependence. No difference means that none was observed in this many runs, which proves nothing
//! (`fragloom check` may).

use rayon::prelude::*;
use serde::Serialize;

use crate::catalogue::Catalogue;
use crate::error::Result;
use crate::exec::Method;
use crate::num::random::Random;
use crate::render::{Exec, Kept, Options, Policy, Rendering, Report, Sim, TableOptions, render};
use crate::scene::{self, Overrides, Scene, Thickness};
use crate::scheme::Light;
use crate::scheme::contract::{Extra, Keeps};

/// What was observed of one method.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stability {
    /// The method.
    pub method: &'static str,
    /// Its result depended on the order of triangles, with distinct depths and enough room.
    pub arrival: bool,
    /// It did so with equal depths.
    pub arrival_at_ties: bool,
    /// It did so when fragments found no room.
    pub arrival_at_overflow: bool,
    /// That room is a pool of the frame, and not the method's own limit.
    pub pooled: bool,
    /// Some schedule lost, doubled or tore fragments that sequential execution keeps, or other fragments than it does.
    pub schedule: bool,
    /// Even in sequential execution, some fragments of equal depth were confused or lost.
    pub inexact_at_ties: bool,
    /// The largest difference that the order of triangles made to a channel of a pixel, 0 to 1: of linear light, if the
    /// method gives colours, else of the picture.
    pub spread: f64,
    /// Runs behind this row.
    pub runs: usize,
    /// What its contract says: depends on arrival; is racy.
    pub declared: [bool; 2],
}

impl Stability {
    /// Whether the observations match what the contract declares. A pool that is too small does not count: any method
    /// then drops by arrival. For a racy method that declares a dependence on arrival, an observed dependence on the
    /// schedule is enough: a schedule is also an order of arrival.
    #[must_use]
    pub fn agrees(&self) -> bool {
        let overflow = self.arrival_at_overflow && !self.pooled;
        let arrival = self.arrival || self.arrival_at_ties || overflow;
        let [by_arrival, racy] = self.declared;
        self.schedule == racy && (arrival == by_arrival || (racy && by_arrival))
    }
}

/// Pixels on each side: few, so that invocations meet.
const EDGE: u32 = 6;

/// Layers of a scene.
const LAYERS: u32 = 24;

/// k, or slots if a method is to overflow.
const K: u32 = 4;

/// Load of hash tables, in per cent.
const LOAD: u32 = 90;

/// Orders of triangles to try.
const ORDERS: u64 = 6;

/// Seeds of each policy.
const SEEDS: u64 = 6;

/// Derive the rows of all methods of a catalogue except the built-in faults.
///
/// # Errors
/// A scene that cannot be drawn: a defect.
pub fn derive(catalogue: &Catalogue) -> Result<Vec<Stability>> {
    let methods: Vec<Method> = catalogue.promised().collect();
    methods.into_par_iter().map(derive_one).collect()
}

/// Derive a method's row.
///
/// # Errors
/// See [`derive()`].
pub fn derive_one(method: Method) -> Result<Stability> {
    let contract = method.contract();
    let size = Overrides { size: Some([EDGE, EDGE]), ..Overrides::default() };
    let distinct = scene::load(&format!("synthetic:n={LAYERS},density=100"), &size)?;
    let ties = coplanar(&distinct);
    let k = contract.default_k.map(|_| K);
    let mut runs = Runs { method, count: 0, spread: 0.0 };

    let arrival = runs.orders_differ(&distinct, k, None)?;
    let arrival_at_ties = runs.orders_differ(&ties, k, None)?;
    let limited = contract.is_pooled();
    // Where -k does not limit the room, three quarters of the bytes do.
    let (slots, budget) = match contract.keeps {
        Keeps::FirstArrivals => (Some(K), None),
        _ => (k, Some(runs.draw(&distinct, k, None, Exec::Tile)?.report.bytes / 4 * 3)),
    };
    let arrival_at_overflow = limited && runs.orders_differ(&distinct, slots, budget)?;

    let wrong = |r: &Report| r.duplicated + r.torn + r.dropped.get("lost").copied().unwrap_or(0);
    let mut schedule = false;
    let mut inexact_at_ties = false;
    for (scene, has_ties) in [(&distinct, false), (&ties, true)] {
        let alone = runs.draw(scene, k, None, Exec::Tile)?.report;
        let confused = wrong(&alone) > 0;
        inexact_at_ties |= has_ties && confused;
        for policy in [Policy::Random, Policy::RoundRobin, Policy::Warp(8), Policy::Pct(3)] {
            for seed in 0..SEEDS {
                let exec = simulated(policy.clone(), seed);
                let drawn = runs.draw(scene, k, None, exec)?.report;
                let other = drawn.fragments_hash != alone.fragments_hash;
                // Fragments confused in any case may be confused in several ways.
                schedule |= wrong(&drawn) > wrong(&alone) || (confused && other);
            }
        }
    }
    Ok(Stability {
        method: contract.name,
        arrival,
        arrival_at_ties,
        arrival_at_overflow,
        pooled: contract.keeps != Keeps::FirstArrivals,
        schedule,
        inexact_at_ties,
        spread: runs.spread,
        runs: runs.count,
        declared: [contract.is_arrival_dependent(), contract.is_racy()],
    })
}

struct Runs {
    method: Method,
    count: usize,
    spread: f64,
}

impl Runs {
    fn draw(
        &mut self,
        scene: &Scene,
        k: Option<u32>,
        memory_budget: Option<u64>,
        exec: Exec,
    ) -> Result<Rendering> {
        self.count += 1;
        let options = Options {
            method: self.method,
            k,
            exec,
            threads: 1,
            // So that the picture is most of what memory is allocated for.
            tile: 16,
            counters: false,
            // So full that insertions often displace records.
            table: TableOptions {
                load: memory_budget.is_none().then_some(LOAD),
                ..TableOptions::default()
            },
            memory_budget,
            // One and a half layers of these scenes, so that slabs form chains.
            thickness: Thickness::Precision(1e6),
            ..Options::default()
        };
        render(scene, &options)
    }

    /// Whether what pixels hold differs between orders of triangles, one invocation after another. Where fragments are
    /// known by their triangle's number, that number must stay: then orders are those of invocations.
    fn orders_differ(
        &mut self,
        scene: &Scene,
        k: Option<u32>,
        memory_budget: Option<u64>,
    ) -> Result<bool> {
        let first = self.draw(scene, k, memory_budget, Exec::Tile)?;
        let mut differ = false;
        for seed in 0..ORDERS {
            let mut other = scene.clone();
            let mut exec = Exec::Tile;
            if self.method.contract().extra == Extra::Primitive {
                exec = simulated(Policy::Random, seed);
            } else {
                Random::new(seed, 0x0DE5).shuffle(&mut other.screen);
            }
            let drawn = self.draw(&other, k, memory_budget, exec)?;
            differ |= drawn.kept != first.kept || drawn.image != first.image;
            self.spread = self.spread.max(spread(&drawn, &first));
        }
        Ok(differ)
    }
}

/// The largest difference of a channel.
fn spread(a: &Rendering, b: &Rendering) -> f64 {
    let largest = |apart: &mut dyn Iterator<Item = f64>| apart.fold(0.0, f64::max);
    match (&a.kept, &b.kept) {
        (Kept::Color(a), Kept::Color(b)) => {
            let of = |light: &Light| [light.color.as_slice(), &[light.transmittance]].concat();
            largest(
                &mut a.iter().flat_map(of).zip(b.iter().flat_map(of)).map(|(a, b)| (a - b).abs()),
            )
        }
        _ => {
            let bytes = a.image.pixels.iter().flatten().zip(b.image.pixels.iter().flatten());
            largest(&mut bytes.map(|(a, b)| f64::from(a.abs_diff(*b)) / 255.0))
        }
    }
}

fn simulated(policy: Policy, seed: u64) -> Exec {
    Exec::Sim(Sim { policy, seed, resident: 192, record: false, watch: None, check: false })
}

/// The same scene with every three neighbouring layers at the depth of the nearest of them.
fn coplanar(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    let mut depths: Vec<f64> = scene.screen.iter().map(|t| t.points[0][2]).collect();
    depths.sort_by(f64::total_cmp);
    depths.dedup();
    for triangle in &mut scene.screen {
        let layer = depths.partition_point(|&z| z < triangle.points[0][2]);
        let z = depths[layer / 3 * 3];
        triangle.points.iter_mut().for_each(|point| point[2] = z);
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue::method;

    #[test]
    fn every_three_layers_share_a_depth() {
        let size = Overrides { size: Some([4, 4]), ..Overrides::default() };
        let scene = coplanar(&scene::load("synthetic:n=7,density=100", &size).expect("a scene"));
        let mut depths: Vec<f64> = scene.screen.iter().map(|t| t.points[0][2]).collect();
        depths.sort_by(f64::total_cmp);
        depths.dedup();
        assert_eq!(depths.len(), 3);
    }

    /// The derivation can see each dependence, and the lack of it.
    #[test]
    fn known_methods_are_seen_as_they_are() {
        let seen = |name| derive_one(method(name).expect("known")).expect("drawn");
        let correct = seen("kplus-array");
        assert!(correct.agrees() && !correct.arrival_at_ties && !correct.schedule, "{correct:?}");
        let racy = seen("kb");
        assert!(racy.agrees() && racy.schedule && !racy.arrival_at_ties, "{racy:?}");
        let first = seen("ab-array");
        assert!(first.agrees() && first.arrival_at_overflow && !first.arrival, "{first:?}");
        let ties = seen("kplus-array@M9");
        assert!(ties.arrival_at_ties && !ties.arrival, "{ties:?}");
    }
}
