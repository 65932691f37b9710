//! Shading: from a primitive and a pixel to the RGBA8 data word.
//!
//! All arithmetic is f32 in the order written, never fused. Perspective-correct weights come from the triangle's
//! homogeneous vertices *before* clipping (Olano and Greer, "Triangle scan conversion using 2D homogeneous
//! coordinates", 1997): `weight_i(x, y) = (a_i dx + b_i dy) + c_i` relative to the primitive's first pixel, clamped
//! at 0; an attribute is ((w0 v0 + w1 v1) + w2 v2) / ((w0 + w1) + w2). The set-up of a, b, c is f64.
//!
//! * `flat`: colour c as it is.
//! * `lambert`: c * (ambient + (1 - ambient) * max(n.l, 0)).
//! * `gooch` (Gooch, Gooch, Shirley, Cohen, "A non-photorealistic lighting model", SIGGRAPH 1998, b = 0.55, y = 0.3,
//!   alpha = beta = 0.25): t * warm + (1 - t) * cool with t = (1 + n.l) / 2, warm = (0.3, 0.3, 0) + 0.25 c, cool =
//!   (0, 0, 0.55) + 0.25 c.
//!
//! n is the normalised interpolated normal, or the face's where there is none, turned to the viewer's side; n.l and
//! n.n are (x x' + y y') + z z'. The opacity is the material's times the interpolated one of the corners. A surface whose colour does not vary over it is shaded once, at set-up.
//!
//! A picture on a surface multiplies its colour and its opacity ([`crate::scene::texture`]), at the interpolated place.
//! If it is a mask, what is less opaque than its cutoff is not there ([`Surface::is_cut`]): the front end leaves it out
//! of the coverage, so that no method, and no count, ever sees it.
//!
//! A disc has one colour and one normal. Where its opacity falls off, at a point (u, v) in half axes from its centre it
//! is the disc's times exp(-((u u + v v) (s s)) / 2), with s the standard deviations from centre to rim. u and v are
//! perspective-correct: of the weights of the centre and the ends of both axes, not clamped, u = w1 / ((w0 + w1) + w2)
//! and v = w2 / ((w0 + w1) + w2).
//!
//! Where light is attenuated on its way (`Attenuation`, T in 0..1 per channel), `lambert` multiplies the diffuse term
//! by T and leaves the ambient one, c * (ambient + (1 - ambient) * (max(n.l, 0) * T)); `gooch` cools, by (t * T) in
//! place of t; `flat` surfaces and screen triangles are not lit, and stay as they are. T = 1 gives the same bits as no
//! attenuation at all.

use glam::{DVec3, DVec4};

use super::clip::Viewport;
use super::disc::Lying;
use super::primitive::Rect;
use crate::num::color;
use crate::scene::texture::Opacity;
use crate::scene::{Disc, Light, Material, Shading, Texture};

/// Three f32 lanes, added and multiplied in the written order.
type Rgb = [f32; 3];

/// What lies on a primitive.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// The same data word everywhere.
    Uniform(u32),
    /// Evaluated per fragment.
    Varying(Box<Varying>),
    /// The same, with a picture.
    Pictured(Box<Pictured>),
    /// One colour and one normal, but light that is attenuated from pixel to pixel.
    Even(Box<Even>),
    /// The same, with an opacity that falls off from the centre.
    Fading(Box<Fading>),
}

/// How much of the light reaches a point.
pub trait Attenuation: std::fmt::Debug + Send + Sync {
    /// Per channel, 0 to 65,535 (all of it), at the point that pixel (x, y) sees at a stored depth.
    fn transmittance(&self, x: u32, y: u32, depth: u32) -> [u16; 3];
}

/// All of the light, per channel.
const ALL: Rgb = [1.0; 3];

/// A surface that would be uniform in light that is.
#[derive(Clone, Debug, PartialEq)]
pub struct Even {
    color: Rgb,
    normal: Rgb,
    alpha: f32,
    shading: Shading,
    light: Lighting,
}

impl Even {
    #[inline]
    fn at(&self, reaches: Rgb) -> u32 {
        self.faded(reaches, 1.0)
    }

    #[inline]
    fn faded(&self, reaches: Rgb, opacity: f32) -> u32 {
        let rgb = self.light.shade(self.shading, self.color, self.normal, reaches);
        color::rgba8(rgb, self.alpha * opacity)
    }
}

