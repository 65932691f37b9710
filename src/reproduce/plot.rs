//! Curves as an SVG drawing: plain text, the same bytes everywhere.

/// Where a line ends and another of the same curve begins.
pub const GAP: [f64; 2] = [f64::NAN; 2];

/// A line through points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// What it is.
    pub name: String,
    /// (x, y), in the order in which they are joined. What follows a [`GAP`] is a line of its own.
    pub points: Vec<[f64; 2]>,
}

impl Curve {
    /// Without points.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), points: Vec::new() }
    }
}

/// Curves with common axes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plot {
    /// The title above the drawing.
    pub title: &'static str,
    /// The horizontal axis, with its unit.
    pub x: &'static str,
    /// The vertical axis, with its unit; it begins at 0.
    pub y: &'static str,
    /// The curves.
    pub curves: Vec<Curve>,
}

const SIZE: [f64; 2] = [720.0, 440.0];
const LEFT: f64 = 70.0;
const RIGHT: f64 = 20.0;
const TOP: f64 = 50.0;
const BOTTOM: f64 = 60.0;

/// Colours that most eyes can distinguish (Okabe, Ito 2008).
const COLORS: [&str; 7] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#000000", "#e69f00", "#56b4e9"];

impl Plot {
    /// The drawing.
    #[must_use]
    pub fn svg(&self) -> String {
        let all = || self.curves.iter().flat_map(|curve| &curve.points);
        let of = |axis: usize| all().map(move |point| point[axis]);
        let (low, high) = (of(0).fold(f64::MAX, f64::min), of(0).fold(f64::MIN, f64::max));
        let top = of(1).fold(0.0, f64::max);
        let x = if low <= high { Axis::new(low, high) } else { Axis::new(0.0, 1.0) };
        let y = Axis::new(0.0, top);
        let place = |[px, py]: [f64; 2]| {
            let across = LEFT + x.part(px) * (SIZE[0] - LEFT - RIGHT);
            [across, SIZE[1] - BOTTOM - y.part(py) * (SIZE[1] - TOP - BOTTOM)]
        };
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" \
             font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            SIZE[0], SIZE[1]
        );
        let mut line = |markup: String| {
            text += &markup;
            text.push('\n');
        };
        line(label(SIZE[0] / 2.0, 24.0, "middle", self.title));
        line(label(SIZE[0] / 2.0, SIZE[1] - 16.0, "middle", self.x));
        let middle = SIZE[1] / 2.0;
        line(format!(
            "<text x=\"18\" y=\"{middle:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 18 {middle:.1})\">{}</text>",
            escaped(self.y)
        ));
        for tick in x.ticks() {
            let [across, down] = place([tick, 0.0]);
            line(rule([across, TOP], [across, down]));
            line(label(across, down + 18.0, "middle", &number(tick)));
        }
        for tick in y.ticks() {
            let [across, down] = place([x.low, tick]);
            line(rule([across, down], [SIZE[0] - RIGHT, down]));
            line(label(across - 8.0, down + 4.0, "end", &number(tick)));
        }
        for ((i, curve), color) in self.curves.iter().enumerate().zip(COLORS.iter().cycle()) {
            for part in curve.points.split(|point| point[0].is_nan()) {
                let points = part.iter().map(|&point| {
                    let [across, down] = place(point);
                    format!("{across:.1},{down:.1}")
                });
                let points = points.collect::<Vec<_>>().join(" ");
                line(format!(
                    "<polyline points=\"{points}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>"
                ));
            }
            let down = TOP + 16.0 + 18.0 * i as f64;
            line(format!(
                "<line x1=\"{0:.1}\" y1=\"{1:.1}\" x2=\"{2:.1}\" y2=\"{1:.1}\" stroke=\"{color}\" stroke-width=\"3\"/>",
                LEFT + 12.0,
                down - 4.0,
                LEFT + 36.0
            ));
            line(label(LEFT + 42.0, down, "start", &curve.name));
        }
        text + "</svg>\n"
    }
}

fn label(x: f64, y: f64, anchor: &str, text: &str) -> String {
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{}</text>", escaped(text))
}

fn rule([x1, y1]: [f64; 2], [x2, y2]: [f64; 2]) -> String {
    format!("<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"#ddd\"/>")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text.is_empty() || text == "-0" { "0".to_owned() } else { text.to_owned() }
}

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
            if span / step <= 8.0 || step > 1e12 {
                break;
            }
            step *= factor;
        }
        let first = (low / step + 1e-9).floor();
        let last = ((high.max(low + span * 1e-9)) / step - 1e-9).ceil();
        Self { low: first * step, step, steps: ((last - first) as u32).max(1) }
    }

    fn part(&self, value: f64) -> f64 {
        (value - self.low) / (self.step * f64::from(self.steps))
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
        let plot = Plot { title: "title", x: "across", y: "up", curves: vec![curve] };
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
        let plot = Plot { title: "title", x: "across", y: "up", curves: vec![curve] };
        let svg = plot.svg();
        assert_eq!(svg.matches("<polyline").count(), 2);
        assert!(!svg.contains("NaN"), "{svg}");
    }
}
