//! `fragloom report`: what the page shows in a real browser after clicks and keys, against the library; and the command.

#[path = "support/browser.rs"]
mod browser;
#[path = "report/changed.rs"]
mod changed;
#[path = "support/command.rs"]
mod command;

use std::fs;
use std::path::{Path, PathBuf};

use browser::{Browser, SHIFT};
use command::Dir;
use fragloom::catalogue;
use fragloom::image::Image;
use fragloom::inspect::{Fate, Inspected, Inspection, inspect};
use fragloom::render::{Data, Exec, Options, Sim};
use fragloom::report::grid::{Grid, Syntax};
use fragloom::report::json;
use fragloom::report::page::drawing::{Row, drawing, grid};
use fragloom::scene::{self, Overrides, Scene};
use serde_json::Value;

const SIZE: [u32; 2] = [100, 72];

fn scene() -> Scene {
    scene::load("cubes", &Overrides { size: Some(SIZE), ..Overrides::default() }).expect("a scene")
}

/// A list that loses fragments, merged records, a colour, and a list that keeps the nearest; in one interleaving.
fn methods(data: Data) -> Vec<Options> {
    let sim = Sim { resident: 512, ..Sim::default() };
    let one = |name: &&str| Options {
        method: catalogue::method(name).expect("a method"),
        k: Some(3),
        data,
        exec: Exec::Sim(sim.clone()),
        threads: 1,
        ..Options::default()
    };
    ["kb", "kplus-array", "dfb+ofm", "wboit"].iter().map(one).collect()
}

/// The page as a file, and its table.
fn written(folder: &Dir, data: Data) -> (PathBuf, Vec<Row>) {
    let drawn = drawing(&scene(), &methods(data)).expect("drawn");
    let path = folder.path("page.html");
    let mut bytes = Vec::new();
    drawn.page.write(&mut bytes).expect("written");
    fs::write(&path, bytes).expect("a file");
    (path, drawn.rows)
}

/// Look at a pixel by a click, and wait for it.
fn look_at(browser: &mut Browser, [x, y]: [u32; 2]) {
    let part = |place: u32, whole: u32| (f64::from(place) + 0.5) / f64::from(whole);
    browser.click_at(".stage", [part(x, SIZE[0]), part(y, SIZE[1])]);
    shows(browser, [x, y]);
}

fn shows(browser: &mut Browser, [x, y]: [u32; 2]) {
    browser.wait(&format!("document.querySelector('.found').dataset.pixel === '{x},{y}'"));
}

/// The document of the pixel that is shown, from the page's own export.
fn document(browser: &mut Browser) -> Value {
    if browser.eval("document.querySelector('.inspector .exported').hidden") == Value::Bool(true) {
        browser.click(".inspector .controls button");
    }
    let text = browser.eval("document.querySelector('.inspector textarea').value");
    serde_json::from_str(text.as_str().expect("text")).expect("a document")
}

/// Equal, but for the last bits that reading a number from text may cost.
fn same(a: &Value, b: &Value) -> bool {
    match (a, b) {
        (Value::Number(a), Value::Number(b)) => {
            let [a, b] = [a, b].map(|n| n.as_f64().expect("a number"));
            (a - b).abs() <= 1e-14 * a.abs().max(b.abs())
        }
        (Value::Array(a), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
        }
        (Value::Object(a), Value::Object(b)) => {
            a.len() == b.len()
                && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| same(a, b)))
        }
        _ => a == b,
    }
}

/// The cells of a table's body, as they are shown.
fn cells(browser: &mut Browser, selector: &str) -> Vec<Vec<String>> {
    let expression = format!(
        "[...document.querySelectorAll('{selector} tbody tr')].map((row) => \
         [...row.cells].map((cell) => cell.innerText.trim()))"
    );
    serde_json::from_value(browser.eval(&expression)).expect("texts")
}

/// A fate as the page marks and names it.
fn fate(fate: &Fate, method: &Inspected) -> String {
    let mark = match fate.fate.name() {
        "kept" => "\u{25cf}",
        "merged" => "\u{25d0}",
        "culled" => "\u{25cb}",
        "evicted" => "\u{21e5}",
        "dropped" => "\u{2715}",
        "lost" => "\u{26a0}",
        _ => "\u{2013}",
    };
    let name = fate.fate.name();
    let text = match (fate.record, &fate.reason) {
        (None, Some(reason)) if name == "dropped" => format!("{name}: {reason}"),
        (Some(record), None) => format!("{name} {record}"),
        (Some(record), Some(_)) => format!("{name} {record}?"),
        (None, _) if name == "merged" && !method.records.is_empty() => format!("{name} ?"),
        _ => name.to_owned(),
    };
    mark.to_owned() + &text
}

