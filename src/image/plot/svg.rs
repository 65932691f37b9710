//! A plot as SVG.

use super::{LINE, MARK, Plot, RIGHT, SAMPLE, SIZE, Style, TOP};

impl Plot {
    /// The drawing, as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        let axes = self.axes();
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" \
             font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
            SIZE[0], SIZE[1]
        );
        let mut line = |markup: String| {
            text += &markup;
            text.push('\n');
        };
        line(label(SIZE[0] / 2.0, 24.0, "middle", &self.title));
        line(label(SIZE[0] / 2.0, SIZE[1] - 16.0, "middle", self.x));
        let middle = SIZE[1] / 2.0;
        line(format!(
            "<text x=\"18\" y=\"{middle:.1}\" text-anchor=\"middle\" transform=\"rotate(-90 18 {middle:.1})\">{}</text>",
            escaped(self.y)
        ));
        for tick in axes.x.ticks() {
            let [across, down] = axes.place([tick, 0.0]);
            line(rule([across, TOP], [across, down]));
            line(label(across, down + 18.0, "middle", &axes.x.number(tick)));
        }
        for tick in axes.y.ticks() {
            let [across, down] = axes.place([axes.x.low, tick]);
            line(rule([across, down], [SIZE[0] - RIGHT, down]));
            line(label(across - 8.0, down + 4.0, "end", &axes.y.number(tick)));
        }
        let [left, top] = self.legend(&axes);
        for (i, (curve, style)) in self.styled().enumerate() {
            let (color, dashes) = stroke(style);
            for points in curve.lines() {
                let points = points.iter().map(|&point| {
                    let [across, down] = axes.place(point);
                    format!("{across:.1},{down:.1}")
                });
                let points = points.collect::<Vec<_>>().join(" ");
                line(format!(
                    "<polyline points=\"{points}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{}\"{dashes}/>",
                    style.width
                ));
            }
            let marks = curve.lines().flatten().filter(|_| style.marked);
            for [across, down] in marks.map(|&point| axes.place(point).map(|at| at - MARK / 2.0)) {
                line(format!(
                    "<rect x=\"{across:.1}\" y=\"{down:.1}\" width=\"{MARK}\" height=\"{MARK}\" \
                     fill=\"{color}\"/>"
                ));
            }
            let down = top + LINE * i as f64;
            line(format!(
                "<line x1=\"{0:.1}\" y1=\"{1:.1}\" x2=\"{2:.1}\" y2=\"{1:.1}\" stroke=\"{color}\" \
                 stroke-width=\"{3}\"{dashes}/>",
                left,
                down - 4.0,
                left + SAMPLE - 6.0,
                style.width + 1
            ));
            line(label(left + SAMPLE, down, "start", &curve.name));
        }
        text + "</svg>\n"
    }
}

/// A style's colour, and the attribute of its gaps, if it has any.
fn stroke(Style { color: [r, g, b], dashes, .. }: Style) -> (String, String) {
    let color = format!("#{r:02x}{g:02x}{b:02x}");
    if dashes.is_empty() {
        return (color, String::new());
    }
    let dashes: Vec<String> = dashes.iter().map(ToString::to_string).collect();
    (color, format!(" stroke-dasharray=\"{}\"", dashes.join(" ")))
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
