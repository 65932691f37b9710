//! A report as a page for browsers: a row for every entry, and the pictures of those that differ.

use std::collections::BTreeMap;

use super::{Report, Status};
use crate::error::Result;
use crate::image::{Image, difference};
use crate::report::grid::{Cell, Column, Grid};
use crate::report::page::{Page, Pictures, Section, Table};

/// The pictures of an entry that is not as recorded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Shown {
    /// The golden one, if it is there.
    pub golden: Option<Image>,
    /// What is drawn now.
    pub drawn: Image,
}

/// The page of a report; `shown` has the pictures by the entries' names.
///
/// # Errors
/// A picture without pixels.
pub fn page(report: &Report, shown: &BTreeMap<String, Shown>) -> Result<Page> {
    let mut page = Page::new(&format!("Golden pictures: {}", report.manifest));
    let mut links: Vec<Option<String>> = Vec::new();
    let mut later = 1;
    for outcome in &report.outcomes {
        links.push(shown.contains_key(&outcome.name).then(|| page.name(later)));
        later += usize::from(shown.contains_key(&outcome.name));
    }
    let count = |status: Status| (report.count(status), status.name());
    let all = [
        Status::Same,
        Status::Blessed,
        Status::InputChanged,
        Status::ProgramChanged,
        Status::Different,
        Status::Missing,
        Status::Error,
    ];
    let told: Vec<String> = all
        .map(count)
        .iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, name)| format!("{count} {name}"))
        .collect();
    let mut notes = vec![told.join(", ")];
    if !report.not_run.is_empty() {
        notes.push(format!("Not run: {}", report.not_run.join(", ")));
    }
    page.add("Entries", Section::Table(Table::new(&grid(report), &links, notes)));
    for outcome in &report.outcomes {
        let Some(Shown { golden, drawn }) = shown.get(&outcome.name) else { continue };
        let size = [drawn.width, drawn.height];
        let mut pictures = Pictures::new(size);
        // A golden picture of another size cannot lie under the slider.
        let golden = golden.as_ref().filter(|golden| [golden.width, golden.height] == size);
        if let Some(golden) = golden {
            pictures.add(&mut page, "golden", golden)?;
        }
        pictures.add(&mut page, "drawn now", drawn)?;
        if let Some(golden) = golden {
            let map = difference::heat_map(golden, drawn)?;
            let meaning = "largest difference of a channel, 0 (near black) to 255 (ivory)";
            pictures.add_map(&mut page, "difference", &map, meaning)?;
        }
        page.add(&outcome.name, Section::Pictures(pictures));
    }
    Ok(page)
}

fn grid(report: &Report) -> Grid {
    let columns = [
        ("name", "entry"),
        ("status", "status"),
        ("differing", "pixels differ"),
        ("max", "by at most"),
        ("why", "why"),
    ]
    .map(|(name, heading)| Column::new(name, heading))
    .to_vec();
    let row = |outcome: &super::Outcome| {
        let apart = outcome.difference.as_ref();
        let number = |number: Option<u64>| number.map_or(Cell::Absent("-"), Cell::whole);
        vec![
            Cell::Word(outcome.name.clone()),
            Cell::Word(outcome.status.name().to_owned()),
            number(apart.map(|apart| apart.differing)),
            number(apart.map(|apart| u64::from(apart.max))),
            Cell::Word(outcome.why.clone()),
        ]
    };
    Grid { columns, rows: report.outcomes.iter().map(row).collect() }
}

#[cfg(test)]
mod tests {
    use super::super::super::PROGRAM;
    use super::super::Outcome;
    use super::*;

    #[test]
    fn what_differs_is_linked_to_its_pictures() {
        let outcomes = [
            ("a", Status::Same),
            ("b", Status::Different),
            ("c", Status::Missing),
            ("d", Status::Different),
        ];
        let report = Report {
            format: 1,
            program: PROGRAM.to_owned(),
            manifest: "golden.toml".to_owned(),
            manifest_sha256: String::new(),
            entries: Vec::new(),
            filter: None,
            partition: None,
            outcomes: outcomes.map(|(name, status)| Outcome::new(name, status, "")).to_vec(),
            not_run: vec!["e".to_owned()],
        };
        let picture = |value| Image::filled(3, 2, [value; 4]);
        let shown = BTreeMap::from([
            ("b".to_owned(), Shown { golden: Some(picture(1)), drawn: picture(2) }),
            (
                "d".to_owned(),
                Shown { golden: Some(Image::filled(2, 2, [0; 4])), drawn: picture(2) },
            ),
        ]);
        let mut bytes = Vec::new();
        page(&report, &shown).unwrap().write(&mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let json = text.split("id=\"contents\">").nth(1).unwrap().split("</script>").next();
        let found: serde_json::Value = serde_json::from_str(json.unwrap()).unwrap();
        let rows = found[0]["rows"].as_array().unwrap();
        let links: Vec<_> = rows.iter().map(|row| row["link"].as_str()).collect();
        assert_eq!(links, [None, found[1]["id"].as_str(), None, found[2]["id"].as_str()]);
        assert_eq!((&found[1]["title"], &found[2]["title"]), (&"b".into(), &"d".into()));
        let pictures = |i: usize| found[i]["pictures"].as_array().unwrap().len();
        assert_eq!((pictures(1), pictures(2)), (3, 1), "one of another size is not shown");
        assert_eq!(found[0]["notes"][1], "Not run: e");
    }
}
