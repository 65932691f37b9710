//! The command: files in, exit codes and maps out.

#![expect(clippy::unwrap_used, reason = "a test that cannot write its files fails")]

use std::fs;
use std::io::Cursor;

use fragloom::image::{Image, png};
use fragloom::judge::{Answer, Class};
use serde_json::Value;

use super::command::Dir;
use super::confusion::exact;
use super::support::scene;
use super::wrong::changed;

const SCENE: &str = "cubes --size 64x48";

/// Column, row, depth and data of a fragment.
type Line = (u32, u32, u32, u32);

fn picture(dir: &Dir, name: &str) -> Image {
    png::decode(Cursor::new(dir.read(name)), 4_096).unwrap()
}

fn put(dir: &Dir, name: &str, image: &Image) {
    fs::write(dir.path(name), png::encode(image).unwrap()).unwrap();
}

fn upside_down(image: &Image) -> Image {
    let rows = image.pixels.chunks(image.width as usize).rev();
    Image { pixels: rows.flatten().copied().collect(), ..*image }
}

fn names(counts: &Value) -> Vec<String> {
    let counts = counts.as_array().unwrap().iter();
    counts.map(|count| count["class"].as_str().unwrap().to_owned()).collect()
}

/// Of every format that `render` writes.
#[test]
fn its_own_pictures_are_right() {
    let dir = Dir::new();
    for (options, file) in [
        ("-o a.png", "a.png"),
        ("--bits 16 -o b.png", "b.png"),
        ("-o c.exr", "c.exr"),
        ("--transparent -o d.png", "d.png"),
        ("--transparent -o e.exr", "e.exr"),
        ("--fragments f.npz", "f.npz"),
    ] {
        let run = dir.run(&format!("render {SCENE} -m exact {options} -q"));
        assert_eq!(run.code, 0, "{run:?}");
        let run = dir.run(&format!("judge {SCENE} {file}"));
        assert_eq!(run.code, 0, "{run:?}");
        assert!(run.stdout.ends_with("\nright\n"), "{run:?}");
    }
    let run = dir.run(&format!("render {SCENE} -m kplus-array -k 3 -o k.png --fragments k.npz -q"));
    assert_eq!(run.code, 0, "{run:?}");
    for file in ["k.png", "k.npz"] {
        assert_eq!(dir.run(&format!("judge {SCENE} -k 3 {file}")).code, 0);
        let run = dir.run(&format!("judge {SCENE} {file} --json"));
        assert_eq!(run.code, 1, "{run:?}");
        let document = run.json();
        let own = if file == "k.png" { &document["pictures"] } else { &document["dumps"] };
        assert!(names(&own[0]["classes"]).contains(&"beyond-k".to_owned()), "{run:?}");
    }
}

#[test]
fn exit_codes_follow_what_is_allowed() {
    let dir = Dir::new();
    dir.run(&format!("render {SCENE} -m exact -o a.png -q"));
    put(&dir, "b.png", &upside_down(&picture(&dir, "a.png")));
    let run = dir.run(&format!("judge {SCENE} b.png"));
    assert_eq!(run.code, 1);
    assert!(run.stdout.contains("as if the picture were upside down"), "{}", run.stdout);
    assert!(run.stdout.contains("b.png: ") && run.stdout.contains("placement, 0 allowed"));
    let run = dir.run(&format!("judge {SCENE} b.png --json"));
    let document = run.json();
    assert_eq!((run.code, &document["exceeded"][0]["class"]), (1, &Value::from("placement")));
    let held = &document["pictures"][0]["hypothesis"];
    assert_eq!(held["class"], "placement");
    assert_eq!(held["explains"], held["of"]);
    let pixels = document["exceeded"][0]["pixels"].as_u64().unwrap();
    let run = dir.run(&format!("judge {SCENE} b.png --allow placement={pixels}"));
    assert_eq!(run.code, 0);
    assert!(run.stdout.ends_with("not right, but no more than is allowed\n"), "{}", run.stdout);
    let run = dir.run(&format!("judge {SCENE} b.png --allow placement={}", pixels - 1));
    assert_eq!(run.code, 1);
    // Rounding is allowed, unless it is not.
    let mut image = picture(&dir, "a.png");
    image.pixels[70][0] ^= 1;
    put(&dir, "c.png", &image);
    assert_eq!(dir.run(&format!("judge {SCENE} c.png")).code, 0);
    assert_eq!(dir.run(&format!("judge {SCENE} c.png --allow rounding=0")).code, 1);
    assert_eq!(dir.run(&format!("judge {SCENE} c.png --tolerance 0")).code, 1);
}

