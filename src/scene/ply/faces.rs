//! Faces and triangle strips.

use std::ops::Range;

use super::super::model::Unplaced;
use super::super::parts::{Cutter, Tally, first, in_order};
use super::header::{Element, Kind};
use super::payload::Payload;

/// How many faces are made triangles of by one thread at once.
const BLOCK: usize = 1 << 12;

/// Where lists of corners are, as a property of an element.
pub(super) fn indices(element: &Element) -> Option<usize> {
    let named = |name: &str| matches!(name, "vertex_indices" | "vertex_index");
    element.properties.iter().position(|p| named(&p.name) && !p.is_scalar())
}

/// The corners of all faces and strips, before the vertices are known.
#[derive(Debug, Default)]
pub(super) struct Faces {
    runs: Vec<Run>,
    /// Numbers of vertices, or [`AGAIN`] or [`ODD`].
    corners: Vec<u32>,
    /// Corners that no vertex can have as its number: where they stand, and what they are.
    odd: Vec<(usize, f64)>,
    /// The first face that has too few corners, and how many there are.
    few: Option<(usize, usize)>,
}

/// For -1, which begins a strip anew.
const AGAIN: u32 = u32::MAX;

/// For what is among the odd ones.
const ODD: u32 = u32::MAX - 1;

/// Faces of as many corners, one after the other in the file.
#[derive(Clone, Copy, Debug)]
struct Run {
    /// The number of the first in the file.
    first: usize,
    count: usize,
    size: usize,
    strip: bool,
}

/// A corner as it is kept.
pub(super) fn kept(value: f64) -> u32 {
    let number = value as u32;
    match f64::from(number).to_bits() == value.to_bits() && number < ODD {
        true => number,
        false if value == -1.0 => AGAIN,
        false => ODD,
    }
}

/// Whether a kept corner does not say what was read.
pub(super) fn is_odd(kept: u32) -> bool {
    kept == ODD
}

impl Faces {
    /// Reads the faces or strips from the number `from` on.
    pub(super) fn read(
        &mut self,
        payload: &mut Payload<'_>,
        element: &Element,
        from: usize,
        strip: bool,
    ) -> Unplaced<()> {
        let wanted = indices(element);
        for row in from..element.count {
            let start = self.corners.len();
            for (i, property) in element.properties.iter().enumerate() {
                let wrong = |problem: String| {
                    format!("{} {row}: {}: {problem}", element.name, property.name)
                };
                match property.kind {
                    Kind::List(length, item) if wanted == Some(i) => {
                        for _ in 0..payload.length(length).map_err(wrong)? {
                            self.push(payload.scalar(item).map_err(wrong)?);
                        }
                    }
                    kind => payload.skip(kind).map_err(wrong)?,
                }
            }
            payload.end_row();
            self.end(row, start, strip);
        }
        Ok(())
    }

    /// How many corners there are so far.
    pub(super) fn len(&self) -> usize {
        self.corners.len()
    }

    /// Adds a corner.
    pub(super) fn push(&mut self, value: f64) {
        let kept = kept(value);
        if kept == ODD {
            self.odd.push((self.corners.len(), value));
        }
        self.corners.push(kept);
    }

    /// Takes away all corners from the `start`th on.
    pub(super) fn truncate(&mut self, start: usize) {
        self.corners.truncate(start);
        self.odd.truncate(self.odd.partition_point(|(at, _)| *at < start));
    }

    /// Ends the face or strip of that number, whose corners are those from the `start`th on.
    pub(super) fn end(&mut self, number: usize, start: usize, strip: bool) {
        let size = self.corners.len() - start;
        if size < 3 && !strip {
            self.truncate(start);
        }
        self.run(Run { first: number, count: 1, size, strip });
    }

    /// Adds `count` faces or strips of `size` corners, `read` by parts from `corners` on and with the odd ones among
    /// them.
    pub(super) fn extend(
        &mut self,
        [first, count, size]: [usize; 3],
        strip: bool,
        read: impl FnOnce(&mut [u32]) -> Vec<(usize, f64)>,
    ) {
        if size >= 3 || strip {
            let start = self.corners.len();
            self.corners.resize(start + count * size, 0);
            let odd = read(&mut self.corners[start..]);
            self.odd.extend(odd.into_iter().map(|(at, value)| (start + at, value)));
        }
        self.run(Run { first, count, size, strip });
    }

    /// Adds faces whose numbers begin with `from`.
    pub(super) fn append(&mut self, from: usize, faces: Self) {
        let start = self.corners.len();
        self.corners.extend(faces.corners);
        self.odd.extend(faces.odd.into_iter().map(|(at, value)| (start + at, value)));
        faces.runs.into_iter().for_each(|run| self.run(Run { first: from + run.first, ..run }));
        if let Some((first, count)) = faces.few {
            self.left_out(from + first, count);
        }
    }

