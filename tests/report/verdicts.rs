//! Pages of verdicts, with their timelines, and of golden pictures.

use fragloom::catalogue::Catalogue;
use fragloom::explore::Token;
use fragloom::explore::replay::timeline::timeline;

use super::looks::NAMELESS;
use super::*;

/// Two fragments on a pixel: every interleaving of `kb`, which loses one.
const CHECK: &str = "check kb -n 2 -k 1 --memory-model sc --progress none --runs 0 --json";

/// The first violated row with a token.
fn violated(rows: &Value) -> &Value {
    let rows = rows.as_array().expect("rows");
    rows.iter().find(|row| row["verdict"] == "violated").expect("a violated row")
}

/// The first timeline of the page: steps on by the keyboard, until the fault is marked; what was told of each step, and
/// what memory held after it.
fn stepped(browser: &mut Browser) -> Vec<(String, Vec<String>)> {
    browser.eval("document.querySelector('.timeline').focus()");
    browser.key("Home", 0);
    let mut found = Vec::new();
    for _ in 0..200 {
        browser.key("ArrowRight", 0);
        let words = "[...document.querySelector('.timeline-memory tbody').rows].map((row) => row.cells[1].innerText.trim())";
        let words = serde_json::from_value(browser.eval(words)).expect("texts");
        found.push((browser.text(".timeline-told"), words));
        let marked = "document.querySelector('.timeline .timeline-now').classList.contains('timeline-fault')";
        if browser.eval(marked) == true {
            return found;
        }
        if browser.eval("document.querySelector('.timeline .timeline-steps tbody tr.timeline-step:last-of-type').ariaCurrent") == "step" {
            break;
        }
    }
    found
}

/// The same from the library.
fn expected(token: &str) -> Vec<(String, Vec<String>)> {
    let Token::Litmus(token) = token.parse().expect("a token") else { panic!("of a pixel") };
    let timeline = timeline(&Catalogue::built_in(), &token).expect("a timeline");
    let data = serde_json::to_value(&timeline).expect("JSON");
    let fault = data["fault"]["step"].as_u64().expect("a step") as usize;
    let steps = data["steps"].as_array().expect("steps");
    let text = |value: &Value| value.as_str().map_or_else(|| "-".to_owned(), str::to_owned);
    let words = data["words"].as_array().expect("words");
    let mut held: Vec<String> = words.iter().map(|word| text(&word["initial"])).collect();
    let mut found = Vec::new();
    for step in &steps[..fault] {
        for change in step["changes"].as_array().expect("changes") {
            held[change["word"].as_u64().expect("a word") as usize] = text(&change["value"]);
        }
        let number = |name: &str| step[name].as_u64().expect("a number") as usize;
        let lane = text(&data["stages"][number("stage")]["lanes"][number("lane")]["name"]);
        let told = format!(
            "step {} of {}: {lane}: {}",
            number("number"),
            steps.len(),
            text(&step["short"])
        );
        found.push((told, held.clone()));
    }
    found
}

