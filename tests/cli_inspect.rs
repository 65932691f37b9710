//! `fragloom inspect`: the table, the document, the plots, and what is said of wrong input.

#[path = "support/command.rs"]
mod support;

use serde_json::Value;
use support::Dir;

const LINE: &str =
    "inspect layers:count=6 --size 20x12 --pixel 9,4 -k 3 -m kplus-array,z-buffer,ab-ll";

#[test]
fn the_document_has_every_key() {
    let run = Dir::new().run(&format!("{LINE} --json"));
    assert_eq!(run.code, 0, "{run:?}");
    let found = run.json();
    let has = |value: &Value, keys: &[&str]| {
        keys.iter().for_each(|key| assert!(value.get(key).is_some(), "{key} in {value}"));
    };
    has(&found, &["pixel", "scene", "width", "height", "background", "fragments", "methods"]);
    has(&found["fragments"][0], &["index", "object", "triangle", "depth", "distance", "rgba"]);
    let method = &found["methods"][0];
    has(method, &["method", "k", "color", "difference", "records", "fates", "absorbance"]);
    has(&method["fates"][0], &["fate", "reason", "record"]);
    assert_eq!(found["pixel"], serde_json::json!([9, 4]));
    let sizes = |key: &str| found[key].as_array().unwrap().len();
    assert_eq!((sizes("fragments"), sizes("methods")), (6, 3));
}

/// Every number of the table is one of the document.
#[test]
fn the_table_tells_the_same() {
    let dir = Dir::new();
    let table = dir.run(LINE).stdout;
    let found = dir.run(&format!("{LINE} --json")).json();
    let (fragments, methods) =
        (found["fragments"].as_array().unwrap(), found["methods"].as_array().unwrap());
    let text = |value: &Value| value.as_str().map_or_else(|| value.to_string(), str::to_owned);
    let rows: Vec<Vec<&str>> = table.lines().map(|l| l.split_whitespace().collect()).collect();
    let heading = rows.iter().position(|row| row.first() == Some(&"#")).unwrap();
    for (fragment, row) in fragments.iter().zip(&rows[heading + 1..]) {
        let mut cells = vec![text(&fragment["index"]), "-".to_owned(), text(&fragment["triangle"])];
        cells.push(text(&fragment["depth"]));
        cells.push(format!("{:.6}", fragment["distance"].as_f64().unwrap()));
        let channels = fragment["rgba"].as_array().unwrap();
        cells.extend(channels.iter().map(text));
        cells.push(format!("{:.4}", channels[3].as_f64().unwrap() / 255.0));
        let index = fragment["index"].as_u64().unwrap() as usize;
        cells.extend(methods.iter().map(|method| text(&method["fates"][index]["fate"])));
        assert_eq!(*row, cells);
    }
    let methods_at = rows.iter().position(|row| row.first() == Some(&"method")).unwrap();
    for (method, row) in methods.iter().zip(&rows[methods_at + 2..]) {
        assert!(row[0].starts_with(method["method"].as_str().unwrap()), "{row:?}");
        let from = row.len() - row.iter().rev().position(|cell| cell.contains('.')).unwrap() - 5;
        let mut cells: Vec<String> =
            method["color"].as_array().unwrap()[..3].iter().map(text).collect();
        cells.push(text(&method["difference"]));
        cells.push(format!("{:.6}", method["absorbed"].as_f64().unwrap()));
        assert_eq!(row[from..from + 5], cells);
    }
    assert!(table.contains("kplus-array, k = 3"), "{table}");
    assert!(table.contains("beyond the nearest 3"), "{table}");
}

#[test]
fn fates_are_counted() {
    let found = Dir::new().run(&format!("{LINE} --json")).json();
    let kept = |method: usize| {
        let fates = found["methods"][method]["fates"].as_array().unwrap();
        fates.iter().filter(|fate| fate["fate"] == "kept").count()
    };
    assert_eq!([kept(0), kept(1), kept(2)], [3, 1, 6]);
    assert_eq!(found["methods"][2]["difference"], 0);
    assert_eq!(found["methods"][2]["absorbance"], found["exact"]["absorbance"]);
}

#[test]
fn plots_are_written_by_their_ending() {
    let dir = Dir::new();
    let run = dir.run(&format!("{LINE} -o a.svg -o b.png"));
    assert_eq!(run.code, 0, "{run:?}");
    assert_eq!(dir.names(), ["a.svg", "b.png"]);
    let svg = String::from_utf8(dir.read("a.svg")).unwrap();
    assert_eq!(svg.matches("<polyline").count(), 4);
    assert!(svg.contains("kplus-array, k = 3") && svg.contains("pixel 9,4"));
    let mut reader =
        png::Decoder::new(std::io::Cursor::new(dir.read("b.png"))).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height), (1_440, 880));
    let again = Dir::new();
    again.run(&format!("{LINE} -o b.png"));
    assert_eq!(dir.read("b.png"), again.read("b.png"));
}

#[test]
fn wrong_input_is_one_message() {
    let dir = Dir::new();
    let layers = "inspect layers:count=2 --size 8x8";
    for (line, words) in [
        (format!("{layers} --pixel 8,0"), &["--pixel:", "8,0", "8x8"][..]),
        (format!("{layers} --pixel 3"), &["--pixel:", "COLUMN,ROW"]),
        (format!("{layers} --pixel -1,3"), &["--pixel:", "COLUMN,ROW"]),
        (layers.to_owned(), &["--pixel"]),
        (format!("{layers} --pixel 1,1 -m kplus-aray"), &["-m:", "did you mean kplus-array?"]),
        (format!("{layers} --pixel 1,1 -m occupancy"), &["-m:", "occupancy"]),
        (format!("{layers} --pixel 1,1 -k 0"), &["-k"]),
        (format!("{layers} --pixel 1,1 -o plot.pdf"), &["-o:", "plot.pdf", ".png or .svg"]),
        (format!("{layers} --pixel 1,1 -o no/plot.png"), &["-o:", "no"]),
        (format!("{layers} --pixel 1,1 -o a.png -o a.png"), &["-o:", "a.png"]),
        ("inspect nothing --pixel 1,1".to_owned(), &["nothing"]),
    ] {
        dir.run(&line).is_error(words);
    }
    assert!(dir.names().is_empty());
}