    /// Adds a run, to the last one if it goes on.
    fn run(&mut self, run: Run) {
        if run.size < 3 && !run.strip {
            return self.left_out(run.first, run.count);
        }
        let goes_on = |last: &&mut Run| {
            last.first + last.count == run.first && (last.size, last.strip) == (run.size, run.strip)
        };
        match self.runs.last_mut().filter(goes_on) {
            Some(last) => last.count += run.count,
            None => self.runs.push(run),
        }
    }

    fn left_out(&mut self, first: usize, count: usize) {
        self.few = Some(self.few.map_or((first, count), |(first, sum)| (first, sum + count)));
    }

    /// Says how many faces have too few corners.
    pub(super) fn say(&mut self, tally: &mut Tally) {
        let (first, count) = self.few.take().unwrap_or_default();
        for _ in 0..count {
            tally.add("faces of fewer than 3 corners are left out", || format!("face {first}"));
        }
    }

    /// All triangles. Each corner must be a vertex with a finite position.
    pub(super) fn triangles(
        self,
        places: &[[f64; 3]],
        tally: &mut Tally,
    ) -> Unplaced<Vec<[u32; 3]>> {
        let finite = |place: &[f64; 3]| place.iter().all(|c| c.is_finite());
        let all_finite = first(places, |place| !finite(place)).is_none();
        let sound = |triangle: &[u32; 3]| {
            triangle.iter().all(|&index| {
                places.get(index as usize).is_some_and(|place| all_finite || finite(place))
            })
        };
        let mut triangles = Vec::new();
        let mut start = 0;
        for run in &self.runs {
            let range = start..start + run.count * run.size;
            start = range.end;
            let mut sounds = 0;
            if run.size == 3 && !run.strip {
                let threes = self.corners[range.clone()].as_chunks().0;
                let broken = first(threes, |triangle| !sound(triangle));
                sounds = broken.unwrap_or(run.count);
                if sounds == self.corners.len() / 3 {
                    // That is all; it need not be in memory twice.
                    let whole = bytemuck::allocation::try_cast_slice_box(self.corners.into());
                    return whole
                        .map(|whole: Box<[[u32; 3]]>| whole.into_vec())
                        .map_err(|_| "face: the corners are no triangles".to_owned());
                }
                triangles.extend_from_slice(&threes[..sounds]);
            }
            let blocks: Vec<Range<usize>> = (sounds..run.count)
                .step_by(BLOCK)
                .map(|first| first..run.count.min(first + BLOCK))
                .collect();
            let read = |rows: &Range<usize>| self.cut(run, range.start, rows.clone(), places);
            in_order(&blocks, read, |found| {
                let (found, said) = found?;
                triangles.extend(found);
                tally.append(said);
                Ok::<_, String>(())
            })?;
        }
        Ok(triangles)
    }

    /// The triangles of some faces or strips of a run, whose corners begin with the `start`th.
    fn cut(
        &self,
        run: &Run,
        start: usize,
        rows: Range<usize>,
        places: &[[f64; 3]],
    ) -> Unplaced<(Vec<[u32; 3]>, Tally)> {
        let (mut triangles, mut tally) = (Vec::new(), Tally::default());
        let mut cutter = Cutter::default();
        let (mut outline, mut corners) = (Vec::new(), Vec::new());
        for row in rows {
            let (first, number) = (start + row * run.size, run.first + row);
            let range = first..first + run.size;
            if run.strip {
                let problem = |p| format!("tristrips {number}: vertex_indices: {p}");
                self.strip(range, places, &mut triangles).map_err(problem)?;
                continue;
            }
            corners.clear();
            for at in range {
                let corner = corner(self.value(at), places);
                corners.push(corner.map_err(|p| format!("face {number}: vertex_indices: {p}"))?);
            }
            outline.clear();
            outline.extend(corners.iter().map(|&i| places[i as usize]));
            let (cut, whole) = cutter.cut(&outline);
            if !whole {
                tally.add("the outline of the face crosses itself", || format!("face {number}"));
            }
            triangles.extend(cut.into_iter().map(|t| t.map(|i| corners[i as usize])));
        }
        Ok((triangles, tally))
    }

    /// The triangles of a strip.
    fn strip(
        &self,
        range: Range<usize>,
        places: &[[f64; 3]],
        triangles: &mut Vec<[u32; 3]>,
    ) -> Unplaced<()> {
        let (from, strip) = (range.start, &self.corners[range]);
        let mut at = from;
        // -1 begins the strip anew.
        for run in strip.split(|&index| index == AGAIN) {
            let own = at..at + run.len();
            at = own.end + 1;
            let run: Vec<u32> =
                own.map(|at| corner(self.value(at), places)).collect::<Unplaced<_>>()?;
            triangles.extend(run.windows(3).enumerate().map(|(i, w)| match i % 2 {
                0 => [w[0], w[1], w[2]],
                _ => [w[1], w[0], w[2]],
            }));
        }
        Ok(())
    }

    /// A corner as it was written.
    fn value(&self, at: usize) -> f64 {
        match self.corners[at] {
            AGAIN => -1.0,
            ODD => {
                let found = self.odd.binary_search_by_key(&at, |(at, _)| *at);
                found.map_or(f64::NAN, |i| self.odd[i].1)
            }
            index => index.into(),
        }
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
