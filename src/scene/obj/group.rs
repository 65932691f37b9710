//! The faces between two lines that begin a new object.

use std::collections::BTreeMap;

use super::super::Mesh;
use super::vertices::{Corner, NONE, Vertices};

/// The most corners of one vertex that are looked through one by one.
const MOST: usize = 8;

/// By vertex, where the present group has it: a list for all groups, since there may be many.
#[derive(Debug, Default)]
pub(super) struct Seen {
    /// The number of the group, and the last corner of the vertex in it.
    last: Vec<(u32, u32)>,
    group: u32,
}

impl Seen {
    /// Begins a new group.
    pub(super) fn begin(&mut self) {
        self.group += 1;
    }

    /// The place of a vertex's last corner, or [`NONE`].
    fn last(&mut self, vertex: u32) -> &mut u32 {
        let vertex = vertex as usize;
        if self.last.len() <= vertex {
            self.last.resize(vertex + 1, (0, NONE));
        }
        let (group, last) = &mut self.last[vertex];
        if *group != self.group {
            (*group, *last) = (self.group, NONE);
        }
        last
    }
}

/// A group of triangles of one material.
#[derive(Debug, Default)]
pub(super) struct Group {
    /// Its number among the names of materials.
    pub(super) material: usize,
    /// The vertices in the order of their first use.
    corners: Vec<Corner>,
    /// By number in `corners`: the corner of the same vertex before it, or [`NONE`].
    before: Vec<u32>,
    /// Where corners stand whose vertex has [`MOST`] others.
    places: BTreeMap<Corner, u32>,
    /// By number in `corners`.
    pub(super) triangles: Vec<[u32; 3]>,
    mesh: Mesh,
}

impl Group {
    pub(super) fn new(material: usize) -> Self {
        Self { material, ..Self::default() }
    }

    /// The number of a corner here. `seen` is that of this group.
    pub(super) fn corner(&mut self, corner: Corner, seen: &mut Seen) -> u32 {
        let next = self.corners.len() as u32;
        let last = seen.last(corner.vertex);
        let (mut at, mut passed) = (*last, 0);
        while at != NONE && passed < MOST {
            if self.corners[at as usize] == corner {
                return at;
            }
            (at, passed) = (self.before[at as usize], passed + 1);
        }
        if passed == MOST {
            let place = *self.places.entry(corner).or_insert(next);
            if place != next {
                return place;
            }
            self.before.push(NONE);
        } else {
            self.before.push(*last);
            *last = next;
        }
        self.corners.push(corner);
        next
    }

    /// Takes the vertices over from the whole file.
    pub(super) fn collect(&mut self, all: &Vertices) {
        (self.places, self.before) = (BTreeMap::new(), Vec::new());
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
