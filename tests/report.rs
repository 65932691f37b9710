//! `fragloom report`: what the page shows in a real browser after clicks and keys, against the library; and the command.

#[path = "support/browser.rs"]
mod browser;
#[path = "report/changed.rs"]
mod changed;
#[path = "support/command.rs"]
mod command;
#[path = "report/files.rs"]
mod files;
#[path = "report/judged.rs"]
mod judged;
#[path = "report/looks.rs"]
mod looks;
#[path = "report/pixels.rs"]
mod pixels;
#[path = "report/tables.rs"]
mod tables;
#[path = "report/verdicts.rs"]
mod verdicts;

use std::fs;
use std::path::PathBuf;

use browser::Browser;
use command::Dir;
use fragloom::catalogue;
use fragloom::inspect::{Fate, Inspected, Inspection, inspect};
use fragloom::render::{Data, Exec, Options, Sim};
use fragloom::report::json;
use fragloom::report::page::drawing::{Row, drawing};
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
            a.len() == b.len() && a.iter().all(|(key, a)| b.get(key).is_some_and(|b| same(a, b)))
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

fn order(browser: &mut Browser) -> Vec<String> {
    cells(browser, ".kind-table").into_iter().map(|mut row| row.remove(0)).collect()
}

fn names(rows: &[Row]) -> Vec<String> {
    rows.iter().map(|row| row.title.clone()).collect()
}