/// A disc whose opacity falls off from its centre.
#[derive(Clone, Debug, PartialEq)]
pub struct Fading {
    even: Even,
    origin: [u32; 2],
    weights: [[f32; 3]; 3],
    /// Minus half the square of the standard deviations from centre to rim.
    exponent: f32,
}

impl Fading {
    fn at(&self, x: u32, y: u32, reaches: Rgb) -> u32 {
        self.even.faded(reaches, self.opacity(x, y))
    }

    /// The share of the disc's opacity at pixel (x, y), 0..1.
    fn opacity(&self, x: u32, y: u32) -> f32 {
        let dx = x as f32 - self.origin[0] as f32;
        let dy = y as f32 - self.origin[1] as f32;
        let w = self.weights.map(|[a, b, c]| (a * dx + b * dy) + c);
        let sum = (w[0] + w[1]) + w[2];
        let (u, v) = (w[1] / sum, w[2] / sum);
        let opacity = libm::expf((u * u + v * v) * self.exponent);
        if opacity.is_nan() { 0.0 } else { opacity }
    }
}

/// A surface whose colour changes from pixel to pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct Varying {
    origin: [u32; 2],
    weights: [[f32; 3]; 3],
    normals: [Rgb; 3],
    face_normal: Rgb,
    colors: [Rgb; 3],
    alpha: f32,
    /// Of the corners, multiplied with `alpha`.
    alphas: Option<[f32; 3]>,
    shading: Shading,
    light: Lighting,
}

/// A surface with a picture on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pictured {
    under: Varying,
    texture: Texture,
    /// Of the corners.
    places: [[f32; 2]; 3],
}

/// The light in f32.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lighting {
    towards: Rgb,
    ambient: f32,
}

impl From<Light> for Lighting {
    fn from(light: Light) -> Self {
        Self { towards: light.towards.as_vec3().to_array(), ambient: light.ambient }
    }
}

/// The attributes of a triangle's corners, in world space, before shading.
#[derive(Clone, Copy, Debug)]
pub struct Attributes {
    /// Clip-space positions.
    pub clip: [DVec4; 3],
    /// Towards the viewer's side once `facing` is applied; need not be unit length.
    pub face_normal: DVec3,
    /// Vertex normals, if the mesh has them.
    pub normals: Option<[Rgb; 3]>,
    /// Vertex colours, if the mesh has them.
    pub colors: Option<[Rgb; 3]>,
    /// Vertex opacities, if the mesh has them.
    pub alphas: Option<[f32; 3]>,
    /// Places in the material's picture, if there is one.
    pub places: Option<[[f32; 2]; 3]>,
}

/// How a triangle is seen.
#[derive(Clone, Copy, Debug, Default)]
pub struct Seen {
    /// From its back: normals are reversed.
    pub turned: bool,
    /// In light that will be attenuated.
    pub attenuated: bool,
    /// Its normals will be asked for.
    pub normals: bool,
}

impl Surface {
    /// Of a material that shows its own colour everywhere, whatever the light; `None` if it is shaded.
    #[must_use]
    pub fn flat(material: &Material) -> Option<Self> {
        let Material { color, alpha, .. } = *material;
        let flat = material.shading == Shading::Flat;
        flat.then(|| Self::Uniform(color::rgba8(color, alpha)))
    }

    /// Shade at set-up what does not vary.
    #[must_use]
    pub fn new(
        corners: &Attributes,
        material: &Material,
        light: Lighting,
        Seen { turned, attenuated, normals }: Seen,
        viewport: &Viewport,
        bounds: Rect,
    ) -> Self {
        let sign = if turned { -1.0 } else { 1.0 };
        let face_normal = unit(corners.face_normal).map(|c| c * sign);
        let tint = |c: Rgb| std::array::from_fn(|i| c[i] * material.color[i]);
        let lit = material.shading != Shading::Flat;
        let varies = corners.normals.is_some() && (lit || normals);
        let picture = corners.places.zip(material.texture.as_ref());
        if corners.colors.is_none() && corners.alphas.is_none() && picture.is_none() && !varies {
            let Material { color, alpha, shading, .. } = *material;
            let even = Even { color, normal: face_normal, alpha, shading, light };
            return Self::even(even, (attenuated && lit) || normals);
        }
        let under = Varying {
            origin: [bounds.x0, bounds.y0],
            weights: weights(&corners.clip, viewport, bounds),
            normals: corners.normals.map_or([face_normal; 3], |n| n.map(|n| n.map(|c| c * sign))),
            face_normal,
            colors: corners.colors.map_or([material.color; 3], |c| c.map(tint)),
            alpha: material.alpha,
            alphas: corners.alphas,
            shading: material.shading,
            light,
        };
        match picture {
            Some((places, texture)) => {
                Self::Pictured(Box::new(Pictured { under, texture: texture.clone(), places }))
            }
            None => Self::Varying(Box::new(under)),
        }
    }

