//! The vertices and normals of a whole file.

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
