//! What was found as a page for browsers: the exact picture beside the judged ones, with the fragments of every pixel;
//! and for each file its classes, with a map.

use super::Document;
use super::heat_map;
use super::table::{culprit, extent, last, odd};
use crate::error::Result;
use crate::image::Image;
use crate::inspect::frame::Frame;
use crate::judge::dump::DumpVerdict;
use crate::judge::{Class, Counted, Runs, Verdict, map};
use crate::render::Options;
use crate::report::grid::{Cell, Column, Grid};
use crate::report::page::pixels::{self, Blocks};
use crate::report::page::{Page, Pictures, Section, Table};
use crate::report::text::{percent, thousands};
use crate::scene::Scene;

/// The page; `options` draw the exact answer.
///
/// # Errors
/// As [`Frame::new`] and [`Frame::draw`].
pub(super) fn page(
    scene: &Scene,
    options: &Options,
    exact: &Image,
    document: &Document,
) -> Result<Page> {
    let mut page = Page::new(&format!("Judged: {}", scene.name));
    page.add("Verdict", facts(document));
    let mut pictures = Pictures::new(scene.size);
    pictures.add(&mut page, "exact", exact)?;
    for verdict in &document.pictures {
        pictures.add(&mut page, &verdict.picture, &verdict.seen)?;
    }
    let meaning = "largest difference of a channel, 0 (near black) to 255 (ivory)";
    for verdict in &document.pictures {
        let name = format!("{}: difference", verdict.picture);
        pictures.add_map(&mut page, &name, &heat_map(scene.size, &verdict.apart), meaning)?;
    }
    if let Some(runs) = &document.runs {
        let name = "between runs: difference";
        pictures.add_map(&mut page, name, &heat_map(scene.size, &runs.apart), meaning)?;
    }
    let frame = Frame::new(scene, std::slice::from_ref(options))?;
    let mut blocks = Blocks::new(&frame);
    frame.draw(options, |drawn| blocks.add(options, drawn))?;
    pixels::add(&mut page, &mut pictures, scene, blocks)?;
    page.add("Pictures", Section::Pictures(pictures));
    for verdict in &document.pictures {
        classes(&mut page, scene, &verdict.picture, &verdict.classes, of_picture(verdict));
        class_map(&mut page, scene, &verdict.picture, &verdict.map)?;
    }
    for verdict in &document.dumps {
        classes(&mut page, scene, &verdict.dump, &verdict.classes, of_dump(verdict));
        class_map(&mut page, scene, &verdict.dump, &verdict.map)?;
    }
    if let Some(runs) = &document.runs {
        classes(&mut page, scene, BETWEEN, &runs.classes, of_runs(runs));
        class_map(&mut page, scene, BETWEEN, &runs.map)?;
    }
    Ok(page)
}

const BETWEEN: &str = "what differs between runs";

fn facts(document: &Document) -> Section {
    let pair = |name: &str, value: String| [name.to_owned(), value];
    let kept = document.k.map_or("all".to_owned(), |k| format!("the nearest {k} of a pixel"));
    let rows = vec![
        pair("verdict", last(document).trim_end().to_owned()),
        pair("scene", document.scene.clone()),
        pair("size", format!("{}x{}", document.width, document.height)),
        pair("fragments", format!("{}, {kept} are right", thousands(document.fragments))),
        pair("tolerance", format!("{} of 255", document.tolerance)),
        pair("fragloom", document.program.to_owned()),
    ];
    let notes = document.warnings.iter().map(|warning| format!("warning: {warning}")).collect();
    Section::Facts { rows, notes }
}

/// A table of the classes that pixels have, with sentences below it.
fn classes(page: &mut Page, scene: &Scene, name: &str, classes: &[Counted], notes: Vec<String>) {
    let columns = [
        ("class", "class"),
        ("pixels", "pixels"),
        ("share", "share"),
        ("largest", "by at most"),
        ("x", "first x"),
        ("y", "y"),
        ("meaning", "meaning"),
    ];
    let columns = columns.map(|(name, heading)| Column::new(name, heading)).to_vec();
    let all = u64::from(scene.size[0]) * u64::from(scene.size[1]);
    let row = |count: &Counted| {
        let share = count.pixels as f64 / all as f64;
        vec![
            Cell::Word(count.class.name().to_owned()),
            Cell::whole(count.pixels),
            Cell::Number(share.to_string(), percent(count.pixels, all)),
            Cell::whole(u64::from(count.max_difference)),
            Cell::whole(u64::from(count.first[0])),
            Cell::whole(u64::from(count.first[1])),
            Cell::Word(count.meaning.to_owned()),
        ]
    };
    let grid = Grid { columns, rows: classes.iter().map(row).collect() };
    page.add(name, Section::Table(Table::new(&grid, &[], notes)));
}

fn class_map(page: &mut Page, scene: &Scene, name: &str, classes: &[Class]) -> Result<()> {
    let image = map(&format!("{} \u{b7} {name}", scene.name), scene.size, classes);
    let mut pictures = Pictures::new([image.width, image.height]);
    pictures.add(page, "classes", &image)?;
    page.add(&format!("{name}: where"), Section::Pictures(pictures));
    Ok(())
}

fn of_picture(verdict: &Verdict) -> Vec<String> {
    let metrics = &verdict.metrics;
    let psnr = metrics.psnr.map_or("-".to_owned(), |psnr| format!("{psnr:.2} dB"));
    let mut notes = vec![format!(
        "PSNR {psnr}, SSIM {:.6}, FLIP {:.6}, largest difference {}.",
        metrics.ssim, metrics.flip, metrics.max_difference
    )];
    if let Some(held) = &verdict.hypothesis {
        notes.push(format!("As if {}: {}.", held.as_if, extent(held)));
        let others = held.or_as_if.iter();
        notes.extend(others.map(|other| format!("Or as if {other}: this cannot be told apart.")));
    } else if let Some(best) = verdict.tested.first() {
        let best = format!("as if {}: {}", best.as_if, extent(best));
        notes.push(format!("No hypothesis about the whole picture holds; the best: {best}."));
    }
    notes.extend(verdict.culprits.iter().map(culprit));
    notes
}

fn of_dump(verdict: &DumpVerdict) -> Vec<String> {
    let (dumped, exact) = (thousands(verdict.dumped), thousands(verdict.exact));
    let mut notes = vec![format!("{dumped} fragments instead of {exact}.")];
    notes.extend(verdict.fragments.iter().map(|count| {
        format!("{}: {} ({})", count.class.name(), thousands(count.fragments), count.meaning)
    }));
    notes.extend(verdict.first.iter().map(odd));
    notes
}

fn of_runs(runs: &Runs) -> Vec<String> {
    vec![format!(
        "{} runs: {} pixels differ, {} beyond the tolerance, by at most {}.",
        runs.runs,
        thousands(runs.pixels_different),
        thousands(runs.pixels_beyond),
        runs.max_difference
    )]
}
