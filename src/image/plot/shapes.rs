//! A plot as a drawing.

use super::{Axes, BOTTOM, LINE, MARK, Plot, RIGHT, SAMPLE, SIZE, TOP};
use crate::image::Image;
use crate::image::drawing::look::{Ink, LETTER};
use crate::image::drawing::{Anchor, Drawing, Face};

impl Plot {
    /// The drawing, as SVG.
    #[must_use]
    pub fn svg(&self) -> String {
        self.drawing().svg()
    }

    /// The drawing, as a picture of 1440x880 pixels. Only Latin-1 can be drawn; a title too long is cut short.
    #[must_use]
    pub fn draw(&self) -> Image {
        self.drawing().draw()
    }

    fn drawing(&self) -> Drawing {
        let mut drawing = Drawing::new(SIZE, &self.title);
        let axes = self.axes();
        // Letters of titles are a little wider.
        let most = (SIZE[0] / (LETTER[0] + 1.0)) as usize - 2;
        let title: String = self.title.chars().take(most).collect();
        let middle = SIZE[0] / 2.0;
        drawing.letters([middle, 26.0], Anchor::Middle, &title, Ink::Text, Face::Title);
        drawing.text([middle, SIZE[1] - 16.0], Anchor::Middle, self.x, Ink::Quiet);
        let beside = [18.0, (TOP + SIZE[1] - BOTTOM) / 2.0];
        drawing.letters(beside, Anchor::Middle, self.y, Ink::Quiet, Face::Upright);
        rules(&mut drawing, &axes);
        let [left, top] = self.legend(&axes);
        for (i, (curve, style)) in self.styled().enumerate() {
            for points in curve.lines() {
                let points = points.iter().map(|&point| axes.place(point)).collect();
                drawing.line(points, style.ink, style.width, style.dashes);
            }
            for &point in curve.lines().flatten().filter(|_| style.marked) {
                let corner = axes.place(point).map(|at| at - MARK / 2.0);
                drawing.area(corner, [MARK; 2], style.ink);
            }
            let down = top + LINE * i as f64;
            let sample = [left, left + SAMPLE - 6.0].map(|across| [across, down - 4.0]);
            drawing.segment(sample, style.ink, style.width + 1, style.dashes);
            drawing.text([left + SAMPLE, down], Anchor::Start, &curve.name, Ink::Text);
        }
        drawing
    }
}

/// The ticks with their numbers.
fn rules(drawing: &mut Drawing, axes: &Axes) {
    for tick in axes.x.ticks() {
        let [across, down] = axes.place([tick, 0.0]);
        drawing.rule([across, TOP], [across, down], Ink::Rule);
        let number = axes.x.number(tick);
        drawing.text([across, down + 18.0], Anchor::Middle, &number, Ink::Text);
    }
    for tick in axes.y.ticks() {
        let [across, down] = axes.place([axes.x.low, tick]);
        drawing.rule([across, down], [SIZE[0] - RIGHT, down], Ink::Rule);
        drawing.text([across - 8.0, down + 4.0], Anchor::End, &axes.y.number(tick), Ink::Text);
    }
}

#[cfg(test)]
mod tests {
    use super::super::Curve;
    use super::*;

    fn plot(points: &[[f64; 2]]) -> Image {
        let curve = Curve { points: points.to_vec(), ..Curve::new("curve") };
        let plot = Plot { title: "title".into(), x: "across", y: "up", curves: vec![curve] };
        plot.draw()
    }

    fn colored(image: &Image, [x, y]: [u32; 2]) -> bool {
        image.pixel(x, y)[..3] == Ink::Series(0).color(false)
    }

    /// A step at 1 of 0..2: nothing to its left above 0, nothing to its right below the top, and upright between.
    #[test]
    fn a_step_is_a_step() {
        let image = plot(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]]);
        assert_eq!([image.width, image.height], [1_440, 880]);
        let [left, right] = [140, 1_400];
        let [top, bottom, middle] = [100, 760, 770];
        for y in top + 10..bottom - 10 {
            let row: Vec<u32> = (left + 400..right).filter(|&x| colored(&image, [x, y])).collect();
            assert_eq!(row, (middle - 2..middle + 2).collect::<Vec<_>>(), "{y}");
        }
        assert!((left..middle).all(|x| colored(&image, [x, bottom])));
        assert!((middle..right).all(|x| colored(&image, [x, top])));
        assert!((middle + 2..right).all(|x| !colored(&image, [x, bottom])));
    }

    #[test]
    fn the_same_plot_gives_the_same_bytes_and_an_empty_one_is_drawn() {
        let points = [[0.0, 0.3], [7.3, 0.9], [8.1, 0.1]];
        assert_eq!(plot(&points), plot(&points));
        assert_ne!(plot(&points), plot(&points[..2]));
        assert_eq!(Plot::default().draw().width, 1_440);
    }
}