#[test]
fn maps_are_written() {
    let dir = Dir::new();
    dir.run(&format!("render {SCENE} -m exact -o a.png -q"));
    put(&dir, "b.png", &upside_down(&picture(&dir, "a.png")));
    assert_eq!(dir.run(&format!("judge {SCENE} b.png -o maps")).code, 1);
    let color = Class::Placement.color();
    let map = picture(&dir, "maps/classes.png");
    assert!(map.pixels.iter().filter(|p| p[..3] == color).count() > 100);
    let difference = picture(&dir, "maps/difference.png");
    assert_eq!((difference.width, difference.height), (64, 48));
    let run = dir.run(&format!("judge {SCENE} a.png b.png a.png -o runs --json"));
    let document = run.json();
    assert_eq!(document["runs"]["runs"], 3);
    assert_eq!(document["pictures"].as_array().unwrap().len(), 3);
    assert!(names(&document["runs"]["classes"]).contains(&"placement".to_owned()));
    let files = fs::read_dir(dir.path("runs")).unwrap();
    let mut files: Vec<String> =
        files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
    files.sort();
    let expected = [
        "classes-1.png",
        "classes-2.png",
        "classes-3.png",
        "difference-1.png",
        "difference-2.png",
        "difference-3.png",
        "runs-difference.png",
        "runs.png",
    ];
    assert_eq!(files, expected);
    let other = dir.run(&format!("judge {SCENE} b.png a.png a.png -o other"));
    assert_eq!(other.code, 1);
    for name in ["runs.png", "runs-difference.png"] {
        assert_eq!(dir.read(&format!("runs/{name}")), dir.read(&format!("other/{name}")));
    }
}

#[test]
fn what_is_wrong_is_told_and_nothing_is_written() {
    let dir = Dir::new();
    dir.run(&format!("render {SCENE} -m exact -o a.png -q"));
    dir.run("render cubes --size 32x48 -m exact -o small.png --fragments small.npz -q");
    fs::write(dir.path("text.png"), "no picture").unwrap();
    fs::write(dir.path("cut.png"), &dir.read("a.png")[..200]).unwrap();
    let npy = |shape: &str, data: &[u8]| {
        let text = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}}}\n");
        let head = [b"\x93NUMPY\x01\x00".to_vec(), (text.len() as u16).to_le_bytes().to_vec()];
        [head.concat(), text.into_bytes(), data.to_vec()].concat()
    };
    let mut floats = vec![0.5_f32; 64 * 48 * 3];
    floats[64 * 3 + 7] = f32::NAN;
    let data: Vec<u8> = floats.iter().flat_map(|c| c.to_le_bytes()).collect();
    fs::write(dir.path("nan.npy"), npy("(48, 64, 3)", &data)).unwrap();
    fs::write(dir.path("short.npy"), npy("(48, 64, 3)", &data[4..])).unwrap();
    fs::write(dir.path("a.csv"), "x,y,depth,data\n1,2,3\n").unwrap();
    fs::write(dir.path("far.csv"), "x,y,depth,data\n64,2,3,4\n").unwrap();
    for (line, words) in [
        ("small.png", &["small.png", "32x48", "64x48", "--size"][..]),
        ("small.npz", &["small.npz", "32x48", "64x48"]),
        ("text.png", &["text.png", "PNG", ".csv"]),
        ("cut.png", &["cut.png", "PNG"]),
        ("nan.npy", &["nan.npy", "pixel 2,1", "NaN"]),
        ("short.npy", &["short.npy", "data"]),
        ("none.png", &["none.png"]),
        ("a.csv", &["a.csv", "line 2", "data"]),
        ("far.csv", &["far.csv", "64,2"]),
        ("a.png --allow edges=3", &["--allow", "did you mean edge?"]),
        ("a.png --allow edge", &["--allow", "CLASS=PIXELS"]),
        ("a.png --edge-distance 2", &["--edge-distance", "0 to 1"]),
        ("a.png --depth-distance nan", &["--depth-distance", "0 to 1"]),
        ("a.png small.npz", &["fragments"]),
    ] {
        dir.run(&format!("judge {SCENE} {line} -o maps")).is_error(words);
        assert!(!dir.names().contains(&"maps".to_owned()), "{line}");
    }
    dir.run(&format!("judge {SCENE} a.png -o text.png")).is_error(&["-o", "text.png"]);
    fs::create_dir(dir.path("in")).unwrap();
    fs::copy(dir.path("a.png"), dir.path("in/classes.png")).unwrap();
    let before = dir.read("in/classes.png");
    dir.run(&format!("judge {SCENE} in/classes.png -o in")).is_error(&["in/classes.png"]);
    assert_eq!(dir.read("in/classes.png"), before);
    dir.run("judge scenes").is_error(&["PICTURE"]);
}

