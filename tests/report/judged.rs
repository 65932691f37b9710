//! The page of judged pictures, against what `judge --json` says.

use super::looks::NAMELESS;
use super::*;

#[test]
fn a_judged_picture_is_shown_with_its_classes() {
    let dir = Dir::new();
    let size = "--size 100x72";
    assert_eq!(dir.run(&format!("render cubes {size} -m kplus-array -k 2 -o a.png -q")).code, 0);
    for bad in ["page.txt", "a.png", "no/page.html"] {
        dir.run(&format!("judge cubes {size} a.png --report {bad}")).is_error(&["--report:"]);
    }
    assert_eq!(dir.names(), ["a.png"]);
    let run = dir.run(&format!("judge cubes {size} a.png --json --report page.html"));
    assert_eq!(run.code, 1, "{run:?}");
    let document = run.json();
    let verdict = &document["pictures"][0];
    let classes = verdict["classes"].as_array().expect("classes");
    assert!(classes.iter().any(|own| own["class"] == "beyond-k"));

    let Some(mut browser) = Browser::start() else { return };
    browser.open(&dir.path("page.html"));
    assert!(browser.text(".kind-facts").contains("not right: a.png"));
    let shown = cells(&mut browser, ".kind-table");
    assert_eq!(shown.len(), classes.len());
    for (shown, class) in shown.iter().zip(classes) {
        let number = |cell: usize| shown[cell].replace(',', "").parse::<u64>().expect("a number");
        assert_eq!(shown[0], class["class"].as_str().expect("text"));
        assert_eq!(number(1), class["pixels"].as_u64().expect("pixels"));
        assert_eq!(number(3), class["max_difference"].as_u64().expect("steps"));
        assert_eq!(
            [number(4), number(5)].map(Value::from)[..],
            class["first"].as_array().expect("a pixel")[..]
        );
    }
    let as_if = verdict["hypothesis"]["as_if"].as_str().expect("a hypothesis");
    assert!(browser.text(".kind-table").contains(&format!("As if {as_if}")));
    assert!(browser.text(".name-left").contains("exact"));
    assert!(browser.text(".name-right").contains("a.png"));
    let first = classes.iter().find(|own| own["class"] == "beyond-k").expect("a class");
    let pixel = [0, 1].map(|i| first["first"][i].as_u64().expect("a number") as u32);
    look_at(&mut browser, pixel);
    let exact = Options::default().exact(None);
    let found = inspect(&scene(), &[exact], pixel).expect("inspected");
    assert_eq!(differences(&mut browser, &found), Vec::<String>::new());
    assert!(found.fragments.len() > 2);
    assert_eq!(browser.eval(NAMELESS), serde_json::json!([]));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}
