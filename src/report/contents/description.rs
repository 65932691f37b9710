//! What is in a scene, for people: the same content as the JSON document, with many objects summed up.

use super::{Body, Complexity, Contents, Extent, Look, Solid, View};
use crate::report::text::{Align, columns, percent, thousands};

/// More rows than these are summed up.
const MOST: usize = 20;

/// The whole text.
#[must_use]
pub fn description(contents: &Contents) -> String {
    let Contents { scene, kind, width, height, .. } = contents;
    let mut text = format!("{scene}: {kind}, {width}x{height}\n\n");
    text += &facts(contents);
    text += &format!("\ndepth complexity\n{}", complexity(contents));
    let parts = [
        ("objects", objects(&contents.objects)),
        ("materials", materials(&contents.materials)),
        ("volumes", volumes(contents)),
        ("cameras of its files", cameras(&contents.cameras)),
        ("warnings", contents.warnings.iter().map(|w| format!("{w}\n")).collect()),
    ];
    for (heading, part) in parts {
        if !part.is_empty() {
            text += &format!("\n{heading}\n{part}");
        }
    }
    text
}

/// Six digits of a number.
fn short(number: f64) -> String {
    format!("{number:.5e}").parse().unwrap_or(number).to_string()
}

fn triple(numbers: [f64; 3]) -> String {
    format!("({})", numbers.map(short).join(", "))
}

fn wide(numbers: [f32; 3]) -> [f64; 3] {
    numbers.map(f64::from)
}

fn extent(Extent { min, max }: Extent) -> String {
    format!("{} to {}", triple(min), triple(max))
}

/// Names and what they are, in two columns.
fn pairs(rows: Vec<(&str, String)>) -> String {
    let rows: Vec<Vec<String>> = rows.into_iter().map(|(n, value)| vec![n.into(), value]).collect();
    columns(&[Align::Left; 2], &rows)
}

fn facts(contents: &Contents) -> String {
    let View { eye, target, up, projection, fov_y, ortho_height, near, far } = contents.camera;
    let reach = match (fov_y, ortho_height) {
        (Some(degrees), _) => format!(", {} degrees high", short(degrees)),
        (None, Some(height)) => format!(", {} high", short(height)),
        (None, None) => String::new(),
    };
    let light = &contents.light;
    pairs(vec![
        ("triangles", thousands(contents.triangles)),
        ("points", thousands(contents.discs)),
        ("in pixels", thousands(contents.screen_triangles)),
        ("bounds", contents.bounds.map_or_else(|| "-".to_owned(), extent)),
        ("camera at", triple(eye)),
        ("looks to", triple(target)),
        ("up", triple(up)),
        ("projection", format!("{projection}{reach}")),
        ("planes", format!("{} to {}", short(near), short(far))),
        (
            "light from",
            format!("{}, ambient {}", triple(light.towards), short(light.ambient.into())),
        ),
        ("background", triple(wide(contents.background))),
    ])
}

fn complexity(contents: &Contents) -> String {
    let Complexity { max, mean, covered_pixels, fragments, degenerate } = contents.depth_complexity;
    let pixels = u64::from(contents.width) * u64::from(contents.height);
    let share = percent(covered_pixels, pixels);
    pairs(vec![
        ("max", thousands(max)),
        ("mean", format!("{mean:.2} where there are any")),
        ("pixels", format!("{} of {}, {share}", thousands(covered_pixels), thousands(pixels))),
        ("fragments", thousands(fragments)),
        ("no area", format!("{} triangles and points at this size", thousands(degenerate))),
    ])
}

fn objects(solids: &[Solid]) -> String {
    if solids.len() > MOST {
        return many_objects(solids);
    }
    let closed = |solid: &Solid| match solid.closed {
        Some(true) => "yes".to_owned(),
        Some(false) => format!("no, {} open edges", thousands(solid.open_edges)),
        None => "-".to_owned(),
    };
    let row = |solid: &Solid| {
        vec![
            solid.name.clone(),
            thousands(solid.meshes),
            thousands(solid.triangles),
            thousands(solid.discs),
            thousands(solid.degenerate),
            closed(solid),
            named(&solid.materials),
        ]
    };
    let head = ["name", "meshes", "triangles", "points", "no area", "closed", "materials"];
    let [left, right] = [Align::Left, Align::Right];
    table(head, [left, right, right, right, right, left, left], solids.iter().map(row))
}

