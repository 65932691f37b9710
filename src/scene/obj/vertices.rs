//! The vertices and normals of a whole file.

/// The number of a normal, or of texture coordinates, that are not there.
pub(super) const NONE: u32 = u32::MAX;

/// A corner of a face, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Corner {
    pub(super) vertex: u32,
    /// Or [`NONE`].
    pub(super) normal: u32,
    /// Or [`NONE`].
    pub(super) texcoord: u32,
}

/// By number, from 0.
#[derive(Debug, Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<[f64; 3]>,
    /// Not finite where they are broken.
    pub(super) normals: Vec<[f32; 3]>,
    /// In a picture, from its upper left corner; not finite where they are broken.
    pub(super) places: Vec<[f32; 2]>,
    /// As many as positions, if all vertices have one.
    colors: Vec<[f32; 3]>,
    alphas: Vec<f32>,
    colored: usize,
    translucent: bool,
}

impl Vertices {
    /// The corner of a face, without what is broken.
    pub(super) fn corner(
        &self,
        vertex: usize,
        texcoord: Option<usize>,
        normal: Option<usize>,
    ) -> Corner {
        let whole = |&normal: &usize| self.normals[normal].iter().all(|v| v.is_finite());
        let lies = |&at: &usize| self.places[at].iter().all(|c| c.is_finite());
        Corner {
            vertex: vertex as u32,
            normal: normal.filter(whole).map_or(NONE, |normal| normal as u32),
            texcoord: texcoord.filter(lies).map_or(NONE, |texcoord| texcoord as u32),
        }
    }

    /// Gives the last vertex a colour, and perhaps an opacity.
    pub(super) fn color(&mut self, color: [f32; 3], alpha: Option<f32>) {
        let place = self.positions.len().saturating_sub(1);
        self.colors.resize(place, [1.0; 3]);
        self.colors.push(color);
        self.alphas.resize(place, 1.0);
        self.alphas.push(alpha.unwrap_or(1.0));
        self.translucent |= alpha.is_some();
        self.colored += 1;
    }

    /// Whether only some vertices have colours.
    pub(super) fn is_mixed(&self) -> bool {
        self.colored != 0 && self.colored != self.positions.len()
    }

    /// The colours, if all vertices have one.
    pub(super) fn colors(&self) -> Option<&[[f32; 3]]> {
        (self.colored > 0 && !self.is_mixed()).then_some(&self.colors)
    }

    /// The opacities, if colours count and any vertex has one.
    pub(super) fn alphas(&self) -> Option<&[f32]> {
        self.colors().and_then(|_| self.translucent.then_some(&self.alphas[..]))
    }
}
