//! The command: its file, its errors, and names with signs.

use super::*;

/// A name that would end the script, or begin a tag.
const EVIL: &str = "</script><img src=x onerror=alert(1)>&amp;\"'<!--";

#[test]
fn names_with_signs_do_not_break_the_page() {
    let size = Some([40, 30]);
    let mut scene =
        scene::load("box", &Overrides { size, ..Overrides::default() }).expect("a scene");
    scene.name = EVIL.to_owned();
    scene.objects[0].name = EVIL.to_owned();
    let drawn = drawing(&scene, &[Options::default()]).expect("drawn");
    let dir = Dir::new();
    let path = dir.path("a<b>&c.html");
    let mut bytes = Vec::new();
    drawn.page.write(&mut bytes).expect("written");
    fs::write(&path, bytes).expect("a file");
    let Some(mut browser) = Browser::start() else { return };
    browser.open(&path);
    assert_eq!(browser.text("h1"), format!("{EVIL} at 40x30"));
    assert_eq!(browser.eval("document.title"), format!("{EVIL} at 40x30"));
    browser.click(".stage");
    shows(&mut browser, [20, 15]);
    let objects: Vec<String> =
        cells(&mut browser, ".fragments").into_iter().map(|mut row| row.remove(1)).collect();
    assert_eq!(objects, [EVIL, EVIL], "both faces of the box");
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
    assert!(
        table[0].starts_with("method") && table[1].starts_with("kplus-array, k = 2"),
        "{table:?}"
    );
    let document = dir.run(&format!("{line} -o b.html --json --threads 1")).json();
    assert_eq!(document[1]["method"], "ab-ll");
    assert_eq!(dir.read("a.html"), dir.read("b.html"));
    let scene = "[[object]]\nprocedural = \"box\"\n";
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
