//! Another renderer's picture, or the fragments that it dumped, against the exact answer; and why it differs.
//!
//! The exact list of fragments of every pixel is known. So what a picture would look like if something were wrong is a
//! function of those lists, and can be tried. First hypotheses about the whole picture are tested; then every pixel that
//! is left is looked at alone. A pixel gets one [`Class`].
//!
//! `docs/judge.md` says how each class is decided, and what cannot be told apart.

mod answer;
mod class;
mod culprit;
pub mod dump;
mod map;
mod pixel;
mod rule;
mod runs;
mod variant;
mod verdict;
mod whole;

use std::cmp::Reverse;

use crate::error::{Error, Result};
use crate::image::foreign::{Foreign, Opacity};
use crate::image::metrics::Metrics;
use crate::image::{Image, difference};
use crate::report::expected::{DEPTH_DISTANCE, EDGE_DISTANCE, near_edges};
use pixel::Limits;
use pixel::cause::Cause;
use rule::Maker;
use verdict::counted;
use whole::{Seen, Tested, Told};

pub use answer::{Answer, Entry};
pub use class::Class;
pub use map::map;
pub use runs::{Places, Runs, compare};
pub use verdict::{Counted, Culprit, Held, Verdict};

/// Hypotheses that did not hold and are told.
const TOLD: usize = 5;

/// What counts as the same, and as near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Steps of an 8-bit channel that are rounding, 0 or more.
    pub tolerance: u8,
    /// Pixels from a pixel's centre to an edge, where coverage may be decided otherwise, 0 to 1.
    pub edge_distance: f64,
    /// Depth, 0 to 1, between fragments whose order may be another.
    pub depth_distance: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { tolerance: 1, edge_distance: EDGE_DISTANCE, depth_distance: DEPTH_DISTANCE }
    }
}

impl Settings {
    fn limits(&self) -> Limits {
        Limits { edge: self.edge_distance, depth: self.depth_distance }
    }
}

/// By pixel, row by row: whether an edge passes at most `distance` pixels from its centre.
fn near_edge(answer: &Answer<'_>, distance: f64) -> Vec<bool> {
    let mut near = vec![false; answer.picture.pixels.len()];
    near_edges(&answer.front, answer.scene.size, distance, |_, pixel| near[pixel] = true);
    near
}

/// Judge a picture; `name` names it in messages.
///
/// # Errors
/// A picture of another size.
///
/// # Examples
/// ```
/// use fragloom::image::foreign::Foreign;
/// use fragloom::image::png;
/// use fragloom::judge::{Answer, Class, Settings, judge};
/// use fragloom::render::Options;
/// use fragloom::scene::{self, Overrides};
///
/// let scene = scene::load("cubes", &Overrides { size: Some([64, 48]), ..Overrides::default() })?;
/// let answer = Answer::new(&scene, &Options::default().exact(None))?;
///
/// // Another renderer's file, with the bottom row first.
/// let mut picture = answer.picture().clone();
/// picture.pixels = picture.pixels.chunks(64).rev().flatten().copied().collect();
/// let file = png::encode(&picture).expect("a picture");
///
/// let foreign = Foreign::parse(&file, 16_384).expect("a PNG file");
/// let verdict = judge(&answer, &foreign, "theirs.png", &Settings::default())?;
/// assert!(!verdict.right);
/// let held = verdict.hypothesis.expect("a hypothesis that holds");
/// assert_eq!((held.class, &held.as_if[..]), (Class::Placement, "the picture were upside down"));
/// # Ok::<(), fragloom::error::Error>(())
/// ```
pub fn judge(
    answer: &Answer<'_>,
    picture: &Foreign,
    name: &str,
    settings: &Settings,
) -> Result<Verdict> {
    let [width, height] = answer.scene.size;
    if picture.size != [width, height] {
        let [w, h] = picture.size;
        let problem =
            format!("is {w}x{h}, but {} is drawn at {width}x{height} (--size)", answer.scene.name);
        return Err(Error::new(name, problem));
    }
    let is_transparent = picture.is_transparent();
    let shown = picture.seen(answer.scene.background);
    let apart = difference::map(&answer.picture, &shown)?;
    let metrics = Metrics::measure(&answer.picture, &shown, settings.tolerance)?;
    let differs: Vec<bool> = apart.iter().map(|&apart| apart > settings.tolerance).collect();
    let differing = differs.iter().filter(|&&differs| differs).count() as u64;
    let mut map: Vec<Class> = apart
        .iter()
        .map(|&apart| if apart == 0 { Class::Equal } else { Class::Rounding })
        .collect();
    let mut story = Story { reading: None, told: Told::default() };
    let (mut culprits, mut warnings) = (Vec::new(), Vec::new());
    if differing > 0 {
        story = Story::of(answer, picture, &shown, settings, (&differs, differing))?;
        let (used, still) = match &story.reading {
            None => (&shown, differs.clone()),
            Some((_, other)) => {
                let apart = difference::map(&answer.picture, other)?;
                (other, apart.iter().map(|&apart| apart > settings.tolerance).collect())
            }
        };
        let rule = story.told.holds.first().map(|held| held.rule).unwrap_or_default();
        let seen = Seen { answer, picture: used, tolerance: settings.tolerance };
        let mut left = Vec::new();
        for pixel in (0..map.len()).filter(|&pixel| differs[pixel]) {
            let explained = story.told.holds.first().is_some_and(|held| held.fits[pixel]);
            match () {
                () if !still[pixel] => map[pixel] = Class::Opacity,
                () if explained => map[pixel] = rule.class(),
                () => left.push(pixel),
            }
        }
        let maker = Maker::new(rule, answer);
        let lists = story.told.lists.as_ref().unwrap_or(&answer.lists);
        let found = seen.explain(&maker, lists, settings.limits(), &left);
        let causes: Vec<(usize, Cause)> = left
            .iter()
            .zip(&found.classes)
            .filter_map(|(&pixel, (_, cause))| Some((pixel, (*cause)?)))
            .collect();
        for (&pixel, &(class, _)) in left.iter().zip(&found.classes) {
            map[pixel] = class;
        }
        culprits = culprit::of(answer, &maker, &causes);
    }
    if is_transparent {
        warnings.push(format!(
            "{name} is transparent: it was read as {} and laid over the background",
            match picture.opacity {
                Opacity::Straight => "straight",
                Opacity::Premultiplied => "premultiplied",
                Opacity::Ignored => "opaque, which --opacity says,",
            }
        ));
    }
    Ok(Verdict {
        picture: name.to_owned(),
        right: map.iter().all(|class| class.is_right()),
        metrics,
        opacity: if is_transparent { picture.opacity } else { Opacity::Ignored },
        classes: counted(&map, &apart, width),
        hypothesis: story.held(differing),
        tested: story.others(differing),
        culprits,
        warnings,
        map,
        apart,
        seen: shown,
    })
}

