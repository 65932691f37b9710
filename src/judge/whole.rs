//! Hypotheses tested on a whole picture.
//!
//! A hypothesis is held against the right answer: it must be wrong at far fewer pixels. So it must explain the pixels that
//! differ, and must not contradict those that do not. First a sample of both is looked at, then all pixels, with those
//! hypotheses that are left.

use rayon::prelude::*;

use super::answer::{Answer, Entry, of};
use super::class::Class;
use super::rule::{Maker, Rule};
use super::variant::Variant;
use crate::image::Image;
use crate::num::random::Random;
use crate::render::Lists;
use crate::report::expected::near_edges;

/// Pixels of a sample, of those that differ and of those that do not.
const SAMPLE: usize = 2_048;

/// The most fragments of these, on average.
const FRAGMENTS: usize = 1 << 15;

/// Hypotheses that are tested on all pixels.
const TESTED: usize = 24;

/// A hypothesis may be wrong at one pixel for so many at which the right answer is.
const SINGLE: u64 = 4;

/// The same for one that is wrong in two ways, which is easier to find by chance.
const PAIR: u64 = 10;

/// A picture, and where it is not the right one.
#[derive(Clone, Copy)]
pub(super) struct Seen<'a> {
    pub(super) answer: &'a Answer<'a>,
    pub(super) picture: &'a Image,
    /// Steps of a channel that are rounding.
    pub(super) tolerance: u8,
}

/// A hypothesis that was tested on all pixels.
#[derive(Clone, Debug)]
pub(super) struct Tested {
    pub(super) rule: Rule,
    /// By pixel, whether it gives the picture there.
    pub(super) fits: Vec<bool>,
    /// Pixels at which the right answer is wrong, and this is right.
    pub(super) explains: u64,
    /// Pixels at which it is the other way round.
    pub(super) contradicts: u64,
    /// Pixels at which it is wrong.
    pub(super) wrong: u64,
}

/// What was found about the whole picture.
#[derive(Debug, Default)]
pub(super) struct Told {
    /// The hypothesis that holds; then those that cannot be told from it.
    pub(super) holds: Vec<Tested>,
    /// Its lists, if its coverage is another.
    pub(super) lists: Option<Lists<Entry>>,
    /// All that were tested on all pixels, by how many pixels are wrong.
    pub(super) tested: Vec<Tested>,
}