    /// Of a disc.
    #[must_use]
    pub fn of_disc(
        disc: &Disc,
        lying: &Lying,
        material: &Material,
        light: Lighting,
        Seen { turned, attenuated, normals }: Seen,
        viewport: &Viewport,
        bounds: Rect,
    ) -> Self {
        let sign = if turned { -1.0 } else { 1.0 };
        let even = Even {
            color: std::array::from_fn(|i| disc.color[i] * material.color[i]),
            normal: unit(lying.normal).map(|c| c * sign),
            alpha: disc.alpha * material.alpha,
            shading: material.shading,
            light,
        };
        if disc.sigmas == 0.0 {
            return Self::even(even, (attenuated && material.shading != Shading::Flat) || normals);
        }
        let ends = [lying.center, lying.center + lying.axes[0], lying.center + lying.axes[1]];
        Self::Fading(Box::new(Fading {
            even,
            origin: [bounds.x0, bounds.y0],
            weights: weights(&ends, viewport, bounds),
            exponent: (disc.sigmas * disc.sigmas) * -0.5,
        }))
    }

    /// Shaded now, or per fragment.
    fn even(even: Even, late: bool) -> Self {
        if late { Self::Even(Box::new(even)) } else { Self::Uniform(even.at(ALL)) }
    }

    /// The data word at pixel (x, y).
    #[inline]
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> u32 {
        match self {
            Self::Uniform(word) => *word,
            Self::Varying(varying) => varying.at(x, y, ALL),
            Self::Pictured(pictured) => pictured.at(x, y, ALL),
            Self::Even(even) => even.at(ALL),
            Self::Fading(fading) => fading.at(x, y, ALL),
        }
    }

    /// The unit normal at pixel (x, y), if it is known.
    #[must_use]
    pub fn normal(&self, x: u32, y: u32) -> Option<[f32; 3]> {
        match self {
            Self::Uniform(_) => None,
            Self::Varying(varying) => Some(varying.normal(varying.parts(x, y))),
            Self::Pictured(pictured) => Some(pictured.under.normal(pictured.under.parts(x, y))),
            Self::Even(even) => Some(even.normal),
            Self::Fading(fading) => Some(fading.even.normal),
        }
    }

    /// Whether parts of it are not there.
    #[must_use]
    pub fn is_masked(&self) -> bool {
        match self {
            Self::Pictured(pictured) => matches!(pictured.texture.opacity, Opacity::Mask { .. }),
            _ => false,
        }
    }

    /// Whether it is not there at pixel (x, y): its picture is a mask, and it is less opaque there than is drawn.
    #[must_use]
    pub fn is_cut(&self, x: u32, y: u32) -> bool {
        match self {
            Self::Pictured(pictured) => pictured.is_cut(x, y),
            _ => false,
        }
    }

    /// The data word at pixel (x, y), where the share `reaches` of the light arrives, 0 to 65,535 per channel.
    #[must_use]
    pub fn attenuated(&self, x: u32, y: u32, reaches: [u16; 3]) -> u32 {
        let reaches = reaches.map(|share| f32::from(share) / 65_535.0);
        match self {
            Self::Uniform(word) => *word,
            Self::Varying(varying) => varying.at(x, y, reaches),
            Self::Pictured(pictured) => pictured.at(x, y, reaches),
            Self::Even(even) => even.at(reaches),
            Self::Fading(fading) => fading.at(x, y, reaches),
        }
    }
}

impl Varying {
    // Always inline, here and in `shade`: without attenuation, multiplying by 1 must cost nothing.
    #[inline(always)]
    fn at(&self, x: u32, y: u32, reaches: Rgb) -> u32 {
        let parts = self.parts(x, y);
        let color = blend(parts, &self.colors);
        let rgb = self.light.shade(self.shading, color, self.normal(parts), reaches);
        color::rgba8(rgb, self.opacity(parts))
    }

