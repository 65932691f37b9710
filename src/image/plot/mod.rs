//! Curves with common axes, as an SVG drawing (plain text) and as a picture: the same bytes everywhere.

mod shapes;

use super::drawing::look::{Ink, LETTER, LINE, SERIES};

/// Where a line ends and another of the same curve begins.
pub const GAP: [f64; 2] = [f64::NAN; 2];

/// A line through points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// What it is.
    pub name: String,
    /// (x, y), in the order in which they are joined. What follows a [`GAP`] is a line of its own.
    pub points: Vec<[f64; 2]>,
    /// How it is drawn.
    pub stroke: Stroke,
}

impl Curve {
    /// Without points.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), ..Self::default() }
    }

    /// Add a rectangle, as a line of its own.
    pub fn rectangle(&mut self, [left, right]: [f64; 2], [low, high]: [f64; 2]) {
        let first = (!self.points.is_empty()).then_some(GAP);
        let corners = [[left, low], [left, high], [right, high], [right, low], [left, low]];
        self.points.extend(first.into_iter().chain(corners));
    }

    /// Its lines.
    fn lines(&self) -> impl Iterator<Item = &[[f64; 2]]> {
        self.points.split(|point| point[0].is_nan())
    }
}

/// How a curve is drawn. Its colour and its gaps follow from its place among the others.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stroke {
    /// Without gaps, as long as there are colours.
    #[default]
    Plain,
    /// Wide and grey, to be seen beneath others that coincide with it.
    Wide,
    /// With gaps, through which others show that coincide with it.
    Over,
    /// Plain, with a mark at every point: one point alone is seen, too.
    Marked,
}

/// Curves with common axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// The title above the drawing.
    pub title: String,
    /// The horizontal axis, with its unit.
    pub x: &'static str,
    /// The vertical axis, with its unit; it begins at 0.
    pub y: &'static str,
    /// The curves; later ones lie over earlier ones.
    pub curves: Vec<Curve>,
}

const SIZE: [f64; 2] = [720.0, 440.0];
const LEFT: f64 = 70.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 50.0;
const BOTTOM: f64 = 60.0;
/// From the legend's left edge to its names: a stroke of the curve stands before each.
const SAMPLE: f64 = 30.0;
/// The edge of a mark.
const MARK: f64 = 6.0;
/// Lengths of strokes and gaps in turn. There are as many as have no factor in common with the colours, so that every
/// pair of both comes up.
const DASHES: [&[u32]; 4] = [&[], &[9, 5], &[3, 4], &[12, 4, 3, 4]];

/// What a curve looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Style {
    ink: Ink,
    width: u32,
    /// Of [`DASHES`].
    dashes: &'static [u32],
    /// A mark at every point.
    marked: bool,
}

impl Plot {
    /// The curves with their styles.
    fn styled(&self) -> impl Iterator<Item = (&Curve, Style)> {
        let mut place = 0;
        self.curves.iter().map(move |curve| {
            let turn = match curve.stroke {
                Stroke::Wide => {
                    let (ink, width, dashes) = (Ink::Beneath, 7, &[][..]);
                    return (curve, Style { ink, width, dashes, marked: false });
                }
                Stroke::Plain | Stroke::Marked => place / SERIES,
                Stroke::Over => place,
            };
            let ink = Ink::Series(place % SERIES);
            place += 1;
            let (dashes, marked) = (DASHES[turn % DASHES.len()], curve.stroke == Stroke::Marked);
            (curve, Style { ink, width: 2, dashes, marked })
        })
    }

    fn axes(&self) -> Axes {
        let all = || self.curves.iter().flat_map(Curve::lines).flatten();
        let of = |axis: usize| all().map(move |point| point[axis]);
        let (low, high) = (of(0).fold(f64::MAX, f64::min), of(0).fold(f64::MIN, f64::max));
        let x = if low <= high { Axis::new(low, high) } else { Axis::new(0.0, 1.0) };
        Axes { x, y: Axis::new(0.0, of(1).fold(0.0, f64::max)) }
    }
}

