//! The importance of pixels, for methods that give important ones more records (Vasilakis et al., "Variable k-buffer
//! using importance maps", 2017, section 3.2).
//!
//! I = max(0, `I_d` · `I_per` · `I_f` · map + λ (ξ - 0.5)), each factor only if it is asked for. `I_d` follows from a pixel's
//! number of fragments, so the method computes it ([`Weighting`]). All others are known before the frame: they are
//! computed here, in f64 in the written order, and rounded to units of 2^-16, as the method's inputs.
//!
//! ```text
//! I_per = max(0, 1 - (|p - o| / reach)^d)         equation 4
//! I_f   = 1 - (1 - max(0, n · e))^5 / 2           equation 5
//! ```
//!
//! p is the pixel's centre, o the image's or the gaze. The paper's reach is the picture's diagonal, so that `I_per` falls
//! to 1 - 2^-d in the corners; its authors' shader divides by 1.1 half diagonals, which uses nearly the whole range. n is the normal of
//! the nearest fragment at p in the frame before, towards the viewer, and e the direction from there to the eye. A pixel
//! without fragments there, or without a frame before, has `I_f` = 1.

mod fresnel;
mod map;
mod shares;

use crate::error::{Error, Result};
use crate::num::random;
use crate::scheme::kplus_buffer::k_variable::{BIAS, FACTOR, MOST_LAYERS, ONE, Weighting};

use super::inputs::Given;

pub use fresnel::fresnel;
pub use map::ImportanceMap;
pub use shares::{ImportanceReport, Shares};

/// Stream of the noise.
const NOISE: u64 = 0x1A11;

/// What makes a pixel important.
#[derive(Clone, Debug, PartialEq)]
pub struct Importance {
    /// The factors that are multiplied, and the noise.
    pub factors: Factors,
    /// A map of importance, stretched over the picture.
    pub map: Option<ImportanceMap>,
    /// Where the viewer looks, in pixels from the top left; `None` is the middle.
    pub gaze: Option<[f64; 2]>,
    /// α of `I_d`, 0 to 1: the importance of a pixel with hardly any fragments.
    pub alpha: f64,
    /// `N_limit` of `I_d`, 1 to 65,535 fragments: more make a pixel no more important.
    pub layers: u32,
    /// d of `I_per`, above 0.
    pub falloff: f64,
    /// What the distance from the middle is compared with.
    pub reach: Reach,
    /// λ, 0 to 1.
    pub noise: f64,
    /// The seed of the noise.
    pub seed: u64,
    /// The frame's number, which changes the noise.
    pub frame: u32,
    /// `I_f` of every pixel of a picture of this size, row by row, in units of 2^-16: from the frame before.
    pub fresnel: Option<([u32; 2], Vec<u32>)>,
}

/// Which factors are used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Factors {
    /// `I_d`, by the number of fragments.
    pub depth: bool,
    /// `I_per`, by the distance from the middle or the gaze.
    pub periphery: bool,
    /// `I_f`, by the nearest surface of the frame before.
    pub fresnel: bool,
    /// The map.
    pub map: bool,
    /// The noise that is added.
    pub noise: bool,
}

/// What the distance from the middle is divided by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Reach {
    /// The picture's diagonal, as the paper's equation 4 reads.
    #[default]
    Diagonal,
    /// 1.1 times half of it, as its authors' shader has it.
    HalfDiagonal,
}

impl Factors {
    /// As in the paper, without a map.
    pub const COMPUTED: Self =
        Self { depth: true, periphery: true, fresnel: true, map: false, noise: true };

    /// A map alone.
    pub const MAPPED: Self =
        Self { depth: false, periphery: false, fresnel: false, map: true, noise: false };

    /// Their names, in this order.
    #[must_use]
    pub fn names(self) -> Vec<&'static str> {
        let all = [
            ("depth", self.depth),
            ("periphery", self.periphery),
            ("fresnel", self.fresnel),
            ("map", self.map),
            ("noise", self.noise),
        ];
        all.iter().filter(|(_, used)| *used).map(|(name, _)| *name).collect()
    }
}

impl Default for Importance {
    fn default() -> Self {
        Self {
            factors: Factors::COMPUTED,
            map: None,
            gaze: None,
            alpha: 0.25,
            layers: 30,
            falloff: 3.0,
            reach: Reach::Diagonal,
            noise: 0.1,
            seed: 0,
            frame: 0,
            fresnel: None,
        }
    }
}