/// What the table of fragments must show.
fn expected(found: &Inspection) -> Vec<Vec<String>> {
    let row = |index: usize| {
        let fragment = &found.fragments[index];
        let object = fragment.object.clone().unwrap_or_else(|| "-".to_owned());
        let mut row = vec![index.to_string(), object];
        row.extend(found.methods.iter().map(|method| fate(&method.fates[index], method)));
        row.push(format!("{:.6}", fragment.distance));
        row.push(fragment.rgba.map(|channel| channel.to_string()).join(" "));
        row.push(format!("{:.4}", f64::from(fragment.rgba[3]) / 255.0));
        row.extend([fragment.depth.to_string(), fragment.triangle.to_string()]);
        row
    };
    (0..found.fragments.len()).map(row).collect()
}

/// What differs between the page's pixel and the library's; empty if nothing does.
fn differences(browser: &mut Browser, found: &Inspection) -> Vec<String> {
    let mut wrong = Vec::new();
    let told: Value = serde_json::from_str(&json::document(found).expect("text")).expect("JSON");
    let shown = document(browser);
    if !same(&told, &shown) {
        wrong.push(format!("document of {:?}: {shown} is not {told}", found.pixel));
    }
    let shown = cells(browser, ".fragments");
    if shown != expected(found) {
        wrong.push(format!("table of {:?}: {shown:?}", found.pixel));
    }
    let colours = cells(browser, ".colours");
    for (method, row) in found.methods.iter().zip(&colours[1..]) {
        let rgb = method.color[..3].iter().map(ToString::to_string).collect::<Vec<_>>().join(" ");
        let texts = [method.title(), rgb, method.difference.to_string()];
        if row[..3] != texts || row[3] != format!("{:.6}", method.absorbed) {
            wrong.push(format!("colours of {:?}: {row:?}", found.pixel));
        }
    }
    wrong
}

const PIXELS: [[u32; 2]; 7] = [[50, 40], [63, 63], [64, 64], [45, 30], [52, 20], [70, 66], [1, 1]];

