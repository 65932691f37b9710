//! MTL: colour, opacity and pictures. A line that is wrong is left out with a warning.

use std::ops::RangeInclusive;

use super::super::Material;
use super::super::parts::{Tally, decode};
use super::picture::Map;
use super::statement::{number, split, statements};

/// What a library says of one material.
#[derive(Clone, Debug, Default)]
pub(super) struct Look {
    pub(super) name: String,
    kd: Option<[f64; 3]>,
    d: Option<f64>,
    tr: Option<f64>,
    /// Pictures of the colour and the opacity.
    pub(super) color: Option<Map>,
    pub(super) opacity: Option<Map>,
    /// The folder of the library, relative to what names it.
    pub(super) folder: String,
    /// Files that are named as pictures of anything, relative to the library or to what names it.
    pub(super) named: Vec<String>,
    /// What is wrong with lines.
    problems: Vec<String>,
}

/// The materials of a library.
pub(super) fn parse(bytes: &[u8], place: &str) -> Vec<Look> {
    let mut looks: Vec<Look> = Vec::new();
    for (line, text) in statements(&decode(bytes)) {
        let (keyword, rest) = split(&text);
        if keyword == "newmtl" {
            looks.push(Look { name: rest.to_owned(), ..Look::default() });
        } else if let Some(look) = looks.last_mut()
            && let Err(problem) = look.line(keyword, rest)
        {
            look.problems.push(format!("{place}: line {line}: {problem}"));
        }
    }
    looks
}

/// Other keywords before the names of pictures.
const PICTURES: [&str; 6] = ["bump", "disp", "decal", "refl", "norm", "disp_map"];

impl Look {
    fn line(&mut self, keyword: &str, rest: &str) -> Result<(), String> {
        if keyword.starts_with("map_") || PICTURES.contains(&keyword) {
            self.named.push(Map::parse(rest).name);
        }
        match keyword {
            // The other forms give a spectrum or CIE coordinates, which are not used in practice.
            "Kd" if rest.starts_with("spectral") || rest.starts_with("xyz") => {}
            "Kd" => match numbers(rest, "Kd", 1..=3)?[..] {
                // One number stands for all three.
                [one] => self.kd = Some([one; 3]),
                [r, g, b] => self.kd = Some([r, g, b]),
                _ => return Err("Kd: needs 3 numbers, not 2".to_owned()),
            },
            "d" => {
                self.d = Some(numbers(rest.trim_start_matches("-halo"), "d", 1..=1)?[0]);
            }
            "Tr" => self.tr = Some(numbers(rest, "Tr", 1..=1)?[0]),
            "map_Kd" => self.color = Some(Map::parse(rest)),
            "map_d" => self.opacity = Some(Map::parse(rest)),
            _ => {}
        }
        Ok(())
    }

    /// Kd is the colour, `plain` where there is none; d, or else 1 - Tr, the opacity.
    pub(super) fn material(&self, plain: [f32; 3], tally: &mut Tally) -> Material {
        for problem in &self.problems {
            tally.add("the line is left out", || problem.clone());
        }
        let name = &self.name;
        let mut channel =
            |value, field| tally.clamped(value, || format!("material {name:?}: {field}"));
        // What the library does not say must not darken a picture.
        let plain = if self.color.is_some() { [1.0; 3] } else { plain };
        let color = self.kd.map_or(plain, |kd| kd.map(|value| channel(value, "Kd")));
        let alpha = self.d.or(self.tr.map(|tr| 1.0 - tr)).unwrap_or(1.0);
        let alpha = channel(alpha, "opacity by d or Tr");
        Material::new(name, color, alpha)
    }
}

/// Finite numbers, as many as `count` allows.
fn numbers(rest: &str, field: &str, count: RangeInclusive<usize>) -> Result<Vec<f64>, String> {
    let values = rest.split_whitespace().map(number).collect::<Result<Vec<_>, _>>();
    let values = values.map_err(|problem| format!("{field}: {problem}"))?;
    if count.contains(&values.len()) {
        return Ok(values);
    }
    let (low, high) = count.into_inner();
    let need = if low == high { low.to_string() } else { format!("{low} to {high}") };
    Err(format!("{field}: needs {need} numbers, not {}", values.len()))
}