    #[inline(always)]
    fn opacity(&self, parts: [f32; 3]) -> f32 {
        self.alphas.map_or(self.alpha, |a| self.alpha * mixed(parts, a))
    }

    /// How much of each corner there is at pixel (x, y); the sum is 1.
    #[inline(always)]
    fn parts(&self, x: u32, y: u32) -> [f32; 3] {
        let dx = x as f32 - self.origin[0] as f32;
        let dy = y as f32 - self.origin[1] as f32;
        let w = self.weights.map(|[a, b, c]| ((a * dx + b * dy) + c).max(0.0));
        let sum = (w[0] + w[1]) + w[2];
        if sum > 0.0 && sum.is_finite() { w.map(|w| w / sum) } else { [1.0, 0.0, 0.0] }
    }

    #[inline(always)]
    fn normal(&self, parts: [f32; 3]) -> Rgb {
        normalized(blend(parts, &self.normals)).unwrap_or(self.face_normal)
    }
}

impl Pictured {
    fn at(&self, x: u32, y: u32, reaches: Rgb) -> u32 {
        let under = &self.under;
        let parts = under.parts(x, y);
        let [r, g, b, alpha] = self.texel(parts);
        let color = blend(parts, &under.colors);
        let color = [color[0] * r, color[1] * g, color[2] * b];
        let rgb = under.light.shade(under.shading, color, under.normal(parts), reaches);
        let opacity = match self.texture.opacity {
            Opacity::Blend => under.opacity(parts) * alpha,
            Opacity::Mask { .. } | Opacity::Opaque => under.alpha,
        };
        color::rgba8(rgb, opacity)
    }

    fn is_cut(&self, x: u32, y: u32) -> bool {
        let Opacity::Mask { alpha, cutoff } = self.texture.opacity else { return false };
        let parts = self.under.parts(x, y);
        // Where all corners have one opacity, it is that one, so that what equals the cutoff is kept.
        let own = match self.under.alphas {
            Some([a, b, c]) if a == b && b == c => a,
            Some(alphas) => mixed(parts, alphas),
            None => 1.0,
        };
        alpha * own * self.texel(parts)[3] < cutoff
    }

    #[inline]
    fn texel(&self, parts: [f32; 3]) -> [f32; 4] {
        let [p, q, r] = self.places;
        self.texture.at([0, 1].map(|i| mixed(parts, [p[i], q[i], r[i]])))
    }
}

/// The mixture of three corners.
#[inline(always)]
fn blend(w: [f32; 3], v: &[Rgb; 3]) -> Rgb {
    std::array::from_fn(|i| mixed(w, [v[0][i], v[1][i], v[2][i]]))
}

#[inline(always)]
fn mixed(w: [f32; 3], v: [f32; 3]) -> f32 {
    (w[0] * v[0] + w[1] * v[1]) + w[2] * v[2]
}

impl Lighting {
    #[inline(always)]
    fn shade(self, shading: Shading, c: Rgb, normal: Rgb, reaches: Rgb) -> Rgb {
        let cosine = dot(normal, self.towards);
        match shading {
            Shading::Flat => c,
            Shading::Lambert => {
                let diffuse = if cosine > 0.0 { cosine } else { 0.0 };
                std::array::from_fn(|i| {
                    c[i] * (self.ambient + (1.0 - self.ambient) * (diffuse * reaches[i]))
                })
            }
            Shading::Gooch => {
                let t = (1.0 + cosine) * 0.5;
                let (warm, cool) = ([0.3, 0.3, 0.0], [0.0, 0.0, 0.55]);
                std::array::from_fn(|i| {
                    let t = t * reaches[i];
                    t * (warm[i] + 0.25 * c[i]) + (1.0 - t) * (cool[i] + 0.25 * c[i])
                })
            }
        }
    }
}

fn dot(a: Rgb, b: Rgb) -> f32 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

fn normalized(v: Rgb) -> Option<Rgb> {
    let square = dot(v, v);
    (square > 0.0 && square.is_finite()).then(|| {
        let length = square.sqrt();
        v.map(|c| c / length)
    })
}