/// What explains the whole picture.
struct Story {
    /// Another reading of the picture's opacity, and what is seen then.
    reading: Option<(Opacity, Image)>,
    told: Told,
}

impl Story {
    fn of(
        answer: &Answer<'_>,
        picture: &Foreign,
        shown: &Image,
        settings: &Settings,
        (differs, differing): (&[bool], u64),
    ) -> Result<Self> {
        let seen = Seen { answer, picture: shown, tolerance: settings.tolerance };
        let told = seen.tell(differs, differing);
        if !told.holds.is_empty() || !picture.is_transparent() {
            return Ok(Self { reading: None, told });
        }
        let readings = [Opacity::Ignored, Opacity::Straight, Opacity::Premultiplied];
        for opacity in readings.into_iter().filter(|&opacity| opacity != picture.opacity) {
            let other = Foreign { opacity, ..picture.clone() }.seen(answer.scene.background);
            let apart = difference::map(&answer.picture, &other)?;
            let differs: Vec<bool> =
                apart.iter().map(|&apart| apart > settings.tolerance).collect();
            let left = differs.iter().filter(|&&differs| differs).count() as u64;
            if left * 4 <= differing {
                return Ok(Self { reading: Some((opacity, other)), told: Told::default() });
            }
            let seen = Seen { picture: &other, ..seen };
            let told = seen.tell(&differs, left);
            if told.holds.first().is_some_and(|held| held.wrong * 10 <= differing) {
                return Ok(Self { reading: Some((opacity, other)), told });
            }
        }
        Ok(Self { reading: None, told })
    }

    /// The hypothesis that holds.
    fn held(&self, differing: u64) -> Option<Held> {
        let reading = self.reading.as_ref().map(|(opacity, _)| match opacity {
            Opacity::Ignored => "opacity were to be ignored",
            Opacity::Straight => "colours were not multiplied by opacity",
            Opacity::Premultiplied => "colours were multiplied by opacity",
        });
        let Some(best) = self.told.holds.first() else {
            return reading.map(|as_if| Held {
                class: Class::Opacity,
                as_if: as_if.to_owned(),
                explains: differing,
                of: differing,
                contradicts: 0,
                or_as_if: Vec::new(),
            });
        };
        let others = self.told.holds[1..].iter().map(|held| held.rule.name()).collect();
        let held = Held { or_as_if: others, ..held(best, differing) };
        Some(match reading {
            None => held,
            Some(reading) => Held { as_if: format!("{reading}; and {}", held.as_if), ..held },
        })
    }

    /// Those that were tested and do not hold, but explain something.
    fn others(&self, differing: u64) -> Vec<Held> {
        let is_held = |tested: &&Tested| self.told.holds.iter().all(|h| h.rule != tested.rule);
        let mut others: Vec<&Tested> = self.told.tested.iter().filter(is_held).collect();
        others.retain(|tested| tested.explains > 0);
        others.sort_by_key(|tested| (tested.wrong, Reverse(tested.explains)));
        others.into_iter().take(TOLD).map(|tested| held(tested, differing)).collect()
    }
}

fn held(tested: &Tested, differing: u64) -> Held {
    Held {
        class: tested.rule.class(),
        as_if: tested.rule.name(),
        explains: tested.explains,
        of: differing,
        contradicts: tested.contradicts,
        or_as_if: Vec::new(),
    }
}
