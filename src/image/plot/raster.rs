//! A plot as a picture, two pixels for every unit of the SVG drawing. Ends of lines are rounded to pixels; what lies
//! between them is integer arithmetic.

use super::{Axes, BOTTOM, LINE, MARK, Plot, RIGHT, SAMPLE, SIZE, Style, TOP};
use crate::image::Image;
use crate::image::canvas::{BODY, Canvas, INK, QUIET, TITLE};
use embedded_graphics::mono_font::MonoFont;

/// Pixels of a unit.
const SCALE: u32 = 2;

const WHITE: [u8; 3] = [255; 3];
const RULE: [u8; 3] = [221; 3];

/// Where a line stands by its x.
#[derive(Clone, Copy)]
enum Anchor {
    Start,
    Middle,
    End,
}

/// The pixel of a place on the drawing.
fn pixel(place: [f64; 2]) -> [u32; 2] {
    place.map(|at| (at * f64::from(SCALE)).round().max(0.0) as u32)
}

impl Plot {
    /// The drawing, as a picture of 1440x880 pixels. Only Latin-1 can be drawn; a title too long is cut short.
    #[must_use]
    pub fn draw(&self) -> Image {
        let [width, height] = pixel(SIZE);
        let mut canvas = Canvas::new(width, height, SCALE, WHITE);
        let axes = self.axes();
        self.letters(&mut canvas);
        rules(&mut canvas, &axes);
        let [left, top] = self.legend(&axes);
        for (i, (curve, style)) in self.styled().enumerate() {
            for points in curve.lines() {
                let points = points.iter().map(|&point| pixel(axes.place(point)));
                line(&mut canvas, &points.collect::<Vec<_>>(), style);
            }
            let marks = curve.lines().flatten().filter(|_| style.marked);
            for place in marks.map(|&point| axes.place(point)) {
                let corner = pixel(place.map(|at| at - MARK / 2.0));
                canvas.fill(corner, pixel([MARK; 2]), style.color);
            }
            let down = top + LINE * i as f64;
            let ends = [left, left + SAMPLE - 6.0].map(|across| pixel([across, down - 4.0]));
            line(&mut canvas, &ends, Style { width: style.width + 1, ..style });
            write(&mut canvas, [left + SAMPLE, down], Anchor::Start, &curve.name, &BODY);
        }
        canvas.into_image()
    }

    fn letters(&self, canvas: &mut Canvas) {
        let most = (SIZE[0] as u32 / TITLE.character_size.width) as usize - 2;
        let title: String = self.title.chars().take(most).collect();
        write(canvas, [SIZE[0] / 2.0, 26.0], Anchor::Middle, &title, &TITLE);
        write(canvas, [SIZE[0] / 2.0, SIZE[1] - 16.0], Anchor::Middle, self.x, &BODY);
        let upright = upright(self.y);
        let [across, middle] = pixel([6.0, (TOP + SIZE[1] - BOTTOM) / 2.0]);
        canvas.place([across, middle.saturating_sub(upright.height / 2)], &upright, 1);
    }
}

/// The ticks with their numbers.
fn rules(canvas: &mut Canvas, axes: &Axes) {
    let [right, top] = pixel([SIZE[0] - RIGHT, TOP]);
    for tick in axes.x.ticks() {
        let place = axes.place([tick, 0.0]);
        let [across, down] = pixel(place);
        canvas.fill([across, top], [1, down - top], RULE);
        let at = [place[0], place[1] + 18.0];
        write(canvas, at, Anchor::Middle, &axes.x.number(tick), &BODY);
    }
    for tick in axes.y.ticks() {
        let place = axes.place([axes.x.low, tick]);
        let [across, down] = pixel(place);
        canvas.fill([across, down], [right - across, 1], RULE);
        let at = [place[0] - 8.0, place[1] + 4.0];
        write(canvas, at, Anchor::End, &axes.y.number(tick), &BODY);
    }
}

/// Write a line whose letters stand on y.
fn write(canvas: &mut Canvas, [x, y]: [f64; 2], anchor: Anchor, text: &str, font: &MonoFont<'_>) {
    let [across, down] = pixel([x, y - f64::from(font.baseline)]);
    let long = SCALE * text.chars().count() as u32 * font.character_size.width;
    let left = match anchor {
        Anchor::Start => across,
        Anchor::Middle => across.saturating_sub(long / 2),
        Anchor::End => across.saturating_sub(long),
    };
    canvas.text([left, down], text, font, INK);
}

/// A line of text from the bottom to the top.
fn upright(text: &str) -> Image {
    let long = SCALE * text.chars().count() as u32 * BODY.character_size.width;
    let tall = SCALE * BODY.character_size.height;
    let mut canvas = Canvas::new(long, tall, SCALE, WHITE);
    canvas.text([0, 0], text, &BODY, QUIET);
    let lying = canvas.into_image();
    let turned = |(x, y): (u32, u32)| lying.pixel(long - 1 - y, x);
    let places = (0..long).flat_map(|y| (0..tall).map(move |x| (x, y)));
    Image { width: tall, height: long, pixels: places.map(turned).collect() }
}

/// Join points by a line of square dots, with the gaps of its style.
fn line(canvas: &mut Canvas, points: &[[u32; 2]], style: Style) {
    let width = style.width * SCALE;
    let mut passed = 0;
    for pair in points.windows(2) {
        let [from, to] = [pair[0], pair[1]].map(|point| point.map(i64::from));
        let across = [to[0] - from[0], to[1] - from[1]];
        let steps = across[0].abs().max(across[1].abs());
        for step in 0..=steps {
            if is_drawn(style.dashes, passed / SCALE) {
                // The nearest pixel, halves up.
                let along = |axis: usize| match steps {
                    0 => from[axis],
                    n => from[axis] + (2 * across[axis] * step + n).div_euclid(2 * n),
                };
                let corner = [along(0), along(1)].map(|at| (at - i64::from(width / 2)).max(0));
                canvas.fill(corner.map(|at| at as u32), [width, width], style.color);
            }
            passed += u32::from(step < steps);
        }
    }
}

/// Whether a line is drawn at this distance from its beginning.
fn is_drawn(dashes: &[u32], at: u32) -> bool {
    let Some(mut rest) = at.checked_rem(dashes.iter().sum()) else { return true };
    for (i, &length) in dashes.iter().enumerate() {
        if rest < length {
            return i % 2 == 0;
        }
        rest -= length;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::super::{COLORS, Curve, DASHES};
    use super::*;

    fn plot(points: &[[f64; 2]]) -> Image {
        let curve = Curve { points: points.to_vec(), ..Curve::new("curve") };
        let plot = Plot { title: "title".into(), x: "across", y: "up", curves: vec![curve] };
        plot.draw()
    }

    fn colored(image: &Image, [x, y]: [u32; 2]) -> bool {
        image.pixel(x, y)[..3] == COLORS[0]
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

    #[test]
    fn gaps_are_where_the_pattern_has_them() {
        let drawn = |dashes| (0..8).map(|at| is_drawn(dashes, at)).collect::<Vec<_>>();
        assert_eq!(drawn(&[3, 2]), [true, true, true, false, false, true, true, true]);
        assert!(drawn(DASHES[0]).iter().all(|&drawn| drawn));
    }
}
