//! The absorbance along the ray as a plot (Figure 13 of the z-thickness paper).

use super::found::{Inspected, Inspection, title};
use crate::image::plot::{Curve, Plot, Stroke};

/// What is shown before the nearest corner and behind the farthest, as a part of what lies between.
const MARGIN: f64 = 0.05;

impl Inspection {
    /// The absorbance by eye distance: the exact one, then each method's over it. Of a method that holds a colour only
    /// what is absorbed in all is known; it is shown at the far end.
    ///
    /// # Examples
    /// ```
    /// use fragloom::inspect::inspect;
    /// use fragloom::render::Options;
    /// use fragloom::scene::{self, Overrides};
    ///
    /// let scene = scene::load("layers:count=6", &Overrides { size: Some([16, 16]), ..Overrides::default() })?;
    /// let plot = inspect(&scene, &[Options::default()], [5, 5])?.plot();
    /// assert_eq!(plot.curves.iter().map(|curve| &curve.name[..]).collect::<Vec<_>>(), ["exact", "kplus-array, k = 8"]);
    /// assert!(plot.svg().starts_with("<svg") && plot.draw().width > 0);
    /// # Ok::<(), fragloom::error::Error>(())
    /// ```
    #[must_use]
    pub fn plot(&self) -> Plot {
        let ends = self.ends();
        let exact = Curve {
            points: steps(&self.exact.absorbance, ends),
            stroke: Stroke::Wide,
            ..Curve::new("exact")
        };
        let method = |found: &Inspected| {
            let is_color = found.absorbance.is_empty() && found.absorbed > 0.0;
            let points = if is_color {
                ends.map_or_else(Vec::new, |[_, far]| {
                    let from = far - (far - ends.map_or(far, |[near, _]| near)) * MARGIN;
                    vec![[from, found.absorbed], [far, found.absorbed]]
                })
            } else {
                steps(&found.absorbance, ends)
            };
            Curve { points, stroke: Stroke::Over, ..Curve::new(&found.title()) }
        };
        let [x, y] = self.pixel;
        Plot {
            title: format!("{}, {}x{}, pixel {x},{y}", self.scene, self.width, self.height),
            x: "eye distance (world units)",
            y: "absorbance (1 - transmittance)",
            curves: std::iter::once(exact).chain(self.methods.iter().map(method)).collect(),
        }
    }

    /// Where the curves begin and end: a little before and behind all corners.
    fn ends(&self) -> Option<[f64; 2]> {
        let of_methods = self.methods.iter().flat_map(|found| &found.absorbance);
        let all = || self.exact.absorbance.iter().chain(of_methods.clone()).map(|corner| corner[0]);
        let near = all().reduce(f64::min)?;
        let far = all().reduce(f64::max)?;
        let span = if far > near { far - near } else { far.abs().max(MARGIN) };
        Some([near - MARGIN * span, far + MARGIN * span])
    }
}

impl Inspected {
    /// The name, and k where it has one.
    #[must_use]
    pub fn title(&self) -> String {
        title(&self.method, self.k)
    }
}

/// From nothing absorbed at one end to all of it at the other.
fn steps(corners: &[[f64; 2]], ends: Option<[f64; 2]>) -> Vec<[f64; 2]> {
    let Some([near, far]) = ends else { return Vec::new() };
    let last = corners.last().map_or(0.0, |corner| corner[1]);
    let mut points = vec![[near, 0.0]];
    points.extend(corners);
    points.push([far, last]);
    points
}