/// The unit vector along `v` in f32; (0, 0, 1) if it has no direction.
fn unit(v: DVec3) -> Rgb {
    let length = ((v.x * v.x + v.y * v.y) + v.z * v.z).sqrt();
    if length > 0.0 && length.is_finite() {
        [v.x / length, v.y / length, v.z / length].map(|c| c as f32)
    } else {
        [0.0, 0.0, 1.0]
    }
}

/// (a, b, c) of each corner's homogeneous weight, scaled so that all stay well within f32's range.
fn weights(clip: &[DVec4; 3], viewport: &Viewport, bounds: Rect) -> [[f32; 3]; 3] {
    let (width, height) = (f64::from(viewport.width), f64::from(viewport.height));
    let (x0, y0) = (f64::from(bounds.x0) + 0.5, f64::from(bounds.y0) + 0.5);
    // Homogeneous pixel coordinates (x w, y w, w), relative to the first pixel's centre.
    let v = clip.map(|v| {
        let x = (v.x * 0.5 + v.w * 0.5) * width - x0 * v.w;
        let y = (v.w * 0.5 - v.y * 0.5) * height - y0 * v.w;
        DVec3::new(x, y, v.w)
    });
    let rows = [cross(v[1], v[2]), cross(v[2], v[0]), cross(v[0], v[1])];
    let volume = (v[0].x * rows[0].x + v[0].y * rows[0].y) + v[0].z * rows[0].z;
    let scale = if volume == 0.0 { 0.0 } else { 1.0 / volume };
    rows.map(|r| [r.x, r.y, r.z].map(|c| (c * scale) as f32))
}

fn cross(a: DVec3, b: DVec3) -> DVec3 {
    DVec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEWPORT: Viewport = Viewport { width: 8, height: 8, sub_pixel_bits: 8 };

    fn material(shading: Shading) -> Material {
        Material { shading, ..Material::new("", [1.0; 3], 1.0) }
    }

    /// A colour ramp 0 to 1 from left (near, w = 1) to right (far, w = 4): half the pixels, a fifth of the ramp.
    #[test]
    fn colours_are_perspective_correct() {
        let clip = [(-1.0, 1.0, 1.0), (-1.0, -3.0, 1.0), (4.0, 4.0, 4.0)]
            .map(|(x, y, w)| DVec4::new(x, y, 0.5 * w, w));
        let corners = Attributes {
            clip,
            face_normal: DVec3::Z,
            normals: None,
            colors: Some([[0.0; 3], [0.0; 3], [1.0; 3]]),
            alphas: None,
            places: None,
        };
        let light = Lighting { towards: [0.0, 0.0, 1.0], ambient: 0.0 };
        let bounds = Rect { x0: 0, y0: 0, x1: 8, y1: 8 };
        let surface = Surface::new(
            &corners,
            &material(Shading::Flat),
            light,
            Seen::default(),
            &VIEWPORT,
            bounds,
        );
        for x in 0..8 {
            let s = (f64::from(x) + 0.5) / 8.0;
            let expected = (s / 4.0) / ((1.0 - s) + s / 4.0);
            let got = surface.at(x, 0) & 0xFF;
            assert_eq!(got, u32::from(color::byte(expected as f32)), "pixel {x}");
        }
    }

    #[test]
    fn lambert_and_gooch_at_known_angles() {
        let light = Lighting { towards: [0.0, 0.0, 1.0], ambient: 0.2 };
        let facing = [0.0, 0.0, 1.0];
        let away = [0.0, 0.0, -1.0];
        let c = [1.0, 0.5, 0.0];
        assert_eq!(light.shade(Shading::Lambert, c, facing, ALL), [1.0, 0.5, 0.0]);
        assert_eq!(light.shade(Shading::Lambert, c, away, ALL), [0.2, 0.1, 0.0]);
        assert_eq!(light.shade(Shading::Gooch, c, facing, ALL), [0.55, 0.425, 0.0]);
        assert_eq!(light.shade(Shading::Gooch, c, away, ALL), [0.25, 0.125, 0.55]);
        assert_eq!(light.shade(Shading::Flat, c, away, ALL), c);
        let half = [0.5, 0.0, 1.0];
        assert_eq!(light.shade(Shading::Lambert, c, facing, half), [0.6, 0.1, 0.0]);
        assert_eq!(light.shade(Shading::Gooch, c, facing, [0.0; 3]), [0.25, 0.125, 0.55]);
        assert_eq!(light.shade(Shading::Flat, c, facing, half), c);
    }
}