impl Importance {
    /// Check every value against its range.
    ///
    /// # Errors
    /// The first that is out of range, by the name of its option.
    pub(super) fn check(&self) -> Result<()> {
        let wrong = |option: &str, problem: String| Err(Error::new(option, problem));
        let unit = |x: f64| (0.0..=1.0).contains(&x);
        if !unit(self.alpha) {
            let problem = format!("is {}, but must be 0 to 1", self.alpha);
            return wrong("--importance-alpha", problem);
        }
        if !(1..=MOST_LAYERS).contains(&self.layers) {
            let problem = format!("is {}, but must be 1 to {MOST_LAYERS} fragments", self.layers);
            return wrong("--importance-layers", problem);
        }
        if !(self.falloff > 0.0 && self.falloff.is_finite()) {
            let problem = format!("is {}, but must be above 0, and finite", self.falloff);
            return wrong("--periphery-falloff", problem);
        }
        if !unit(self.noise) {
            let problem = format!("is {}, but must be 0 to 1", self.noise);
            return wrong("--importance-noise", problem);
        }
        if self.factors.map && self.map.is_none() {
            return wrong("--importance", "names map: give one with --importance-map".to_owned());
        }
        if self.map.is_some() && !self.factors.map {
            let problem = "is given, but --importance does not name map".to_owned();
            return wrong("--importance-map", problem);
        }
        Ok(())
    }

    /// Check what depends on the picture's size.
    ///
    /// # Errors
    /// A gaze outside of it.
    pub(super) fn check_for(&self, [width, height]: [u32; 2]) -> Result<()> {
        let inside = |x: f64, edge: u32| (0.0..=f64::from(edge)).contains(&x);
        match self.gaze {
            Some([x, y]) if !(inside(x, width) && inside(y, height)) => {
                let problem = format!("is {x},{y}, outside of the picture of {width}x{height}");
                Err(Error::new("--gaze", problem))
            }
            _ => Ok(()),
        }
    }

    /// How a pixel's number of fragments becomes importance.
    #[must_use]
    pub fn weighting(&self) -> Weighting {
        let alpha = if self.factors.depth { fixed(self.alpha) } else { ONE };
        Weighting { alpha, limit: self.layers }
    }

    /// The same for a picture from elsewhere: without a gaze, and without a frame before.
    pub(super) fn elsewhere(&self) -> Self {
        Self { gaze: None, fresnel: None, ..self.clone() }
    }

    /// The inputs of the method for a picture of this size.
    pub(super) fn inputs(&self, size: [u32; 2]) -> [(String, Given); 2] {
        let image = |words| Given::Image { size, words };
        [(FACTOR.to_owned(), image(self.factor(size))), (BIAS.to_owned(), image(self.bias(size)))]
    }

    /// The product of all factors but `I_d`, for every pixel, row by row, 0 to [`ONE`].
    #[must_use]
    pub fn factor(&self, size: [u32; 2]) -> Vec<u32> {
        let of = |(x, y): (u32, u32)| {
            let mut product = 1.0;
            if self.factors.periphery {
                product *= self.periphery(size, x, y);
            }
            if self.factors.fresnel {
                product *= self.fresnel_at(size, x, y);
            }
            if let Some(map) = self.map.as_ref().filter(|_| self.factors.map) {
                product *= map.at(size, x, y);
            }
            fixed(product)
        };
        pixels(size).map(of).collect()
    }

    /// The noise of every pixel, row by row, two's complement.
    fn bias(&self, size: [u32; 2]) -> Vec<u32> {
        let stream = NOISE << 32 | u64::from(self.frame);
        let of = |(x, y): (u32, u32)| {
            if !self.factors.noise {
                return 0;
            }
            // The same for a place whatever the picture's size.
            let bits = random::bits(self.seed, stream, u64::from(y) << 32 | u64::from(x));
            let xi = (bits >> 11) as f64 / 9_007_199_254_740_992.0;
            let bias = self.noise * (xi - 0.5) * f64::from(ONE);
            libm::rint(bias) as i32 as u32
        };
        pixels(size).map(of).collect()
    }

    /// `I_per` at a pixel.
    #[must_use]
    pub fn periphery(&self, size: [u32; 2], x: u32, y: u32) -> f64 {
        let [width, height] = size.map(f64::from);
        let [ox, oy] = self.gaze.unwrap_or([width * 0.5, height * 0.5]);
        let (dx, dy) = (f64::from(x) + 0.5 - ox, f64::from(y) + 0.5 - oy);
        let diagonal = libm::sqrt(width * width + height * height);
        let reach = match self.reach {
            Reach::Diagonal => diagonal,
            Reach::HalfDiagonal => diagonal * 0.55,
        };
        let part = libm::sqrt(dx * dx + dy * dy) / reach;
        (1.0 - libm::pow(part, self.falloff)).clamp(0.0, 1.0)
    }

