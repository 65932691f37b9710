//! Piece by piece: vertices are kept, faces become triangles at once.

use std::collections::{BTreeMap, BTreeSet};

use super::super::model::Unplaced;
use super::super::parts::{Cutter, Tally};
use super::group::{Group, Seen};
use super::piece::{Kind, Piece, Run, Written};
use super::statement::{clipped, number, split, statement, statements};
use super::vertices::{Corner, NONE, Vertices};

/// What is said of a face that is not covered once.
const CROSSES: &str = "the outline of the face crosses itself";

/// What a file says besides its faces.
#[derive(Debug, Default)]
pub(super) struct Said {
    /// The names of materials, by number; the first is that of faces without one.
    pub(super) names: Vec<String>,
    /// The rest of each `mtllib` line, once.
    pub(super) libraries: Vec<String>,
    /// Whether vertices have colours.
    pub(super) colored: bool,
    pub(super) tally: Tally,
}

/// The file so far.
#[derive(Default)]
pub(super) struct Reader {
    vertices: Vertices,
    /// What is wrong with vertices, by number; no face may use them.
    broken: BTreeMap<usize, (usize, String)>,
    /// How many faces have normals at all corners, and how many do not.
    faces: [usize; 2],
    numbers: BTreeMap<String, usize>,
    libraries: BTreeSet<String>,
    group: Group,
    groups: Vec<Group>,
    /// Which vertices the group has.
    seen: Seen,
    said: Said,
    cutter: Cutter,
    /// How many lines there are so far.
    lines: usize,
    /// The corners of a face, in memory that is used again.
    corners: Vec<Corner>,
}

impl Reader {
    /// Takes over what the next lines say.
    pub(super) fn piece(&mut self, piece: &Piece<'_>) -> Unplaced<()> {
        let (mut positions, mut colors) = (&piece.positions[..], piece.colors.iter());
        let (mut normals, mut places) = (&piece.normals[..], &piece.places[..]);
        let mut corners = &piece.corners[..];
        for run in &piece.runs {
            match run.kind {
                Kind::Vertices => {
                    self.vertices.positions.extend_from_slice(first(&mut positions, run.count));
                }
                Kind::Colored => {
                    for position in first(&mut positions, run.count) {
                        self.vertices.positions.push(*position);
                        colors.next().into_iter().for_each(|c| self.vertices.color(*c, None));
                    }
                }
                Kind::Normals => {
                    self.vertices.normals.extend_from_slice(first(&mut normals, run.count));
                }
                Kind::Places => {
                    self.vertices.places.extend_from_slice(first(&mut places, run.count));
                }
                Kind::Faces(size) => {
                    self.faces(piece.text, run, size, first(&mut corners, run.count * size))?;
                }
                Kind::Other => self.numbered(run.line, &statement(&piece.text[run.at..]).0)?,
            }
        }
        self.lines += piece.lines;
        Ok(())
    }

    /// A run of faces of `size` corners.
    fn faces(&mut self, text: &str, run: &Run, size: usize, corners: &[Written]) -> Unplaced<()> {
        for (i, face) in corners.chunks_exact(size).enumerate() {
            let lines = || statements(&text[run.at..]).take(run.count).skip(i);
            if self.resolved(face).is_none() {
                // Something is to be said of it, and perhaps of all that follow.
                return (i..)
                    .zip(lines())
                    .try_for_each(|(i, (_, line))| self.numbered(run.line + i, &line));
            }
            let mut corners = std::mem::take(&mut self.corners);
            if !self.add(&mut corners) {
                let number = self.lines + run.line + i + 1;
                self.said.tally.add(CROSSES, || {
                    let line = lines().next().map(|(_, line)| clipped(split(&line).1));
                    format!("line {number}: f {}", line.unwrap_or_default())
                });
            }
            self.corners = corners;
        }
        Ok(())
    }

    /// A statement that stands behind `before` lines of its piece.
    fn numbered(&mut self, before: usize, text: &str) -> Unplaced<()> {
        let line = self.lines + before + 1;
        self.line(line, text).map_err(|problem| format!("line {line}: {problem}"))
    }