#[test]
fn a_timeline_is_stepped_to_its_fault() {
    let dir = Dir::new();
    let run = dir.run(&format!("{CHECK} --report page.html"));
    assert_eq!((run.code, run.stderr.as_str()), (1, ""), "{run:?}");
    let rows = run.json();
    let row = violated(&rows);
    let token = row["token"].as_str().expect("a token");
    let Some(mut browser) = Browser::start() else { return };
    let path = dir.path("page.html");
    browser.open(&path);
    let shown = cells(&mut browser, ".kind-table");
    assert_eq!(shown.len(), rows.as_array().expect("rows").len());
    for (shown, row) in shown.iter().zip(rows.as_array().expect("rows")) {
        assert_eq!(
            (&shown[0][..], &shown[3][..]),
            (row["method"].as_str().expect("a name"), row["verdict"].as_str().expect("a verdict"))
        );
        assert_eq!(shown[7], row["message"].as_str().expect("a message"));
    }
    // The row leads to what is wrong, with the command that runs it again.
    browser.click(".kind-table tbody tr a");
    let target = browser.text(":target");
    assert!(target.contains(row["message"].as_str().expect("a message")), "{target}");
    assert!(target.contains(&format!("fragloom replay {token} --trace")), "{target}");
    let right = expected(token);
    assert!(right.len() > 2);
    assert_eq!(stepped(&mut browser), right);
    assert_eq!(browser.eval(NAMELESS), serde_json::json!([]));
    assert_eq!(browser.complaints(), Vec::<String>::new());

    // A page with another fault, or with a step that does something else, is seen to be wrong.
    let text = fs::read_to_string(&path).expect("a page");
    let fault = |step: usize| format!("\"shown\":\"doomed-after\",\"step\":{step}}}");
    for (from, to) in [
        (fault(right.len()), fault(right.len() - 1)),
        ("\"short\":\"load data".to_owned(), "\"short\":\"load other".to_owned()),
        ("\"value\":\"20\"".to_owned(), "\"value\":\"21\"".to_owned()),
    ] {
        let wrong = text.replacen(&from, &to, 1);
        assert_ne!(wrong, text, "{from}");
        fs::write(&path, wrong).expect("a file");
        browser.open(&path);
        assert_ne!(stepped(&mut browser), right, "{from}");
    }
}

#[test]
fn golden_pictures_that_differ_are_shown() {
    let dir = Dir::new();
    let run = dir.run("golden record goldens cubes layers:count=6 --size 60x40 -k 4");
    assert_eq!(run.code, 0, "{run:?}");
    let manifest = dir.path("goldens/golden.toml");
    let text = fs::read_to_string(&manifest).expect("a manifest");
    fs::write(&manifest, text.replacen("\"-k\", \"4\"", "\"-k\", \"1\"", 1)).expect("a file");
    let run = dir.run("golden verify goldens --json --report page.html");
    assert_eq!(run.code, 1, "{run:?}");
    let report = run.json();
    for bad in ["goldens/golden.toml", "page.txt", "goldens/cubes.png"] {
        dir.run(&format!("golden verify goldens --report {bad}")).is_error(&["--report:"]);
    }
    let Some(mut browser) = Browser::start() else { return };
    browser.open(&dir.path("page.html"));
    let shown = cells(&mut browser, ".kind-table");
    let outcomes = report["outcomes"].as_array().expect("outcomes");
    assert_eq!(outcomes.len(), 2);
    for (shown, outcome) in shown.iter().zip(outcomes) {
        for (cell, key) in [(0, "name"), (1, "status")] {
            assert_eq!(shown[cell], outcome[key].as_str().expect("text"));
        }
        assert_eq!(shown[4], outcome["why"].as_str().unwrap_or_default());
    }
    assert_eq!(browser.eval("document.querySelectorAll('.kind-pictures').length"), 1);
    browser.click(".kind-table tbody tr a");
    browser
        .wait("[...document.images].every((image) => image.complete && image.naturalWidth === 60)");
    assert_eq!(browser.text(":target h2"), shown[0][0]);
    assert!(browser.text(".name-left").contains("golden"));
    assert!(browser.text(".name-right").contains("drawn now"));
    assert_eq!(browser.eval("document.querySelectorAll('.gallery figure').length"), 3);
    assert_eq!(browser.eval(NAMELESS), serde_json::json!([]));
    assert_eq!(browser.complaints(), Vec::<String>::new());
}

#[test]
fn a_report_of_a_check_is_refused_where_it_would_overwrite() {
    let dir = Dir::new();
    fs::write(dir.path("in.html"), "").expect("a file");
    for (line, words) in [
        ("check kb --report page.txt", &["--report:", ".html"][..]),
        ("check kb --report no/page.html", &["--report:", "no"]),
        ("check --mutations --report page.html", &["--report"]),
    ] {
        dir.run(line).is_error(words);
    }
    assert_eq!(dir.names(), ["in.html"]);
}
