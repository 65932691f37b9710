//! The faces between two lines that begin a new object.

use std::collections::BTreeMap;

use super::super::Mesh;
use super::vertices::Vertices;

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

/// A group of triangles of one material.
#[derive(Debug, Default)]
pub(super) struct Group {
    /// Its number among the names of materials.
    pub(super) material: usize,
    /// The vertices in the order of their first use.
    corners: Vec<Corner>,
    /// Where they stand in `corners`.
    places: BTreeMap<Corner, u32>,
    /// By number in `corners`.
    pub(super) triangles: Vec<[u32; 3]>,
    mesh: Mesh,
}

impl Group {
    pub(super) fn new(material: usize) -> Self {
        Self { material, ..Self::default() }
    }

    /// The number of a corner here.
    pub(super) fn corner(&mut self, corner: Corner) -> u32 {
        let next = self.corners.len() as u32;
        let place = *self.places.entry(corner).or_insert(next);
        if place == next {
            self.corners.push(corner);
        }
        place
    }

    /// Takes the vertices over from the whole file.
    pub(super) fn collect(&mut self, all: &Vertices) {
        self.places = BTreeMap::new();
        let vertices = || self.corners.iter().map(|corner| corner.vertex as usize);
        let smooth = self.corners.iter().all(|corner| corner.normal != NONE);
        let normals = self.corners.iter().map(|corner| all.normals[corner.normal as usize]);
        let lies = self.corners.iter().all(|corner| corner.texcoord != NONE);
        let places = self.corners.iter().map(|corner| all.places[corner.texcoord as usize]);
        self.mesh = Mesh {
            positions: vertices().map(|v| all.positions[v]).collect(),
            normals: if smooth { normals.collect() } else { Vec::new() },
            colors: all.colors().map_or(Vec::new(), |c| vertices().map(|v| c[v]).collect()),
            alphas: all.alphas().map_or(Vec::new(), |a| vertices().map(|v| a[v]).collect()),
            places: if lies { places.collect() } else { Vec::new() },
            triangles: std::mem::take(&mut self.triangles),
            ..Mesh::default()
        };
        self.corners = Vec::new();
    }

    /// After [`Group::collect`].
    pub(super) fn mesh(self) -> Mesh {
        self.mesh
    }
}
