//! The page of a scene that several methods have drawn: pictures, maps of errors, the pixel inspector, and the table.

use serde::Serialize;

use super::pixels::{self, Blocks};
use super::{Page, Pictures, Section, Table};
use crate::error::Result;
use crate::image::heat::Map;
use crate::image::metrics::{Metrics, THRESHOLD};
use crate::image::{Image, difference, flip};
use crate::inspect::frame::{Drawn, Frame};
use crate::render::Options;
use crate::report::errors;
use crate::report::grid::{Cell, Column, Grid};
use crate::report::text::thousands;
use crate::scene::Scene;

/// A page, and its table.
#[derive(Clone, Debug)]
pub struct Drawing {
    /// The page.
    pub page: Page,
    /// A row for each method.
    pub rows: Vec<Row>,
}

/// What one method gave.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The method, with k where it has one.
    pub title: String,
    /// The method.
    pub method: String,
    /// Entries of lists.
    pub kept: u64,
    /// Fragments lost in a race.
    pub lost: u64,
    /// Fragments dropped for any reason, lost ones among them.
    pub dropped: u64,
    /// Bytes of the method's storage.
    pub bytes: u64,
    /// Errors against all fragments.
    #[serde(flatten)]
    pub metrics: Metrics,
    /// SHA-256 of the picture.
    pub image_hash: String,
    /// What was tolerated.
    pub warnings: Vec<String>,
    /// What was promised and not kept.
    pub violations: Vec<String>,
}

/// Draw `scene` with each of `methods`, and show it.
///
/// # Errors
/// As [`inspect()`](crate::inspect::inspect), but of all pixels.
pub fn drawing(scene: &Scene, methods: &[Options]) -> Result<Drawing> {
    let frame = Frame::new(scene, methods)?;
    let [width, height] = scene.size;
    let mut page = Page::new(&format!("{} at {width}x{height}", scene.name));
    let mut pictures = Pictures::new(scene.size);
    pictures.add(&mut page, "exact", &frame.exact)?;
    let mut blocks = Blocks::new(&frame);
    let mut rows = Vec::new();
    let mut maps = Vec::new();
    for options in methods {
        let (row, image) = frame.draw(options, |drawn| {
            blocks.add(options, drawn);
            Ok((row(&frame.exact, options, drawn)?, drawn.rendering.image.clone()))
        })??;
        pictures.add(&mut page, &row.title, &image)?;
        maps.push((row.title.clone(), image));
        rows.push(row);
    }
    for (title, image) in &maps {
        add_maps(&mut page, &mut pictures, title, &frame.exact, image)?;
    }
    let facts = facts(scene, &frame, &rows);
    pixels::add(&mut page, &mut pictures, scene, blocks)?;
    page.add("Pictures", Section::Pictures(pictures));
    let notes = vec!["Errors are against the picture of all fragments.".to_owned()];
    page.add("Methods", Section::Table(Table::new(&grid(&rows, scene.size), &[], notes)));
    page.add("Scene", facts);
    Ok(Drawing { page, rows })
}

fn row(exact: &Image, options: &Options, drawn: &Drawn<'_>) -> Result<Row> {
    let report = &drawn.rendering.report;
    Ok(Row {
        title: drawn.title(),
        method: options.method.name().to_owned(),
        kept: report.kept,
        lost: report.dropped.get("lost").copied().unwrap_or(0),
        dropped: report.dropped.values().sum(),
        bytes: report.bytes,
        metrics: Metrics::measure(exact, &drawn.rendering.image, THRESHOLD)?,
        image_hash: report.image_hash.clone(),
        warnings: report.warnings.clone(),
        violations: report.violations.clone(),
    })
}

/// The maps of errors of one method.
fn add_maps(
    page: &mut Page,
    pictures: &mut Pictures,
    title: &str,
    exact: &Image,
    image: &Image,
) -> Result<()> {
    let size = [exact.width, exact.height];
    let values = flip::map(exact, image)?;
    let map = Map { title: "", meaning: "", size, values: &values, most: 1.0 }.plain();
    let meaning = "FLIP, 0 (near black) to 1 (ivory)";
    pictures.add_map(page, &format!("{title}: FLIP"), &map, meaning)?;
    let map = difference::heat_map(exact, image)?;
    let meaning = "largest difference of a channel, 0 (near black) to 255 (ivory)";
    pictures.add_map(page, &format!("{title}: difference"), &map, meaning)
}

/// The rows as a table.
#[must_use]
pub fn grid(rows: &[Row], [width, height]: [u32; 2]) -> Grid {
    let own = [
        ("method", "method"),
        ("kept", "kept"),
        ("lost", "lost"),
        ("dropped", "dropped"),
        ("bytes", "bytes"),
    ];
    let mut columns: Vec<Column> = own.map(|(name, heading)| Column::new(name, heading)).to_vec();
    columns.extend(errors::columns(THRESHOLD));
    let cells = |row: &Row| {
        let mut cells = vec![Cell::Word(row.title.clone())];
        cells.extend([row.kept, row.lost, row.dropped, row.bytes].map(Cell::whole));
        cells.extend(errors::cells(&row.metrics, u64::from(width) * u64::from(height)));
        cells
    };
    Grid { columns, rows: rows.iter().map(cells).collect() }
}

fn facts(scene: &Scene, frame: &Frame<'_>, rows: &[Row]) -> Section {
    let [width, height] = scene.size;
    let pair = |name: &str, value: String| [name.to_owned(), value];
    let facts = vec![
        pair("scene", scene.name.clone()),
        pair("size", format!("{width}x{height}")),
        pair("fragments", thousands(frame.fragments())),
        pair("depth words", frame.distances().format.name().to_owned()),
        pair("fragloom", env!("CARGO_PKG_VERSION").to_owned()),
    ];
    let mut notes = scene.warnings.clone();
    for row in rows {
        let new = row.warnings.iter().filter(|warning| !scene.warnings.contains(warning));
        notes.extend(new.map(|warning| format!("{}: warning: {warning}", row.title)));
        let broken = row.violations.iter();
        notes.extend(broken.map(|violation| format!("{}: violation: {violation}", row.title)));
    }
    Section::Facts { rows: facts, notes }
}