    /// `I_f` at a pixel.
    #[must_use]
    pub fn fresnel_at(&self, size: [u32; 2], x: u32, y: u32) -> f64 {
        match &self.fresnel {
            Some((known, words)) if *known == size => {
                f64::from(words[(y * size[0] + x) as usize]) / f64::from(ONE)
            }
            _ => 1.0,
        }
    }
}

/// 0 to 1 in units of 2^-16, rounded to the nearest.
fn fixed(x: f64) -> u32 {
    libm::rint(x.clamp(0.0, 1.0) * f64::from(ONE)) as u32
}

/// The pixels of a picture, row by row.
fn pixels([width, height]: [u32; 2]) -> impl Iterator<Item = (u32, u32)> {
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [41, 31];

    #[test]
    fn the_periphery_falls_from_the_middle_or_the_gaze() {
        let middle = Importance::default();
        assert!((middle.periphery(SIZE, 20, 15) - 1.0).abs() < 1e-12);
        let corner = middle.periphery(SIZE, 0, 0);
        assert!((corner - 0.89).abs() < 0.02, "1 - 2^-3, nearly: {corner}");
        let half = Importance { reach: Reach::HalfDiagonal, ..Importance::default() };
        let corner = half.periphery(SIZE, 0, 0);
        assert!((0.25..0.35).contains(&corner), "1 - 1.1^-3, nearly: {corner}");
        let gaze = Importance { gaze: Some([40.5, 0.5]), ..Importance::default() };
        assert!((gaze.periphery(SIZE, 40, 0) - 1.0).abs() < 1e-12);
        assert!(gaze.periphery(SIZE, 0, 30) < gaze.periphery(SIZE, 20, 15));
        let all: Vec<f64> = pixels(SIZE).map(|(x, y)| gaze.periphery(SIZE, x, y)).collect();
        assert!(all.iter().all(|i| (0.0..=1.0).contains(i)));
    }

    #[test]
    fn noise_is_even_and_of_the_place_frame_and_seed() {
        let importance = Importance::default();
        let bias = importance.bias([64, 64]);
        let real = |&word: &u32| f64::from(word as i32) / f64::from(ONE);
        let (low, high) =
            (bias.iter().map(real).fold(1.0, f64::min), bias.iter().map(real).fold(-1.0, f64::max));
        assert!((-0.05..-0.049).contains(&low) && (0.049..=0.05).contains(&high), "{low} {high}");
        let mean = bias.iter().map(real).sum::<f64>() / bias.len() as f64;
        assert!(mean.abs() < 0.002, "{mean}");
        assert_eq!(importance.bias([64, 64]), bias);
        assert_eq!(importance.bias([32, 1]), bias[..32], "of the place");
        let other = |importance: Importance| assert_ne!(importance.bias([64, 64]), bias);
        other(Importance { frame: 1, ..Importance::default() });
        other(Importance { seed: 1, ..Importance::default() });
        let silent = Importance {
            factors: Factors { noise: false, ..Factors::COMPUTED },
            ..Importance::default()
        };
        assert!(silent.bias(SIZE).iter().all(|&b| b == 0));
    }

    #[test]
    fn wrong_values_name_their_option() {
        let wrong = |importance: Importance| importance.check().unwrap_err().place().to_owned();
        let base = Importance::default;
        assert_eq!(wrong(Importance { alpha: 1.5, ..base() }), "--importance-alpha");
        assert_eq!(wrong(Importance { alpha: f64::NAN, ..base() }), "--importance-alpha");
        assert_eq!(wrong(Importance { layers: 0, ..base() }), "--importance-layers");
        assert_eq!(wrong(Importance { falloff: 0.0, ..base() }), "--periphery-falloff");
        assert_eq!(wrong(Importance { noise: -0.1, ..base() }), "--importance-noise");
        assert_eq!(wrong(Importance { factors: Factors::MAPPED, ..base() }), "--importance");
        let gaze = Importance { gaze: Some([41.5, 0.0]), ..base() };
        assert_eq!(gaze.check_for(SIZE).unwrap_err().place(), "--gaze");
        assert!(Importance { gaze: Some([41.0, 31.0]), ..base() }.check_for(SIZE).is_ok());
    }
}