    /// Reads one line.
    pub(super) fn line(&mut self, line: usize, text: &str) -> Unplaced<()> {
        let (keyword, rest) = split(text);
        let mut left_out =
            |kind| self.said.tally.add(kind, || format!("line {line}: {}", clipped(text.trim())));
        match keyword {
            "v" => self.vertex(line, rest),
            "vn" => self.normal(line, rest),
            "vt" => {
                let values: Vec<_> = rest.split_whitespace().map(number).collect();
                // v goes up from the lower edge; it may be missing.
                let place = match values[..] {
                    [Ok(u), Ok(v), ..] => [u, 1.0 - v],
                    [Ok(u)] => [u, 1.0],
                    _ => [f64::NAN; 2],
                };
                self.vertices.places.push(place.map(|c| c as f32));
                if values.iter().any(Result::is_err) {
                    left_out("texture coordinates are wrong; they are not used");
                }
            }
            "f" | "fo" => return self.face(line, rest),
            "usemtl" => self.material(rest),
            "mtllib" => self.library(rest),
            "o" | "g" => self.begin(self.group.material),
            "l" => left_out("lines are not drawn"),
            "p" => left_out("points are not drawn"),
            "curv" | "curv2" | "surf" => left_out("free-form curves and surfaces are not drawn"),
            _ => {}
        }
        Ok(())
    }

    /// A line that names libraries, each line once.
    fn library(&mut self, names: &str) {
        if !names.is_empty() && self.libraries.insert(names.to_owned()) {
            self.said.libraries.push(names.to_owned());
        }
    }

    /// The groups with faces, and the rest.
    pub(super) fn finish(mut self) -> (Vec<Group>, Said) {
        self.begin(0);
        let mut groups = std::mem::take(&mut self.groups);
        groups.iter_mut().for_each(|group| group.collect(&self.vertices));
        let mut said = std::mem::take(&mut self.said);
        said.colored = self.vertices.colors().is_some();
        if said.names.is_empty() {
            said.names.push(String::new());
        }
        for (line, problem) in self.broken.values() {
            said.tally.add("no face uses the vertex, it is left out", || {
                format!("line {line}: v: {problem}")
            });
        }
        if self.vertices.is_mixed() {
            let first = || "v: only some vertices have colours".to_owned();
            said.tally.add("all colours are left out", first);
        }
        if self.faces[0] != 0 && self.faces[1] != 0 {
            let first = || "f: only some faces have normals".to_owned();
            said.tally.add("groups that mix them have none", first);
        }
        (groups, said)
    }

    fn begin(&mut self, material: usize) {
        let group = std::mem::replace(&mut self.group, Group::new(material));
        self.seen.begin();
        if !group.triangles.is_empty() {
            self.groups.push(group);
        }
    }

    fn material(&mut self, name: &str) {
        if self.said.names.is_empty() {
            self.said.names.push(String::new());
            self.numbers.insert(String::new(), 0);
        }
        let next = self.said.names.len();
        let material = *self.numbers.entry(name.to_owned()).or_insert(next);
        if material == next {
            self.said.names.push(name.to_owned());
        }
        if material != self.group.material {
            self.begin(material);
        }
    }

    /// `x y z`, then nothing, w, r g b or r g b a.
    fn vertex(&mut self, line: usize, rest: &str) {
        let values: Vec<_> = rest.split_whitespace().map(number).collect();
        let position = match &values[..] {
            [Ok(x), Ok(y), Ok(z), ..] => Ok([*x, *y, *z]),
            [x, y, z, ..] => {
                Err([x, y, z].into_iter().find_map(|v| v.clone().err()).unwrap_or_default())
            }
            few => Err(format!("needs 3 to 7 numbers, not {}", few.len())),
        };
        let place = self.vertices.positions.len();
        self.vertices.positions.push(position.unwrap_or_else(|problem| {
            self.broken.insert(place, (line, problem));
            [0.0; 3]
        }));
        let tally = &mut self.said.tally;
        match &values[..] {
            [_, _, _] => {}
            [_, _, _, Ok(w)] if *w == 1.0 => {}
            // Some readers divide by it; the format and most readers do not.
            [_, _, _, _] => tally.add("w is a weight of free-form curves, and not used", || {
                format!("line {line}: v {}", clipped(rest))
            }),
            [_, _, _, Ok(r), Ok(g), Ok(b), rest @ ..] if rest.len() <= 1 => {
                let mut channel = |value| tally.clamped(value, || format!("line {line}: v: color"));
                let color = [*r, *g, *b].map(&mut channel);
                let alpha = match rest {
                    [Ok(alpha)] => Some(channel(*alpha)),
                    _ => None,
                };
                self.vertices.color(color, alpha);
            }
            more if more.len() > 3 => {
                tally.add("what follows x y z is no colour, and is left out", || {
                    format!("line {line}: v {}", clipped(rest))
                });
            }
            _ => {}
        }
    }

    fn normal(&mut self, line: usize, rest: &str) {
        let values: Vec<_> = rest.split_whitespace().map(number).collect();
        let normal = match values[..] {
            [Ok(x), Ok(y), Ok(z)] => [x, y, z].map(|v| v as f32),
            _ => [f32::NAN; 3],
        };
        if !normal.iter().all(|v| v.is_finite()) {
            self.said.tally.add("is no normal; faces that use it have none", || {
                format!("line {line}: vn {}", clipped(rest))
            });
        }
        self.vertices.normals.push(normal);
    }