/// A heading and rows, or nothing without rows.
fn table<const N: usize>(
    head: [&str; N],
    aligned: [Align; N],
    rows: impl Iterator<Item = Vec<String>>,
) -> String {
    let head = std::iter::once(head.map(str::to_owned).to_vec());
    let rows: Vec<Vec<String>> = head.chain(rows).collect();
    if rows.len() > 1 { columns(&aligned, &rows) } else { String::new() }
}

/// Some names, or how many there are.
fn named(names: &[String]) -> String {
    if names.len() > 3 { thousands(names.len() as u64) } else { names.join(", ") }
}

fn many_objects(solids: &[Solid]) -> String {
    let sum = |of: fn(&Solid) -> u64| thousands(solids.iter().map(of).sum());
    pairs(vec![
        ("number", thousands(solids.len() as u64)),
        ("meshes", sum(|solid| solid.meshes)),
        ("triangles", sum(|solid| solid.triangles)),
        ("points", sum(|solid| solid.discs)),
        ("no area", sum(|solid| solid.degenerate)),
        ("closed", sum(|solid| u64::from(solid.closed == Some(true)))),
        ("not closed", sum(|solid| u64::from(solid.closed == Some(false)))),
    ])
}

fn materials(looks: &[Look]) -> String {
    if looks.len() > MOST {
        let alphas = || looks.iter().map(|look| f64::from(look.alpha));
        let [low, high] = [alphas().fold(1.0, f64::min), alphas().fold(0.0, f64::max)].map(short);
        return pairs(vec![
            ("number", thousands(looks.len() as u64)),
            ("opacity", format!("{low} to {high}")),
        ]);
    }
    let row = |look: &Look| {
        vec![
            look.name.clone(),
            triple(wide(look.color)),
            short(look.alpha.into()),
            look.shading.to_owned(),
            look.picture.map_or_else(|| "-".to_owned(), |[w, h]| format!("{w}x{h}")),
        ]
    };
    let [left, right] = [Align::Left, Align::Right];
    let head = ["name", "color", "opacity", "shading", "picture"];
    table(head, [left, left, right, left, left], looks.iter().map(row))
}

/// Their numbers and names.
fn cameras(cameras: &[[String; 2]]) -> String {
    let row = |(i, names): (usize, &[String; 2])| {
        let names = names.iter().filter(|name| !name.is_empty());
        let names: Vec<String> = names.map(|name| format!("{name:?}")).collect();
        vec![i.to_string(), names.join(", ")]
    };
    let rows: Vec<Vec<String>> = cameras.iter().take(MOST).enumerate().map(row).collect();
    let more = cameras.len().saturating_sub(MOST);
    let rest = if more > 0 { format!("and {more} more\n") } else { String::new() };
    columns(&[Align::Right, Align::Left], &rows) + &rest
}

fn volumes(contents: &Contents) -> String {
    let row = |body: &Body| {
        vec![
            body.voxels.map(|n| n.to_string()).join("x"),
            body.range.map(short).join(" to "),
            short(body.density),
            short(body.step),
            extent(body.bounds),
        ]
    };
    table(
        ["voxels", "values", "density", "step", "bounds"],
        [Align::Left; 5],
        contents.volumes.iter().map(row),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits_and_no_more() {
        for (number, text) in [
            (0.1 + 0.2, "0.3"),
            (f64::from(0.8_f32), "0.8"),
            (123_456_789.0, "123457000"),
            (-1.5e-7, "-0.00000015"),
            (0.0, "0"),
        ] {
            assert_eq!(short(number), text);
        }
    }

    #[test]
    fn many_names_are_counted() {
        let names = |n: usize| vec!["a".to_owned(); n];
        assert_eq!((named(&names(3)), named(&names(4))), ("a, a, a".to_owned(), "4".to_owned()));
    }
}
