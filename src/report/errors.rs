//! The table of errors: how far pictures are from a reference.

use serde::Serialize;

use super::grid::{Cell, Column, Grid};
use super::text::percent;
use crate::image::metrics::Metrics;

/// A row: a method's errors.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Errors<'a> {
    /// What drew the picture.
    pub method: &'a str,
    /// What it is compared with.
    pub reference: &'a str,
    /// The errors.
    #[serde(flatten)]
    pub metrics: &'a Metrics,
    /// Pixels compared.
    #[serde(skip)]
    pub pixels: u64,
}

/// A row for each method.
#[must_use]
pub fn grid(rows: &[Errors<'_>]) -> Grid {
    let threshold = rows.first().map_or(0, |row| row.metrics.threshold);
    let mut all = vec![Column::new("method", "method")];
    all.extend(columns(threshold));
    let cells = |row: &Errors<'_>| {
        let name = std::iter::once(Cell::Word(row.method.to_owned()));
        name.chain(cells(row.metrics, row.pixels)).collect()
    };
    Grid { columns: all, rows: rows.iter().map(cells).collect() }
}

/// The columns of [`cells`].
#[must_use]
pub fn columns(threshold: u8) -> Vec<Column> {
    let beyond = format!("by more than {threshold}");
    [
        ("psnr", "PSNR (dB)"),
        ("psnr_linear", "linear (dB)"),
        ("ssim", "SSIM"),
        ("flip", "FLIP"),
        ("max_difference", "by at most"),
        ("mean_difference", "on average"),
        ("pixels_different", "pixels differ"),
        ("beyond", &beyond),
        ("worst_x", "worst at x"),
        ("worst_y", "y"),
    ]
    .map(|(name, heading)| Column::new(name, heading))
    .to_vec()
}

/// The errors of a picture of so many pixels.
#[must_use]
pub fn cells(metrics: &Metrics, pixels: u64) -> Vec<Cell> {
    let decibels =
        |psnr: Option<f64>| psnr.map_or(Cell::Absent("equal"), |psnr| Cell::number(psnr, 2));
    let place = |axis: usize| {
        metrics.worst_pixel.map_or(Cell::Absent("-"), |place| {
            let text = place[axis].to_string();
            Cell::Number(text.clone(), text)
        })
    };
    vec![
        decibels(metrics.psnr),
        decibels(metrics.psnr_linear),
        Cell::number(metrics.ssim, 5),
        Cell::number(metrics.flip, 5),
        Cell::whole(metrics.max_difference),
        Cell::number(metrics.mean_difference, 4),
        Cell::whole(metrics.pixels_different),
        Cell::Number(metrics.beyond.to_string(), percent(metrics.pixels_beyond, pixels)),
        place(0),
        place(1),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Image;
    use crate::report::grid::Syntax;

    #[test]
    fn equal_pictures_have_no_decibels_and_no_worst_pixel() {
        let image = Image::filled(12, 12, [7; 4]);
        let metrics = Metrics::measure(&image, &image, 1).unwrap();
        let row = Errors { method: "m", reference: "exact", metrics: &metrics, pixels: 144 };
        let csv = grid(&[row]).write(Syntax::Csv);
        let names = "method,psnr,psnr_linear,ssim,flip,max_difference,mean_difference,\
                     pixels_different,beyond,worst_x,worst_y";
        assert_eq!(csv, format!("{names}\nm,,,1,0,0,0,0,0,,\n"));
        assert!(grid(&[row]).write(Syntax::Text).contains("\nm           equal "));
        assert!(grid(&[]).write(Syntax::Csv).starts_with("method,psnr"));
    }

    #[test]
    fn the_document_has_the_same_names() {
        let [a, b] = [[7; 4], [9, 7, 7, 7]].map(|color| Image::filled(12, 12, color));
        let metrics = Metrics::measure(&a, &b, 2).unwrap();
        let row = Errors { method: "m", reference: "exact", metrics: &metrics, pixels: 144 };
        let text = serde_json::to_value(row).unwrap();
        let names = columns(2).into_iter().map(|column| column.name);
        for name in names.filter(|name| !name.starts_with("worst")) {
            assert!(text[name].is_number(), "{name}: {text}");
        }
        assert_eq!(text["worst_pixel"], serde_json::json!([0, 0]));
        assert_eq!((&text["beyond"], &text["threshold"]), (&0.0.into(), &2.into()));
    }
}