impl Seen<'_> {
    /// Whether two colours differ by more than rounding.
    fn is_apart(&self, color: [u8; 3], pixel: usize) -> bool {
        largest(color, self.picture.pixels[pixel]) > self.steps()
    }

    /// What a hypothesis may be off by.
    fn steps(&self) -> u8 {
        self.tolerance.max(1)
    }

    /// Whether a rule gives the picture at a pixel; where nothing is known, it does.
    fn fits(
        &self,
        maker: &Maker<'_>,
        lists: &Lists<Entry>,
        pixel: usize,
        scratch: &mut Vec<Entry>,
    ) -> bool {
        let size = [lists.width, lists.height];
        maker
            .rule
            .placement
            .source(pixel, size)
            .is_none_or(|source| !self.is_apart(maker.color(of(lists, source), scratch), pixel))
    }

    /// Test a rule on all pixels.
    pub(super) fn test(&self, rule: Rule, lists: &Lists<Entry>, differs: &[bool]) -> Tested {
        let maker = Maker::new(rule, self.answer);
        let fits: Vec<bool> = (0..differs.len())
            .into_par_iter()
            .with_min_len(1_024)
            .map_init(Vec::new, |scratch, pixel| self.fits(&maker, lists, pixel, scratch))
            .collect();
        let count = |of: fn(bool, bool) -> bool| {
            fits.iter().zip(differs).filter(|&(&fits, &differs)| of(fits, differs)).count() as u64
        };
        let explains = count(|fits, differs| fits && differs);
        let contradicts = count(|fits, differs| !fits && !differs);
        let wrong = count(|fits, _| !fits);
        Tested { rule, fits, explains, contradicts, wrong }
    }

    /// The best of `rules` by samples, in their order.
    fn promising(&self, rules: &[Rule], samples: &Samples) -> Vec<Rule> {
        let lists = &self.answer.lists;
        let score = |rule: &Rule| {
            let maker = Maker::new(*rule, self.answer);
            let mut scratch = Vec::new();
            let mut share = |pixels: &[usize]| {
                let wrong = pixels.iter().filter(|&&p| !self.fits(&maker, lists, p, &mut scratch));
                wrong.count() as f64 / pixels.len().max(1) as f64
            };
            let [differing, others] = [share(&samples.differing), share(&samples.others)];
            let [all_differing, all_others] = samples.of.map(|n| n as f64);
            differing + others * all_others / all_differing.max(1.0)
        };
        let scores: Vec<f64> = rules.par_iter().map(score).collect();
        let mut places: Vec<usize> = (0..rules.len()).filter(|&i| scores[i] <= 0.5).collect();
        places.sort_by(|&a, &b| scores[a].total_cmp(&scores[b]).then(a.cmp(&b)));
        places.truncate(TESTED);
        places.sort_unstable();
        places.into_iter().map(|i| rules[i]).collect()
    }

    /// Look for a hypothesis that explains the pixels marked in `differs`, of which there must be some. `differing` is how
    /// many pixels it is measured against.
    pub(super) fn tell(&self, differs: &[bool], differing: u64) -> Told {
        let own = &self.answer.lists;
        let mean = own.entries.len() / differs.len().max(1);
        let samples = Samples::new(differs, SAMPLE.min(FRAGMENTS / mean.max(1)));
        let mut singles = Rule::singles(self.answer);
        let faint = self.is_faint(differs);
        if faint {
            singles.retain(|rule| rule.class() == Class::Precision);
        }
        let mut told = Told::default();
        let all = |rules: &[Rule]| {
            let rules = self.promising(rules, &samples);
            rules.into_iter().map(|rule| self.test(rule, own, differs)).collect::<Vec<_>>()
        };
        told.tested = all(&singles);
        if told.settle(differing, SINGLE) || faint {
            return told;
        }
        for variant in self.variants(differs) {
            let lists = variant.lists(self.answer.scene, &self.answer.options, &self.answer.front);
            let rule = Rule { coverage: Some(variant), ..Rule::default() };
            told.tested.push(self.test(rule, &lists, differs));
            if told.settle(differing, SINGLE) {
                told.lists = Some(lists);
                return told;
            }
        }
        told.tested.extend(all(&Rule::pairs(&singles)));
        told.settle(differing, PAIR);
        told
    }

    /// Whether all that differs is so little that many hypotheses come as near.
    fn is_faint(&self, differs: &[bool]) -> bool {
        let exact = &self.answer.picture.pixels;
        let by = |pixel: usize| {
            let [r, g, b, _] = exact[pixel];
            largest([r, g, b], self.picture.pixels[pixel])
        };
        (0..differs.len()).all(|pixel| !differs[pixel] || by(pixel) <= faint(self.steps()))
    }

    /// Other coverages that may explain what differs. Moving by half a pixel changes much of what lies along edges.
    fn variants(&self, differs: &[bool]) -> Vec<Variant> {
        let answer = self.answer;
        let size = answer.scene.size;
        let (mut near, mut crossed) = (vec![false; differs.len()], vec![false; differs.len()]);
        near_edges(&answer.front, size, CROSSED, |_, pixel| crossed[pixel] = true);
        near_edges(&answer.front, size, NEAR, |_, pixel| near[pixel] = true);
        let count = |of: &dyn Fn(usize) -> bool| (0..differs.len()).filter(|&p| of(p)).count();
        let differing = count(&|p| differs[p]);
        let along = 2 * count(&|p| differs[p] && near[p]) >= differing;
        let across = 2 * count(&|p| differs[p] && crossed[p]) >= differing;
        let much = across && 16 * differing >= count(&|p| crossed[p]);
        let variants = Variant::all(&answer.options).into_iter();
        let wanted = |variant: &Variant| match variant {
            Variant::Moved(_) => much,
            Variant::BottomRight | Variant::Bits(_) => along,
            Variant::BothFaces => true,
        };
        variants.filter(wanted).collect()
    }
}

/// An edge at most so far from a pixel's centre, in pixels, may pass through the pixel.
pub(super) const CROSSED: f64 = 0.707_2;

/// See [`crate::report::expected::EDGE_DISTANCE`].
const NEAR: f64 = crate::report::expected::EDGE_DISTANCE;

impl Told {
    /// Find the hypothesis that holds, if any of those tested does.
    fn settle(&mut self, differing: u64, factor: u64) -> bool {
        self.tested.sort_by_key(|tested| tested.wrong);
        let Some(best) = self.tested.first().filter(|best| best.wrong * factor <= differing) else {
            return false;
        };
        let alike = |tested: &&Tested| tested.fits == best.fits;
        self.holds = self.tested.iter().filter(alike).cloned().collect();
        true
    }
}

/// Pixels to look at first.
struct Samples {
    differing: Vec<usize>,
    others: Vec<usize>,
    /// How many there are of each.
    of: [usize; 2],
}

impl Samples {
    fn new(differs: &[bool], most: usize) -> Self {
        let mut random = Random::new(0, 0);
        // One out of every so many, since a fixed step may only meet certain columns.
        let mut pick = |differing| {
            let all: Vec<usize> = (0..differs.len()).filter(|&p| differs[p] == differing).collect();
            let step = all.len().div_ceil(most.max(1)).max(1);
            let some = all.chunks(step).map(|part| part[random.below(part.len() as u64) as usize]);
            (some.collect::<Vec<_>>(), all.len())
        };
        let [(differing, a), (others, b)] = [pick(true), pick(false)];
        Self { differing, others, of: [a, b] }
    }
}

/// Up to so many steps, a difference is too little to tell its cause, where rounding may be `steps`: leaving out or moving
/// whatever does not matter has that much of an effect.
pub(super) fn faint(steps: u8) -> u8 {
    steps.saturating_mul(2).saturating_add(1)
}

/// The largest difference of red, green or blue.
pub(super) fn largest(color: [u8; 3], pixel: [u8; 4]) -> u8 {
    color.iter().zip(pixel).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}