/// Fragments as text: what is missing, extra, doubled, elsewhere or in another order is told.
#[test]
fn dumps_are_compared_fragment_by_fragment() {
    let dir = Dir::new();
    let [width, height] = [160, 120];
    let scene = scene("cubes", [width, height]);
    let answer = Answer::new(&scene, &exact()).unwrap();
    let mut lines: Vec<Line> = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let list = answer.lists().pixel(x, y);
            lines.extend(list.iter().map(|e| (x, y, e.depth, e.color)));
        }
    }
    let write = |lines: &[Line]| {
        let rows = lines.iter().map(|(x, y, d, c)| format!("{x},{y},{d},{c}\n"));
        let text = format!("x,y,depth,data\n{}", rows.collect::<String>());
        fs::write(dir.path("a.csv"), text).unwrap();
    };
    let judged = || {
        let run = dir.run("judge cubes --size 160x120 a.csv --json");
        let document = run.json();
        let own = &document["dumps"][0];
        let counts = own["fragments"].as_array().unwrap().iter().map(|count| {
            (count["class"].as_str().unwrap().to_owned(), count["fragments"].as_u64().unwrap())
        });
        (run.code, counts.collect::<Vec<_>>(), own["first"][0].clone())
    };
    write(&lines);
    let all = lines.len() as u64;
    assert_eq!(judged(), (0, vec![("equal".to_owned(), all)], Value::Null));
    // A pixel in the middle of a face, with depths far apart.
    let format = fragloom::num::depth::Format::D32;
    let triangles = |x: u32, y: u32| {
        let list = answer.lists().pixel(x, y);
        list.iter().map(|e| e.triangle).collect::<Vec<u32>>()
    };
    // No edge is near where all around have the same.
    let inside = |x: u32, y: u32| {
        (x > 0 && y > 0 && x + 1 < width && y + 1 < height) && {
            let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
            around.into_iter().all(|(u, v)| triangles(u, v) == triangles(x, y))
        }
    };
    let place = (0..lines.len() - 2)
        .find(|&i| {
            let [a, b, c] = [lines[i], lines[i + 1], lines[i + 2]];
            let far = |a: Line, b: Line| {
                format.decode(b.2) - format.decode(a.2) > 0.0001 && (a.0, a.1) == (b.0, b.1)
            };
            let first = i == 0 || (lines[i - 1].0, lines[i - 1].1) != (a.0, a.1);
            let distinct = a.3 != b.3 && b.3 != c.3 && a.3 != c.3;
            first && far(a, b) && far(b, c) && distinct && inside(a.0, a.1)
        })
        .expect("three fragments");
    let with = |change: &dyn Fn(&mut Vec<Line>)| {
        let mut own = lines.clone();
        change(&mut own);
        write(&own);
        judged()
    };
    let one = |class: &str, of: u64| {
        let mut counts = vec![("equal".to_owned(), of), (class.to_owned(), 1)];
        counts.retain(|(_, n)| *n > 0);
        counts
    };
    let (code, counts, first) = with(&|own| {
        own.remove(place + 1);
    });
    assert_eq!((code, counts), (1, one("missing", all - 1)));
    let at = lines[place + 1];
    assert_eq!(first["class"], "missing");
    assert_eq!(first["pixel"], serde_json::json!([at.0, at.1]));
    assert_eq!((&first["index"], &first["depth"]), (&Value::from(1), &Value::from(at.2)));
    assert!(first["triangle"].is_u64());
    let (code, counts, _) = with(&|own| own.insert(place, own[place]));
    assert_eq!((code, counts), (1, one("duplicated", all)));
    let (code, counts, _) = with(&|own| own[place].2 += 1 << 24);
    assert_eq!((code, counts), (1, one("depth", all - 1)));
    let (code, counts, _) = with(&|own| own[place].2 += 1);
    assert_eq!((code, counts), (0, vec![("equal".into(), all - 1), ("rounding".into(), 1)]));
    let (code, counts, _) = with(&|own| own[place].3 ^= 0x0070_0000);
    assert_eq!((code, counts), (1, one("data", all - 1)));
    let (code, counts, _) = with(&|own| own.swap(place, place + 1));
    assert_eq!((code, counts), (1, one("order", all - 1)));
    let (code, counts, _) = with(&|own| {
        let (x, y, ..) = own[place];
        own.insert(place, (x, y, 9, 0x1234_5678));
    });
    assert_eq!((code, counts), (1, one("extra", all)));
}