#[test]
fn a_clicked_pixel_is_that_of_inspect() {
    let Some(mut browser) = Browser::start() else { return };
    let (mut lost, mut fragments) = (0, 0);
    for data in [Data::Color, Data::Primitive] {
        let dir = Dir::new();
        let (path, _) = written(&dir, data);
        browser.open(&path);
        for pixel in PIXELS {
            look_at(&mut browser, pixel);
            let found = inspect(&scene(), &methods(data), pixel).expect("inspected");
            assert_eq!(differences(&mut browser, &found), Vec::<String>::new());
            lost += found.methods[0].fates.iter().filter(|f| f.fate.name() == "lost").count();
            fragments += found.fragments.len();
            // The plot has a curve for the exact answer and for each method that absorbs.
            let curves = browser.eval("document.querySelectorAll('.plot polyline').length");
            let expected = if found.fragments.is_empty() { 0 } else { 1 + found.methods.len() };
            assert_eq!(curves, expected, "{pixel:?}");
        }
    }
    assert!(lost > 0 && fragments > 30, "{lost} of {fragments} are lost");
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
    let faults: [(&str, &dyn Fn(&str) -> String); 4] = [
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

fn order(browser: &mut Browser) -> Vec<String> {
    cells(browser, ".kind-table").into_iter().map(|mut row| row.remove(0)).collect()
}

fn names(rows: &[Row]) -> Vec<String> {
    rows.iter().map(|row| row.title.clone()).collect()
}

#[test]
fn a_table_sorts_and_is_exported_as_it_is_shown() {
    let Some(mut browser) = Browser::start() else { return };
    let dir = Dir::new();
    let (path, rows) = written(&dir, Data::Color);
    browser.open(&path);
    let whole = grid(&rows, SIZE);
    let shown = cells(&mut browser, ".kind-table");
    let text = whole.write(Syntax::Text);
    for (row, line) in shown.iter().zip(text.lines().skip(1)) {
        assert_eq!(row.join(" "), line.split_whitespace().collect::<Vec<_>>().join(" "));
    }
    assert_eq!(order(&mut browser), names(&rows));
    let flip = whole.columns.iter().position(|column| column.name == "flip").expect("a column") + 1;
    let head = format!(".kind-table th:nth-child({flip})");
    let mut sorted: Vec<usize> = (0..rows.len()).collect();
    sorted.sort_by(|&a, &b| rows[a].metrics.flip.total_cmp(&rows[b].metrics.flip));
    let up = sorted.clone();
    let down: Vec<usize> = sorted.into_iter().rev().collect();
    assert_ne!(up, (0..rows.len()).collect::<Vec<_>>(), "it is not sorted at first");
    let plain: Vec<usize> = (0..rows.len()).collect();
    for (order_now, told) in [(up, "ascending"), (down, "descending"), (plain, "none")] {
        browser.click(&format!("{head} button"));
        let titles: Vec<String> = order_now.iter().map(|&i| rows[i].title.clone()).collect();
        assert_eq!(order(&mut browser), titles, "{told}");
        let sort = browser.eval(&format!("document.querySelector('{head}').ariaSort"));
        assert_eq!(sort, told);
        let again = order_now.iter().map(|&i| whole.rows[i].clone()).collect();
        let again = Grid { columns: whole.columns.clone(), rows: again };
        for (number, syntax) in [(1, Syntax::Csv), (2, Syntax::Latex)] {
            let button = format!(".kind-table > .controls button:nth-child({number})");
            if browser.eval(&format!("document.querySelector('{button}').ariaExpanded")) == "false" {
                browser.click(&button);
            }
            let area = format!("document.querySelectorAll('.kind-table textarea')[{}].value", number - 1);
            assert_eq!(browser.eval(&area), again.write(syntax));
        }
    }
    // By the keyboard, a column of words.
    browser.eval("document.querySelector('.kind-table th button').focus()");
    browser.key("Enter", 0);
    let mut words = names(&rows);
    words.sort();
    assert_eq!(order(&mut browser), words);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// The colour on the screen at a pixel of the stage, which must not be magnified by less than 3.
fn on_screen(browser: &mut Browser, [x, y]: [u32; 2]) -> [u8; 4] {
    let part = |place: u32, whole: u32| (f64::from(place) + 0.5) / f64::from(whole);
    let [left, top] = browser.place(".stage", [part(x, SIZE[0]), part(y, SIZE[1])]);
    let shot = browser.screenshot();
    shot.pixel(left as u32, top as u32)
}

#[test]
fn the_slider_lies_between_two_pictures() {
    let Some(mut browser) = Browser::start() else { return };
    let dir = Dir::new();
    let (path, _) = written(&dir, Data::Color);
    let frame = fragloom::inspect::frame::Frame::new(&scene(), &methods(Data::Color)).map(|f| f.exact);
    let exact: Image = frame.expect("a frame");
    let kb: Image = fragloom::render::render(&scene(), &methods(Data::Color)[0]).expect("drawn").image;
    browser.open(&path);
    browser.wait("[...document.images].every((image) => image.complete)");
    let differ = |x: u32| (20..60).map(move |y| [x, y]).collect::<Vec<_>>();
    let differ = |xs: std::ops::Range<u32>| {
        let mut all = xs.flat_map(differ);
        all.find(|&[x, y]| exact.pixel(x, y) != kb.pixel(x, y)).expect("a difference")
    };
    let (west, east) = (differ(30..46), differ(54..70));
    let at = |image: &Image, [x, y]: [u32; 2]| image.pixel(x, y);
    assert_eq!(on_screen(&mut browser, west), at(&exact, west));
    assert_eq!(on_screen(&mut browser, east), at(&kb, east));
    // The line is moved to the left edge, and then to the right edge, by the mouse.
    browser.drag(".line", [-2_000.0, 0.0]);
    assert_eq!(on_screen(&mut browser, west), at(&kb, west));
    assert_eq!(browser.eval("document.querySelector('.slider').value"), "0");
    browser.drag(".line", [2_000.0, 0.0]);
    assert_eq!(on_screen(&mut browser, east), at(&exact, east));
    // And back by the keyboard.
    browser.eval("document.querySelector('.slider').focus()");
    browser.key("Home", 0);
    assert_eq!(on_screen(&mut browser, east), at(&kb, east));
    // The other picture is another method's.
    browser.key("]", 0);
    assert!(browser.text(".name-right").contains("kplus-array"));
    browser.key("[", 0);
    assert!(browser.text(".name-right").contains("kb"));
    // All panels are zoomed together.
    browser.key("+", 0);
    browser.key("+", 0);
    let all = "new Set([...document.querySelectorAll('.panel img')].map((i) => i.style.transform)).size";
    assert_eq!(browser.eval(all), 1);
    assert_eq!(browser.text(".zoomed"), "4\u{d7}");
    // A click in a magnified picture is at the pixel that is there.
    browser.click_at(".stage", [0.5, 0.5]);
    shows(&mut browser, [SIZE[0] / 2, SIZE[1] / 2]);
    browser.key("0", 0);
    assert_eq!(browser.text(".zoomed"), "1\u{d7}");
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// What can be reached, in the order of the document.
const CONTROLS: &str = "[...document.querySelectorAll('a[href], button, input, select, textarea, [tabindex=\"0\"]')]
    .filter((e) => e.checkVisibility({ visibilityProperty: true }))";

#[test]
fn everything_works_by_the_keyboard() {
    let Some(mut browser) = Browser::start() else { return };
    let dir = Dir::new();
    let (path, _) = written(&dir, Data::Color);
    browser.open(&path);
    look_at(&mut browser, [50, 40]);
    for (key, modifiers, pixel) in [
        ("ArrowRight", 0, [51, 40]),
        ("ArrowDown", 0, [51, 41]),
        ("ArrowLeft", SHIFT, [41, 41]),
        ("ArrowUp", SHIFT, [41, 31]),
        ("ArrowUp", SHIFT, [41, 21]),
        ("ArrowLeft", 0, [40, 21]),
    ] {
        browser.key(key, modifiers);
        shows(&mut browser, pixel);
    }
    let found = inspect(&scene(), &methods(Data::Color), [40, 21]).expect("inspected");
    assert_eq!(differences(&mut browser, &found), Vec::<String>::new());
    // Tab leads through all controls, and each is seen to have the focus.
    browser.eval("document.activeElement.blur(); window.scrollTo(0, 0)");
    let count = browser.eval(&format!("{CONTROLS}.length")).as_u64().expect("a number");
    assert!(count > 20, "{count}");
    browser.eval("window.passed = []");
    for _ in 0..count {
        browser.key("Tab", 0);
        browser.eval("window.passed.push(document.activeElement)");
        let outline = browser.eval("getComputedStyle(document.activeElement).outlineStyle");
        assert_eq!(outline, "solid", "{}", browser.eval("document.activeElement.outerHTML.slice(0, 200)"));
    }
    let missed = format!("{CONTROLS}.filter((e) => !window.passed.includes(e)).map((e) => e.outerHTML.slice(0, 200))");
    assert_eq!(browser.eval(&missed), serde_json::json!([]));
    // Help opens, and closes.
    browser.key("?", SHIFT);
    assert_eq!(browser.eval("document.getElementById('help').open"), true);
    assert!(browser.text("#help").contains("arrow keys"));
    browser.key("Escape", 0);
    assert_eq!(browser.eval("document.getElementById('help').open"), false);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// Every control and picture has a name, every table headings, every section a heading, and no name is there twice.
const NAMELESS: &str = "(() => { const named = (e) => (e.ariaLabel || (e.labels && [...e.labels].map((l) => l.innerText).join(''))
    || e.alt || e.getAttribute('aria-labelledby') || e.textContent || '').trim() !== '';
    const all = [...document.querySelectorAll('button, a, input, select, textarea, img, [role=img], [role=region], [role=application], section, dialog')];
    const ids = [...document.querySelectorAll('[id]')].map((e) => e.id);
    return [...all.filter((e) => !named(e)).map((e) => e.outerHTML.slice(0, 200)),
      ...ids.filter((id, i) => ids.indexOf(id) !== i),
      ...[...document.querySelectorAll('table')].filter((t) => !t.querySelector('th[scope]')).map((t) => t.className),
      ...(document.documentElement.lang ? [] : ['lang'])]; })()";

/// The contrast of text and its ground.
const CONTRAST: &str = "(() => { const light = (c) => { const [r, g, b] = c.match(/[\\d.]+/g).map(Number).map((v) => {
      v /= 255; return v <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const style = getComputedStyle(document.body); const quiet = getComputedStyle(document.querySelector('.note'));
    const paper = light(style.backgroundColor);
    return [style, quiet].map((s) => { const [a, b] = [light(s.color), paper].sort((x, y) => y - x); return (a + 0.05) / (b + 0.05); }); })()";

