//! Which object a fragment belongs to, by its global triangle index.

use crate::scene::Scene;

/// A scene's objects by name, and where their triangles are.
#[derive(Clone, Debug)]
pub struct Solids {
    names: Vec<String>,
    parts: Vec<Part>,
}

/// A mesh's triangles: those below `end` that no earlier part has.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    end: u32,
    /// Which object: an index into [`Solids::names`].
    pub solid: usize,
    /// Index into the scene's materials.
    pub material: usize,
}

impl Solids {
    /// Of a scene; meshes of the same name are one object.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let (mut names, mut parts) = (Vec::<String>::new(), Vec::new());
        let mut end = 0;
        for object in &scene.objects {
            end += object.mesh.primitives() as u32;
            let known = names.iter().position(|name| *name == object.name);
            let solid = known.unwrap_or(names.len());
            if known.is_none() {
                names.push(object.name.clone());
            }
            parts.push(Part { end, solid, material: object.material });
        }
        Self { names, parts }
    }

    /// In the order of their first meshes.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The meshes in the order of their triangles.
    #[must_use]
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// The mesh that a triangle belongs to; `None` for screen triangles.
    #[inline]
    #[must_use]
    pub fn part(&self, triangle: u32) -> Option<Part> {
        let place = self.parts.partition_point(|part| part.end <= triangle);
        self.parts.get(place).copied()
    }
}

impl Part {
    /// The first triangle behind it.
    #[must_use]
    pub fn end(&self) -> u32 {
        self.end
    }
}
