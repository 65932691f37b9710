//! Faces and triangle strips.

use super::super::model::Unplaced;
use super::super::parts::{Cutter, Tally};
use super::header::{Element, Kind};
use super::payload::Payload;

/// Where lists of corners are, as a property of an element.
pub(super) fn indices(element: &Element) -> Option<usize> {
    let named = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
    element.properties.iter().position(|p| named(&p.name) && !p.is_scalar())
}

/// The corners of all faces and strips, before the vertices are known.
#[derive(Debug, Default)]
pub(super) struct Faces {
    /// Numbers of faces in the file, where their corners end, and whether they are strips.
    ends: Vec<(usize, usize, bool)>,
    corners: Vec<f64>,
}

impl Faces {
    pub(super) fn read_faces(
        &mut self,
        payload: &mut Payload<'_>,
        element: &Element,
        tally: &mut Tally,
    ) -> Unplaced<()> {
        for face in 0..element.count {
            let start = self.corners.len();
            self.read(payload, element, face)?;
            let corners = self.corners.len() - start;
            if corners < 3 {
                self.corners.truncate(start);
                tally.add("faces of fewer than 3 corners are left out", || format!("face {face}"));
            } else {
                self.ends.push((face, self.corners.len(), false));
            }
        }
        Ok(())
    }

    pub(super) fn read_strips(
        &mut self,
        payload: &mut Payload<'_>,
        element: &Element,
    ) -> Unplaced<()> {
        for strip in 0..element.count {
            self.read(payload, element, strip)?;
            self.ends.push((strip, self.corners.len(), true));
        }
        Ok(())
    }

    fn read(&mut self, payload: &mut Payload<'_>, element: &Element, row: usize) -> Unplaced<()> {
        let wanted = indices(element);
        for (i, property) in element.properties.iter().enumerate() {
            let wrong =
                |problem: String| format!("{} {row}: {}: {problem}", element.name, property.name);
            match property.kind {
                Kind::List(length, item) if wanted == Some(i) => {
                    for _ in 0..payload.length(length).map_err(wrong)? {
                        self.corners.push(payload.scalar(item).map_err(wrong)?);
                    }
                }
                kind => payload.skip(kind).map_err(wrong)?,
            }
        }
        payload.end_row();
        Ok(())
    }

    /// All triangles. Each corner must be a vertex with a finite position.
    pub(super) fn triangles(
        &self,
        places: &[[f64; 3]],
        tally: &mut Tally,
    ) -> Unplaced<Vec<[u32; 3]>> {
        let mut triangles = Vec::with_capacity(self.ends.len());
        let mut cutter = Cutter::default();
        let (mut outline, mut start) = (Vec::new(), 0);
        for &(number, end, strip) in &self.ends {
            let corners = &self.corners[start..end];
            start = end;
            let corner = |&index: &f64| corner(index, places);
            if strip {
                // -1 begins the strip anew.
                for run in corners.split(|&index| index == -1.0) {
                    let run = run.iter().map(corner).collect::<Unplaced<Vec<_>>>();
                    let run =
                        run.map_err(|p| format!("tristrips {number}: vertex_indices: {p}"))?;
                    triangles.extend(run.windows(3).enumerate().map(|(i, w)| match i % 2 {
                        0 => [w[0], w[1], w[2]],
                        _ => [w[1], w[0], w[2]],
                    }));
                }
                continue;
            }
            let corners = corners.iter().map(corner).collect::<Unplaced<Vec<_>>>();
            let corners =
                corners.map_err(|problem| format!("face {number}: vertex_indices: {problem}"))?;
            outline.clear();
            outline.extend(corners.iter().map(|&i| places[i as usize]));
            let (cut, whole) = cutter.cut(&outline);
            if !whole {
                tally.add("the outline of the face crosses itself", || format!("face {number}"));
            }
            triangles.extend(cut.into_iter().map(|t| t.map(|i| corners[i as usize])));
        }
        Ok(triangles)
    }
}

fn corner(index: f64, places: &[[f64; 3]]) -> Unplaced<u32> {
    let count = places.len();
    if !(index >= 0.0 && index.fract() == 0.0 && index < count as f64) {
        return Err(format!("{index} is not below the {count} vertices"));
    }
    let place = places[index as usize];
    if !place.iter().all(|c| c.is_finite()) {
        return Err(format!("vertex {index}: position {place:?} is not finite"));
    }
    Ok(index as u32)
}
