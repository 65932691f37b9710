//! A pixel that is clicked, against `inspect`; and that the comparison sees pages with other data.

use super::*;

/// In two blocks of pixels, some with entries that no fragment has, one under the slider's line, one without fragments.
const PIXELS: [[u32; 2]; 7] = [[50, 40], [32, 48], [35, 40], [65, 40], [68, 44], [53, 24], [1, 1]];

#[test]
fn a_clicked_pixel_is_that_of_inspect() {
    let Some(mut browser) = Browser::start() else { return };
    let (mut lost, mut extra, mut fragments) = (0, 0, 0);
    for data in [Data::Color, Data::Primitive] {
        let dir = Dir::new();
        let (path, _) = written(&dir, data);
        browser.open(&path);
        for pixel in PIXELS {
            look_at(&mut browser, pixel);
            let found = inspect(&scene(), &methods(data), pixel).expect("inspected");
            assert_eq!(differences(&mut browser, &found), Vec::<String>::new());
            lost += found.methods[0].fates.iter().filter(|f| f.fate.name() == "lost").count();
            extra += found.methods[0].extra.len();
            fragments += found.fragments.len();
            // The plot has a curve for the exact answer and for each method that absorbs.
            let curves = browser.eval("document.querySelectorAll('.plot polyline').length");
            let expected = if found.fragments.is_empty() { 0 } else { 1 + found.methods.len() };
            assert_eq!(curves, expected, "{pixel:?}");
        }
    }
    assert!(lost > 0 && fragments > 30, "{lost} of {fragments} are lost");
    assert!(extra > 0, "no entry is there that is no fragment's");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// The comparison sees a page that says something else.
#[test]
fn a_page_with_other_data_is_seen_to_be_wrong() {
    let Some(mut browser) = Browser::start() else { return };
    let dir = Dir::new();
    let (path, rows) = written(&dir, Data::Color);
    let text = fs::read_to_string(&path).expect("a page");
    let pixel = [50, 40];
    let found = inspect(&scene(), &methods(Data::Color), pixel).expect("inspected");
    assert!(found.fragments.len() > 2);
    type Fault<'a> = &'a dyn Fn(&str) -> String;
    let faults: [(&str, Fault<'_>); 4] = [
        ("a fate", &|text| changed::fate(text, pixel, SIZE)),
        ("a fragment left out", &|text| changed::without_fragment(text, pixel, SIZE)),
        ("a colour", &|text| changed::color(text, pixel, SIZE)),
        ("an object's name", &|text| text.replacen("\"objects\":[\"", "\"objects\":[\"x", 1)),
    ];
    for (name, fault) in faults {
        let wrong = fault(&text);
        assert_ne!(wrong, text, "{name}");
        fs::write(&path, wrong).expect("a file");
        browser.open(&path);
        look_at(&mut browser, pixel);
        assert!(!differences(&mut browser, &found).is_empty(), "{name} is not seen");
    }
    fs::write(&path, changed::rows_swapped(&text)).expect("a file");
    browser.open(&path);
    assert_ne!(order(&mut browser), names(&rows), "rows in another order");
}