    fn face(&mut self, line: usize, rest: &str) -> Unplaced<()> {
        let words: Vec<&str> = rest.split_whitespace().collect();
        if words.len() < 3 {
            self.said.tally.add("faces of fewer than 3 corners are left out", || {
                format!("line {line}: f {}", clipped(rest))
            });
            return Ok(());
        }
        let corners = words.into_iter().map(|word| self.corner(line, word));
        let mut corners = corners.collect::<Unplaced<Vec<_>>>()?;
        if !self.add(&mut corners) {
            self.said.tally.add(CROSSES, || format!("line {line}: f {}", clipped(rest)));
        }
        Ok(())
    }

    /// Adds a face; whether its triangles cover it once.
    fn add(&mut self, corners: &mut [Corner]) -> bool {
        let smooth = corners.iter().all(|corner| corner.normal != NONE);
        self.faces[usize::from(smooth)] += 1;
        if !smooth {
            corners.iter_mut().for_each(|corner| corner.normal = NONE);
        }
        let mut triangle = |corners: [Corner; 3]| {
            let triangle = corners.map(|corner| self.group.corner(corner, &mut self.seen));
            self.group.triangles.push(triangle);
        };
        if let [a, b, c] = *corners {
            triangle([a, b, c]);
            return true;
        }
        let outline: Vec<_> =
            corners.iter().map(|c| self.vertices.positions[c.vertex as usize]).collect();
        let (triangles, whole) = self.cutter.cut(&outline);
        triangles.into_iter().for_each(|t| triangle(t.map(|i| corners[i as usize])));
        whole
    }

    /// Puts the corners of a face into `corners`; `None` if anything is to be said of one.
    fn resolved(&mut self, face: &[Written]) -> Option<()> {
        let vertices = &self.vertices;
        let counts = [vertices.positions.len(), vertices.places.len(), vertices.normals.len()];
        self.corners.clear();
        for written in face {
            let mut at = [None; 3];
            for ((at, &written), count) in at.iter_mut().zip(written).zip(counts) {
                *at = match written {
                    0 => None,
                    index => Some(absolute(index.into(), count)?),
                };
            }
            let [vertex, place, normal] = at;
            let vertex = vertex.filter(|vertex| !self.broken.contains_key(vertex))?;
            self.corners.push(vertices.corner(vertex, place, normal));
        }
        Some(())
    }

    /// One corner `v`, `v/vt`, `v//vn` or `v/vt/vn`.
    fn corner(&mut self, line: usize, word: &str) -> Unplaced<Corner> {
        let mut parts = word.split('/');
        let vertex = index(parts.next(), "vertex", self.vertices.positions.len())?;
        let texcoord = index(parts.next(), "texture coordinate", self.vertices.places.len());
        let normal = index(parts.next(), "normal", self.vertices.normals.len());
        let (Some(vertex), None) = (vertex, parts.next()) else {
            return Err(format!("f: {:?} is not v, v/vt, v//vn or v/vt/vn", clipped(word)));
        };
        if let Some((line, problem)) = self.broken.get(&vertex) {
            return Err(format!("f: vertex {} of line {line}: {problem}", vertex + 1));
        }
        let mut left_out = |problem: String| {
            self.said.tally.add("it is left out", || format!("line {line}: {problem}"));
            None
        };
        let texcoord = texcoord.unwrap_or_else(&mut left_out);
        let normal = normal.unwrap_or_else(&mut left_out);
        Ok(self.vertices.corner(vertex, texcoord, normal))
    }
}

/// Takes the first of a list away.
fn first<'a, T>(list: &mut &'a [T], count: usize) -> &'a [T] {
    let (first, rest) = list.split_at(count);
    *list = rest;
    first
}

/// An index of a face's corner, made absolute, from 0; `None` where it is left out.
fn index(word: Option<&str>, field: &str, count: usize) -> Unplaced<Option<usize>> {
    let Some(word) = word.filter(|word| !word.is_empty()) else { return Ok(None) };
    let number: i64 =
        word.parse().map_err(|_| format!("f: {:?} is not an index", clipped(word)))?;
    let found = absolute(number, count).map(Some);
    found.ok_or_else(|| format!("f: {field} {number} is not among the {count} so far"))
}

/// An index that counts from 1, or back from the last, from 0.
fn absolute(number: i64, count: usize) -> Option<usize> {
    let count = count as i64;
    let absolute = if number < 0 { number.saturating_add(count + 1) } else { number };
    (1..=count).contains(&absolute).then(|| absolute as usize - 1)
}