impl Plot {
    /// Where the legend's first name stands: at the top left, or at the bottom right if a curve passes there and none
    /// passes here.
    fn legend(&self, axes: &Axes) -> [f64; 2] {
        let longest = self.curves.iter().map(|curve| curve.name.chars().count()).max();
        let size = [
            SAMPLE + LETTER[0] * longest.unwrap_or(0) as f64,
            LINE * (self.curves.len() as f64 + 0.5),
        ];
        let top_left = [LEFT + 12.0, TOP];
        let bottom_right = [SIZE[0] - RIGHT - 12.0 - size[0], SIZE[1] - BOTTOM - 10.0 - size[1]];
        let is_free = |[left, top]: [f64; 2]| {
            let passes = |pair: &[[f64; 2]]| {
                let [from, to] = [axes.place(pair[0]), axes.place(pair[1])];
                let apart = |axis: usize, low: f64| {
                    from[axis].max(to[axis]) < low || from[axis].min(to[axis]) > low + size[axis]
                };
                !apart(0, left) && !apart(1, top)
            };
            let mut lines = self.curves.iter().flat_map(Curve::lines);
            let mut marked = self.curves.iter().filter(|curve| curve.stroke == Stroke::Marked);
            !lines.any(|points| points.windows(2).any(passes))
                && !marked.any(|curve| curve.points.iter().any(|&point| passes(&[point, point])))
        };
        let [left, top] =
            if is_free(top_left) || !is_free(bottom_right) { top_left } else { bottom_right };
        [left, top + 16.0]
    }
}

/// Both axes.
struct Axes {
    x: Axis,
    y: Axis,
}

impl Axes {
    /// Where a point lies on the drawing.
    fn place(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let across = LEFT + self.x.part(x) * (SIZE[0] - LEFT - RIGHT);
        [across, SIZE[1] - BOTTOM - self.y.part(y) * (SIZE[1] - TOP - BOTTOM)]
    }
}

/// Ticks of an axis, whatever its range is.
const MOST_STEPS: u32 = 20;

/// A range that begins and ends at its ticks.
struct Axis {
    low: f64,
    step: f64,
    steps: u32,
}

impl Axis {
    fn new(low: f64, high: f64) -> Self {
        let span = if high > low { high - low } else { 1.0 };
        // About six steps, of 1, 2 or 5 times a power of ten.
        let mut step = 1e-6;
        for factor in [2.0, 2.5, 2.0].iter().cycle() {
            if span / step <= 8.0 || step > 1e300 {
                break;
            }
            step *= factor;
        }
        let first = (low / step + 1e-9).floor();
        let last = ((high.max(low + span * 1e-9)) / step - 1e-9).ceil();
        Self { low: first * step, step, steps: ((last - first) as u32).clamp(1, MOST_STEPS) }
    }

    fn part(&self, value: f64) -> f64 {
        (value - self.low) / (self.step * f64::from(self.steps))
    }

    /// A tick's number, with as many decimals as its distance from the next needs, at least two; without zeroes at its
    /// end.
    fn number(&self, value: f64) -> String {
        let mut decimals = 2;
        let mut unit = 0.01;
        while unit > self.step * 1.001 {
            decimals += 1;
            unit /= 10.0;
        }
        let text = format!("{value:.decimals$}");
        let text = text.trim_end_matches('0').trim_end_matches('.');
        if text.is_empty() || text == "-0" { "0".to_owned() } else { text.to_owned() }
    }