/// A picture whose opacity is written multiplied, where its format says it is not.
#[test]
fn opacity_is_read_as_the_format_says() {
    let dir = Dir::new();
    dir.run(&format!("render {SCENE} -m exact --transparent -o a.png -q"));
    let mut image = picture(&dir, "a.png");
    for pixel in &mut image.pixels {
        let a = u32::from(pixel[3]);
        for c in &mut pixel[..3] {
            *c = ((u32::from(*c) * a + 127) / 255) as u8;
        }
    }
    put(&dir, "b.png", &image);
    let run = dir.run(&format!("judge {SCENE} b.png --json"));
    let document = run.json();
    assert_eq!(run.code, 1);
    assert_eq!(document["pictures"][0]["hypothesis"]["class"], "opacity", "{}", run.stdout);
    let as_if = document["pictures"][0]["hypothesis"]["as_if"].as_str().unwrap();
    assert_eq!(as_if, "colours were multiplied by opacity");
    let run = dir.run(&format!("judge {SCENE} b.png --opacity premultiplied --tolerance 3"));
    assert_eq!(run.code, 0, "{run:?}");
    // Right colours with opacity that means nothing.
    dir.run(&format!("render {SCENE} -m exact -o c.png -q"));
    let mut image = picture(&dir, "c.png");
    image.pixels.iter_mut().for_each(|pixel| pixel[3] = 100);
    put(&dir, "c.png", &image);
    let document = dir.run(&format!("judge {SCENE} c.png --json")).json();
    assert_eq!(document["pictures"][0]["hypothesis"]["as_if"], "opacity were to be ignored");
    assert_eq!(dir.names(), ["a.png", "b.png", "c.png"], "without -o nothing is written");
    assert_eq!(dir.run(&format!("judge {SCENE} c.png --opacity ignored")).code, 0);
}

/// Which fragment is missing, in words.
#[test]
fn a_missing_fragment_is_told() {
    let dir = Dir::new();
    let scene = scene("cubes", [64, 48]);
    let answer = Answer::new(&scene, &exact()).unwrap();
    let gone = super::wrong::most_seen(&answer, &scene)[0];
    let image = changed(&answer, &scene, &|list| list.retain(|e| e.triangle != gone));
    put(&dir, "a.png", &image);
    let run = dir.run(&format!("judge {SCENE} a.png"));
    assert_eq!(run.code, 1);
    let told = format!("triangle {gone} is missing");
    assert!(run.stdout.contains(&told), "{}", run.stdout);
}