#[test]
fn dark_printed_and_named() {
    let Some(mut browser) = Browser::start() else { return };
    let dir = Dir::new();
    let (path, _) = written(&dir, Data::Color);
    browser.open(&path);
    look_at(&mut browser, [50, 40]);
    document(&mut browser);
    assert_eq!(browser.eval(NAMELESS), serde_json::json!([]));
    let paper = "getComputedStyle(document.body).backgroundColor";
    let mut papers = Vec::new();
    for scheme in ["light", "dark"] {
        browser.emulate("screen", scheme);
        papers.push(browser.eval(paper));
        for contrast in browser.eval(CONTRAST).as_array().expect("numbers") {
            assert!(contrast.as_f64().expect("a number") >= 4.5, "{scheme}: {contrast}");
        }
    }
    assert_ne!(papers[0], papers[1]);
    browser.key("+", 0);
    browser.emulate("print", "light");
    let shown = "[...document.querySelectorAll('button.control, select, input, textarea, .line')].filter((e) => e.checkVisibility()).length";
    assert_eq!(browser.eval(shown), 0, "controls are not printed");
    let pictures = "[...document.querySelectorAll('.gallery img')].filter((e) => e.checkVisibility() && getComputedStyle(e).transform === 'none').length";
    assert_eq!(browser.eval(pictures), 1 + 3 * 4, "all pictures and maps are, and whole");
    assert_eq!(browser.eval("document.querySelectorAll('table').length >= 3"), true);
    let hidden = "[...document.querySelectorAll('table')].filter((e) => !e.closest('dialog') && !e.checkVisibility()).length";
    assert_eq!(browser.eval(hidden), 0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

/// A scene whose names would end the script or begin a tag.
const EVIL: &str = "</script><img src=x onerror=alert(1)>&amp;\"'<!--";

fn evil(folder: &Path) -> String {
    let name = "a<b>&c.toml";
    let text = format!(
        "[[object]]\nname = {EVIL:?}\ngenerator = \"box\"\n\n[[object]]\nname = \"<script>\"\ngenerator = \"sphere\"\n"
    );
    fs::write(folder.join(name), text).expect("a scene");
    name.to_owned()
}

#[test]
fn names_with_signs_do_not_break_the_page() {
    let dir = Dir::new();
    let name = evil(&dir.path("."));
    let line = format!("report {name} --size 40x30 -m kplus-array -o page.html");
    let run = dir.run(&line);
    assert_eq!(run.code, 0, "{run:?}");
    let Some(mut browser) = Browser::start() else { return };
    browser.open(&dir.path("page.html"));
    assert_eq!(browser.text("h1"), "a<b>&c.toml at 40x30");
    browser.click(".stage");
    shows(&mut browser, [20, 15]);
    let objects: Vec<String> =
        cells(&mut browser, ".fragments").into_iter().map(|mut row| row.remove(1)).collect();
    assert!(objects.contains(&EVIL.to_owned()), "{objects:?}");
    assert_eq!(browser.eval("document.querySelectorAll('main img[src=x]').length"), 0);
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn the_command_writes_equal_bytes_and_says_what_is_wrong() {
    let dir = Dir::new();
    let line = "report layers:count=3 --size 20x12 -k 2 -m kplus-array,ab-ll";
    let first = dir.run(&format!("{line} -o a.html"));
    assert_eq!((first.code, first.stderr.as_str()), (0, ""), "{first:?}");
    let table: Vec<&str> = first.stdout.lines().collect();
    assert!(table[0].starts_with("method") && table[1].starts_with("kplus-array, k = 2"), "{table:?}");
    let document = dir.run(&format!("{line} -o b.html --json --threads 1")).json();
    assert_eq!(document[1]["method"], "ab-ll");
    assert_eq!(dir.read("a.html"), dir.read("b.html"));
    let scene = "[[object]]\ngenerator = \"box\"\n";
    fs::write(dir.path("in.html"), scene).expect("a file");
    fs::write(dir.path("scene.toml"), scene).expect("a file");
    for (line, words) in [
        (format!("{line} -o a.txt"), &["-o:", "a.txt", ".html"][..]),
        (format!("{line} -o -"), &["-o:", ".html"]),
        (format!("{line} -o no/a.html"), &["-o:", "no"]),
        (line.to_owned(), &["-o"]),
        ("report layers -m occupancy --size 8x8 -o x.html".to_owned(), &["-m:", "occupancy"]),
        ("report layers -m kplus-aray -o x.html".to_owned(), &["-m:", "kplus-array"]),
        ("report nothing -o x.html".to_owned(), &["nothing"]),
        ("report cubes --size 64x64 --max-memory 10K -o x.html".to_owned(), &["--max-memory:"]),
    ] {
        dir.run(&line).is_error(words);
    }
    assert_eq!(dir.names(), ["a.html", "b.html", "in.html", "scene.toml"]);
    // However the scene is spelled, it is not overwritten.
    std::os::unix::fs::symlink(dir.path("scene.toml"), dir.path("link.html")).expect("a link");
    dir.run("report scene.toml --size 8x8 -o link.html").is_error(&["-o:", "input"]);
    assert_eq!(dir.read("scene.toml"), scene.as_bytes());
}