    fn ticks(&self) -> impl Iterator<Item = f64> + '_ {
        (0..=self.steps).map(|i| self.low + f64::from(i) * self.step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_begin_and_end_at_ticks() {
        for (low, high) in [(0.0, 1.0), (20.0, 95.0), (0.0, 32.7), (0.0, 0.0), (3.0, 1e6)] {
            let axis = Axis::new(low, high);
            let ticks: Vec<f64> = axis.ticks().collect();
            assert!((2..=12).contains(&ticks.len()), "{low} {high}: {ticks:?}");
            assert!(ticks[0] <= low && ticks[ticks.len() - 1] >= high, "{low} {high}: {ticks:?}");
            assert!((axis.part(ticks[0])).abs() < 1e-9);
            assert!((axis.part(ticks[ticks.len() - 1]) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn a_plot_names_its_parts() {
        let mut curve = Curve::new("a < b");
        curve.points = vec![[0.0, 1.0], [2.0, 3.0]];
        let plot = Plot { title: "title".to_owned(), x: "across", y: "up", curves: vec![curve] };
        let svg = plot.svg();
        for part in ["<svg", "title", "across", "up", "a &lt; b", "<polyline", "</svg>"] {
            assert!(svg.contains(part), "{part}");
        }
        assert!(Plot::default().svg().contains("</svg>"), "also without points");
    }

    #[test]
    fn a_gap_ends_a_line() {
        let mut curve = Curve::new("two lines");
        curve.points = vec![[0.0, 1.0], [1.0, 1.0], GAP, [2.0, 3.0], [3.0, 3.0]];
        let title = "title".to_owned();
        let plot = Plot { title, x: "across", y: "up", curves: vec![curve.clone()] };
        let svg = plot.svg();
        assert_eq!(svg.matches("<polyline").count(), 2);
        assert!(!svg.contains("NaN"), "{svg}");
        curve.points.remove(2);
        assert_ne!(plot.draw(), Plot { curves: vec![curve], ..plot.clone() }.draw());
    }

    #[test]
    fn a_point_alone_is_seen_if_it_is_marked() {
        let curve = |stroke| Curve { points: vec![[1.0, 1.0]], stroke, ..Curve::new("alone") };
        let plot = |stroke| Plot { curves: vec![curve(stroke)], ..Plot::default() };
        let [plain, marked] = [Stroke::Plain, Stroke::Marked].map(plot);
        assert_eq!(plain.svg().matches("<rect").count() + 1, marked.svg().matches("<rect").count());
        let colored = |plot: &Plot| {
            let pixels = plot.draw().pixels;
            pixels.iter().filter(|pixel| pixel[..3] == Ink::Series(0).color(false)).count()
        };
        assert_eq!(colored(&plain) + 12 * 12, colored(&marked));
    }

    #[test]
    fn ticks_that_are_close_have_the_decimals_that_tell_them_apart() {
        for (low, high) in [(3.214, 3.2147), (0.0, 2.0), (1e-6, 5e-6), (-0.004, 0.001)] {
            let axis = Axis::new(low, high);
            let mut texts: Vec<String> = axis.ticks().map(|tick| axis.number(tick)).collect();
            let count = texts.len();
            texts.dedup();
            assert_eq!(texts.len(), count, "{texts:?}");
        }
        assert_eq!(Axis::new(0.0, 1.0).number(0.5), "0.5");
        assert_eq!(Axis::new(0.0, 0.07).number(0.07), "0.07");
    }

    #[test]
    fn no_range_has_too_many_ticks() {
        for (low, high) in [(0.0, 1e300), (1e18, 1e18 + 1.0), (0.0, f64::MAX), (-1e30, 1e30)] {
            assert!(Axis::new(low, high).ticks().count() <= 21, "{low} {high}");
        }
    }

    #[test]
    fn styles_differ() {
        let curves = (0..28).map(|i| Curve::new(&i.to_string())).collect();
        let mut plot = Plot { curves, ..Plot::default() };
        for stroke in [Stroke::Plain, Stroke::Over] {
            plot.curves.iter_mut().for_each(|curve| curve.stroke = stroke);
            let styles: Vec<Style> = plot.styled().map(|(_, style)| style).collect();
            for (i, style) in styles.iter().enumerate() {
                assert!(!styles[..i].contains(style), "{stroke:?} {i}");
            }
        }
    }

    /// A curve that rises at once passes the top left, one that rises late the bottom right.
    #[test]
    fn the_legend_stands_where_no_curve_passes() {
        let plot = |points: [[f64; 2]; 3]| {
            let curve = Curve { points: points.to_vec(), ..Curve::new("curve") };
            Plot { curves: vec![curve], ..Plot::default() }
        };
        let legend = |plot: &Plot| plot.legend(&plot.axes());
        let late = legend(&plot([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]));
        let early = legend(&plot([[0.0, 0.0], [0.0, 1.0], [1.0, 1.0]]));
        assert!(late[0] < 100.0 && late[1] < 100.0, "{late:?}");
        assert!(early[0] > 600.0 && early[1] > 350.0, "{early:?}");
    }
}
