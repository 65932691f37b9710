//! Pixel by pixel: what is left when a hypothesis about the whole picture has been taken for true, or none has.

pub(super) mod cause;
pub(super) mod edge;

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::answer::{Entry, of};
use super::class::Class;
use super::rule::Maker;
use super::whole::{CROSSED, Seen, faint, largest};
use crate::render::Lists;
use cause::{Cause, Look};
use edge::{Near, fragments, toggled};

/// What a pixel may differ by, and how near is near.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// Pixels from a centre to an edge.
    pub(super) edge: f64,
    /// Depth, 0 to 1, between two fragments.
    pub(super) depth: f64,
}

/// What was found at the pixels that are left.
#[derive(Debug, Default)]
pub(super) struct Left {
    /// By pixel in the order given: its class, and its cause, if it has one.
    pub(super) classes: Vec<(Class, Option<Cause>)>,
}

/// What one pixel allows, before all are counted.
struct Allowed {
    /// [`Class::Edge`], [`Class::Tie`], or none of them.
    near: Option<Class>,
    causes: Vec<Cause>,
    /// Too little differs for a cause of its own.
    faint: bool,
    /// If no cause is found.
    otherwise: Class,
}

impl Seen<'_> {
    /// Explain `pixels`, at which `maker`, with its `lists`, does not give the picture.
    pub(super) fn explain(
        &self,
        maker: &Maker<'_>,
        lists: &Lists<Entry>,
        limits: Limits,
        pixels: &[usize],
    ) -> Left {
        let size = self.answer.scene.size;
        let sources: Vec<Option<usize>> =
            pixels.iter().map(|&p| maker.rule.placement.source(p, size)).collect();
        let mut is_source = vec![false; lists.offsets.len() - 1];
        sources.iter().flatten().for_each(|&source| is_source[source] = true);
        let near = Near::new(self.answer, limits.edge, |p| is_source[p]);
        let crossed = Near::new(self.answer, CROSSED, |p| is_source[p]);
        let one = |scratch: &mut [Vec<Entry>; 2], (&pixel, source): (&usize, &Option<usize>)| {
            let nothing = Allowed {
                near: None,
                causes: Vec::new(),
                faint: false,
                otherwise: Class::Unexplained,
            };
            let Some(source) = *source else { return nothing };
            let edges =
                [&near, &crossed].map(|near| fragments(self.answer, source, near.of(source)));
            self.allowed(maker, of(lists, source), &edges, limits, pixel, scratch)
        };
        let allowed: Vec<Allowed> = pixels
            .par_iter()
            .zip(&sources)
            .with_min_len(64)
            .map_init(Default::default, one)
            .collect();
        Left { classes: settle(&allowed) }
    }

    fn allowed(
        &self,
        maker: &Maker<'_>,
        list: &[Entry],
        [near, crossed]: &[Vec<Entry>; 2],
        limits: Limits,
        pixel: usize,
        scratch: &mut [Vec<Entry>; 2],
    ) -> Allowed {
        let picture = self.picture.pixels[pixel];
        let steps = self.tolerance.max(1);
        let seen = |color| largest(color, picture) <= steps;
        let look = Look { answer: self.answer, maker, list, seen: &seen };
        let format = self.answer.options.record().depth;
        let is_near = |a: &Entry, b: &Entry| {
            (format.decode(a.depth) - format.decode(b.depth)).abs() <= limits.depth
        };
        let by = largest(maker.color(list, &mut scratch[0]), picture);
        let faint = by <= faint(steps);
        let at_edge =
            !near.is_empty() && toggled(list, near, |list| look.gives(list, &mut scratch[1]));
        let near_class = match () {
            () if at_edge => Some(Class::Edge),
            () if look.tied(scratch, is_near) => Some(Class::Tie),
            () => None,
        };
        let causes = match near_class {
            Some(Class::Edge) => look.missing(scratch),
            Some(_) => Vec::new(),
            None => look.causes(scratch),
        };
        let otherwise = match () {
            () if near_class.is_some() || (!causes.is_empty() && !faint) => Class::Unexplained,
            () if !faint && look.any_order(scratch) => Class::Order,
            () if self.is_between(maker, list, crossed, pixel, scratch) => Class::Partial,
            () if faint => Class::Faint,
            () => Class::Unexplained,
        };
        Allowed { near: near_class, causes, faint, otherwise }
    }

    /// Whether what is seen lies between what it would be with and without what has an edge through the pixel.
    fn is_between(
        &self,
        maker: &Maker<'_>,
        list: &[Entry],
        crossed: &[Entry],
        pixel: usize,
        scratch: &mut [Vec<Entry>; 2],
    ) -> bool {
        if crossed.is_empty() {
            return false;
        }
        let (mut least, mut most) = ([u8::MAX; 3], [0; 3]);
        toggled(list, crossed, |list| {
            for (c, value) in maker.color(list, &mut scratch[1]).into_iter().enumerate() {
                least[c] = least[c].min(value);
                most[c] = most[c].max(value);
            }
            false
        });
        let steps = self.tolerance.max(1);
        (0..3).all(|c| {
            let value = self.picture.pixels[pixel][c];
            value >= least[c].saturating_sub(steps) && value <= most[c].saturating_add(steps)
        })
    }
}

/// One class for each pixel. Of several causes that are possible, the one that is possible at most pixels is taken; and
/// what differs too little for a cause of its own, or lies at an edge, may have one that was found elsewhere.
fn settle(allowed: &[Allowed]) -> Vec<(Class, Option<Cause>)> {
    let mut votes: BTreeMap<Cause, u64> = BTreeMap::new();
    for pixel in allowed.iter().filter(|pixel| !pixel.faint && pixel.near.is_none()) {
        for &cause in &pixel.causes {
            *votes.entry(cause).or_default() += 1;
        }
    }
    let votes = |cause: &Cause| votes.get(cause).copied().unwrap_or(0);
    let one = |pixel: &Allowed| {
        // The first of the best.
        let best = pixel.causes.iter().rev().max_by_key(|cause| votes(cause));
        let best = best.filter(|cause| votes(cause) > 0);
        match (best, pixel.near) {
            (Some(cause), _) => (cause.class(), Some(*cause)),
            (None, Some(class)) => (class, None),
            (None, None) => (pixel.otherwise, None),
        }
    };
    allowed.iter().map(one).collect()
}
