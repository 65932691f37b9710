//! Timelines of tokens: what each step finds and leaves must follow from what the steps before it left.

#[path = "support/command.rs"]
#[allow(dead_code, reason = "its other users use the rest")]
mod support;

use std::process::Command;
use std::sync::OnceLock;

use fragloom::catalogue::Catalogue;
use fragloom::explore::program::controls;
use fragloom::explore::replay::timeline::{
    CauseKind, Locking, Operation, Shown, Step, Timeline, Version, timeline,
};
use fragloom::explore::{Limits, MemoryModel, Plan, Profile, Token, check};
use sha2::{Digest, Sha256};
use support::Dir;

const LIMITS: Limits<'_> = Limits { states: 100_000, cancelled: &|| false };

fn of(text: &str) -> Timeline {
    let Ok(Token::Litmus(token)) = text.parse() else { panic!("a token of a litmus pixel") };
    timeline(&Catalogue::built_in(), &token).expect("it runs again")
}

/// What is violated with two fragments, of wrong methods of every kind.
fn timelines() -> &'static [Timeline] {
    static ALL: OnceLock<Vec<Timeline>> = OnceLock::new();
    ALL.get_or_init(|| {
        let memory = [
            MemoryModel::Sequential,
            MemoryModel::Relaxed(Profile::Vulkan),
            MemoryModel::Relaxed(Profile::Glsl),
        ];
        let methods = [
            "kb",
            "kplus-array@published",
            "kplus-sb@published",
            "kplus-array@M1",
            "kplus-array@M19",
            "control@panics",
            "kb-mdt32",
        ];
        let plan = Plan {
            fragments: Some(2),
            ks: vec![1],
            memory: memory.to_vec(),
            runs: 0,
            ..Plan::default()
        };
        let rows = methods.iter().flat_map(|method| {
            let subject = controls::find(&Catalogue::built_in(), "METHOD", method).expect("known");
            check(&subject, &plan, &LIMITS)
        });
        rows.filter_map(|row| row.token).map(|token| of(&token)).collect()
    })
}

fn found(method: &str, property: &str, memory: &str) -> &'static Timeline {
    let is = |t: &&Timeline| (&*t.method, &*t.property, &*t.memory) == (method, property, memory);
    timelines().iter().find(is).expect("it is violated")
}

/// A step's value, computed again.
fn computed(step: &Step, read: u64, bits: u32) -> Option<u64> {
    let number = |text: &Option<String>| {
        text.as_ref().map(|text| u64::from_str_radix(text, 16).expect("hexadecimal"))
    };
    let operand = number(&step.operand);
    let value = match step.operation {
        Operation::Load | Operation::Merge | Operation::Panic => return None,
        Operation::Store | Operation::Exchange => operand?,
        Operation::CompareExchange => {
            if Some(read) != number(&step.expected) {
                return None;
            }
            operand?
        }
        Operation::Add => read.wrapping_add(operand?),
        Operation::And => read & operand?,
        Operation::Or => read | operand?,
        Operation::Min => read.min(operand?),
        Operation::Max => read.max(operand?),
    };
    Some(if bits == 32 { value & 0xFFFF_FFFF } else { value })
}

/// Go through a timeline with nothing but what it says: the first step that does not follow, in words.
fn inconsistency(timeline: &Timeline) -> Option<String> {
    let relaxed = timeline.memory == "relaxed";
    let first = |word: &fragloom::explore::replay::timeline::Word| {
        vec![Version { value: word.initial.clone(), by: None }]
    };
    let mut words: Vec<Vec<Version>> = timeline.words.iter().map(first).collect();
    let mut oldest = vec![vec![Some(0); timeline.lanes]; words.len()];
    for (i, step) in timeline.steps.iter().enumerate() {
        let wrong = |what: &str| Some(format!("step {}: {what}: {step:?}", i + 1));
        if step.number != i + 1 || step.lane >= timeline.stages[step.stage].lanes.len() {
            return wrong("its number or lane");
        }
        let lane = &timeline.stages[step.stage].lanes[step.lane];
        if let Some(word) = step.word {
            let before = &words[word];
            if before.last().expect("a version").value != step.before {
                return wrong("the value before");
            }
            if let Some(source) = step.read_from.as_ref() {
                let is = |v: &Version| {
                    v.by == source.step && (v.value == step.read || v.value.is_none())
                };
                let Some(at) = before.iter().position(is) else { return wrong("its source") };
                let newer: Vec<usize> = before[at + 1..].iter().filter_map(|v| v.by).collect();
                if newer != source.newer || oldest[word][step.lane].is_none_or(|old| old > at) {
                    return wrong("it may not read that");
                }
            } else if step.read.is_some() && !lane.helper {
                return wrong("no source");
            }
            let read =
                step.read.as_ref().map_or(0, |t| u64::from_str_radix(t, 16).expect("hexadecimal"));
            let own = computed(step, read, timeline.words[word].bits).map(|v| format!("{v:x}"));
            if own != step.written && !lane.helper {
                return wrong("what it writes");
            }
        }
        for change in &step.changes {
            let single = || vec![Version { value: change.value.clone(), by: None }];
            let mut after = if relaxed { change.versions.clone() } else { single() };
            if !relaxed {
                // Who wrote it is known from the steps.
                let wrote = Some(change.word) == step.word && step.written.is_some();
                after[0].by = if wrote { Some(step.number) } else { words[change.word][0].by };
            }
            words[change.word] = after;
            if relaxed {
                oldest[change.word].clone_from(&change.oldest);
            }
        }
        // A write of the value that is there changes who wrote it.
        if let (false, Some(word), Some(_)) = (relaxed, step.word, &step.written) {
            words[word][0].by = Some(step.number);
        }
        // What nobody can read any more is forgotten.
        let can_read = |word: usize| !relaxed || oldest[word].iter().any(Option::is_some);
        if let Some(word) = step.word.filter(|&word| can_read(word) && !lane.helper) {
            let there = |value: &Option<String>| words[word].iter().any(|v| v.value == *value);
            if step.written.is_some() && !there(&step.written) {
                return wrong("what it wrote is not there");
            }
            // A word that was never written has the value from now on.
            if step.before.is_none() && step.written.is_none() && !there(&step.read) {
                return wrong("what it read is not there");
            }
        }
    }
    None
}

#[test]
fn each_step_follows_from_those_before_it() {
    let all = timelines();
    for timeline in all {
        assert_eq!(inconsistency(timeline), None, "{} {}", timeline.method, timeline.token);
        assert!(!timeline.steps.is_empty() && timeline.stages[0].first == 1);
        assert!(timeline.words.iter().all(|w| !w.name.is_empty()));
    }
    let count = |memory| all.iter().filter(|t| t.memory == memory).count();
    println!("{} timelines, {} of relaxed memory", all.len(), count("relaxed"));
    assert!(count("sc") >= 8 && count("relaxed") >= 10);
    let profiles = all.iter().filter(|t| t.profile.as_deref() == Some("glsl"));
    assert!(profiles.flat_map(|t| &t.steps).any(|step| step.fences.is_some()));
}

/// Negative control: any value that is not what it was is found.
#[test]
fn a_timeline_with_a_wrong_value_is_found() {
    let good = found("kb", "keeps", "sc");
    for i in 0..good.steps.len() {
        let mut bad = good.clone();
        let step = &mut bad.steps[i];
        let value = if step.read.is_some() { &mut step.read } else { &mut step.written };
        *value = Some("77".to_owned());
        assert!(inconsistency(&bad).is_some(), "step {}", i + 1);
    }
    let mut bad = good.clone();
    bad.steps.swap(0, 1);
    assert!(inconsistency(&bad).is_some());
    let relaxed = found("kplus-array@published", "keeps", "relaxed");
    let mut bad = relaxed.clone();
    let change = bad.steps.iter_mut().flat_map(|s| &mut s.changes).find(|c| c.versions.len() > 1);
    change.expect("more than one value").versions.pop();
    assert!(inconsistency(&bad).is_some());
}

/// The pages' README has this token: which read was overtaken is known by reading.
#[test]
fn a_lost_update_is_named() {
    let timeline = found("kb", "keeps", "sc");
    let names: Vec<&str> = timeline.words.iter().map(|word| &*word.name).collect();
    assert_eq!(names, ["depth", "data"]);
    let lanes: Vec<&str> = timeline.stages[0].lanes.iter().map(|lane| &*lane.name).collect();
    assert_eq!(lanes, ["A 0/20", "B fffffffe/10"]);
    let fault = timeline.fault.as_ref().expect("it is violated");
    assert_eq!((fault.step, fault.shown), (Some(6), Shown::DoomedAfter));
    let cause = &fault.causes[0];
    assert_eq!((cause.kind, &cause.steps[..]), (CauseKind::LostUpdate, &[5, 6, 8][..]));
    assert_eq!(
        cause.message,
        "B fffffffe/10 reads 0 of data (step 5); A 0/20 writes 20 to data (step 6); \
         then B fffffffe/10 writes 0 to data (step 8), without having read it again"
    );
    let pixel = &timeline.result[0];
    assert_eq!(
        (pixel.expected.as_deref(), pixel.found.as_deref()),
        (Some("[0/20]"), Some("[0/0]"))
    );
    let fates: Vec<Option<&str>> = timeline.fragments.iter().map(|f| f.fate.as_deref()).collect();
    assert_eq!(fates, [Some("kept"), Some("culled")]);
}

#[test]
fn faults_of_every_kind_have_their_causes() {
    let cause = |method, property, memory| {
        let fault = found(method, property, memory).fault.as_ref().expect("violated");
        assert_eq!(fault.property, property);
        (fault.shown, fault.causes.first().map(|cause| cause.kind))
    };
    let early = (Shown::DoomedAfter, Some(CauseKind::ReadTooEarly));
    assert_eq!(cause("kplus-array@published", "keeps", "sc"), early);
    let race = (Shown::AtStep, Some(CauseKind::Race));
    assert_eq!(cause("kb", "race-free", "relaxed"), race);
    assert_eq!(cause("kplus-array@M1", "race-free", "relaxed"), race);
    let (_, stale) = cause("kplus-array@M1", "keeps", "relaxed");
    assert!(matches!(stale, Some(CauseKind::StaleRead | CauseKind::LostUpdate)), "{stale:?}");
    let step = (Shown::AtStep, Some(CauseKind::Step));
    assert_eq!(cause("control@panics", "panics", "sc"), step);
    assert_eq!(cause("kplus-array@M19", "termination", "sc"), (Shown::Cycle, None));
    // One result is about all schedules together.
    assert_eq!(found("kb-mdt32", "one-outcome", "sc").fault, None);
}

#[test]
fn locks_and_waits_are_marked() {
    let timeline = found("kplus-array@M19", "termination", "sc");
    let lock = timeline.words.iter().position(|word| word.lock).expect("it has a lock");
    assert_eq!(timeline.words[lock].name, "lock");
    let at_lock: Vec<(Option<Locking>, bool)> = timeline
        .steps
        .iter()
        .filter(|step| step.word == Some(lock))
        .map(|step| (step.lock, step.spins))
        .collect();
    assert!(at_lock.contains(&(Some(Locking::Locks), false)), "{at_lock:?}");
    assert!(at_lock.contains(&(Some(Locking::FindsLocked), true)), "{at_lock:?}");
}

const KB: &str = "fl2-AAJrYgVrZWVwcwEBAQICAAAgAP7___8PEAAAAAAEAAADAQACAAABAQACAPaMs9qErdXIe8g8JlM";

/// Pictures are the same bytes everywhere. When they are to change, look at them, and write the new hashes.
#[test]
fn the_command_writes_the_same_files_everywhere() {
    let dir = Dir::new();
    let line = format!("replay {KB} -o t.svg -o t.png -o t.html -o t.json -o folder");
    let run = dir.run(&line);
    assert_eq!(run.code, 1, "{run:?}");
    let names = ["t.svg", "t.png", "t.html", "t.json"];
    let first = names.map(|name| dir.read(name));
    dir.run(&line);
    assert_eq!(names.map(|name| dir.read(name)), first);
    assert!(dir.read("folder/trace.txt").starts_with(b"step "));
    let json: serde_json::Value = serde_json::from_slice(&first[3]).expect("JSON");
    assert_eq!((&json["version"], &json["token"]), (&1.into(), &KB.into()));
    let hash = |bytes: &[u8]| -> String {
        Sha256::digest(bytes)[..6].iter().map(|byte| format!("{byte:02x}")).collect()
    };
    assert_eq!([hash(&first[0]), hash(&first[1])], ["5a51b31b5e4c", "207ec05ada2b"]);
}

#[test]
fn what_cannot_be_written_is_said_before_anything_runs() {
    let dir = Dir::new();
    dir.run(&format!("replay {KB} -o none/t.svg")).is_error(&["-o", "none"]);
    dir.run(&format!("replay {KB} -o t.svg -o ./t.svg")).is_error(&["-o", "t.svg"]);
    dir.run("methods -o t.svg").is_error(&["--stability"]);
    dir.run("methods --stability -o t.jpg").is_error(&["-o", "t.jpg", ".png or .svg"]);
    assert_eq!(dir.names(), Vec::<String>::new());
}

/// A method's name, and so what a page shows of it, may be any text.
#[test]
fn names_with_markup_are_shown_as_they_are() {
    let mut timeline = of(KB);
    let nasty = "</script><b>&\"'";
    timeline.method = nasty.to_owned();
    timeline.words[0].name = nasty.to_owned();
    timeline.stages[0].lanes[0].name = nasty.to_owned();
    let svg = fragloom::report::timeline::svg(&timeline).expect("few steps");
    let shown = "&lt;/script&gt;&lt;b&gt;&amp;&quot;&#39;";
    assert!(svg.matches(shown).count() >= 4 && !svg.contains("<b>"), "{svg}");
    let page = fragloom::report::timeline::page(&timeline).expect("a page");
    assert_eq!(page.matches("</script>").count(), 2);
    assert!(page.contains(&format!("<title>{shown}: keeps</title>")) && !page.contains("<b>"));
    assert!(!page.contains("http://") && !page.contains("https://"), "no network");
}

/// A Chromium; or none, and a line that says so, unless `FRAGLOOM_BROWSER` demands one, as CI has it.
fn browser(test: &str) -> Option<String> {
    let demanded = std::env::var("FRAGLOOM_BROWSER").ok().filter(|name| !name.is_empty());
    let names = ["chromium", "chromium-browser", "google-chrome"].map(str::to_owned);
    let starts = |name: &&String| {
        Command::new(name).arg("--version").output().is_ok_and(|run| run.status.success())
    };
    let found = demanded.iter().chain(&names).find(starts).cloned();
    if found.is_none() {
        assert!(demanded.is_none(), "FRAGLOOM_BROWSER={demanded:?} does not start");
        println!("skipped: {test} needs Chromium");
    }
    found
}

/// What the page shows when its keys are pressed and its parts are clicked: written to the page's title.
#[test]
fn the_page_is_stepped_through_by_keys() {
    let Some(browser) = browser("the page of a timeline") else { return };
    let dir = Dir::new();
    dir.run(&format!("replay {KB} -o t.html -q"));
    let page = String::from_utf8(dir.read("t.html")).expect("text");
    let script = r#"<script>
        const page = document.getElementById("timeline"), seen = [];
        const press = (key) => document.activeElement.dispatchEvent(
            new KeyboardEvent("keydown", { key, bubbles: true }));
        const look = () => seen.push(page.dataset.step + " " +
            [...page.querySelectorAll(".timeline-memory tbody td")].map((cell) => cell.textContent).join(" "));
        look();
        press("ArrowRight"); press("ArrowRight"); press("ArrowRight"); look();
        press("f"); look();
        seen.push(page.querySelector("[aria-current=step]").textContent);
        press("End"); press("ArrowRight"); look();
        press("ArrowLeft"); look();
        page.querySelectorAll(".timeline-step")[4].click(); look();
        page.querySelector(".timeline-cause").click();
        page.querySelector(".timeline-cause").click();
        page.querySelector(".timeline-cause").click(); look();
        press("Home"); look();
        seen.push(page.querySelector(".timeline-wrong").textContent);
        document.title = seen.join("; ");
    </script></body>"#;
    std::fs::write(dir.path("t.html"), page.replace("</body>", script)).expect("a page");
    let mut command = Command::new(browser);
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"]);
    command.arg(format!("--user-data-dir={}", dir.path("profile").display()));
    command.arg(format!("file://{}", dir.path("t.html").display()));
    let run = command.output().expect("it starts");
    let shown = String::from_utf8_lossy(&run.stdout).into_owned();
    let title = shown.split_once("<title>").and_then(|(_, rest)| rest.split_once("</title>"));
    assert_eq!(
        title.map(|(title, _)| title),
        Some(
            "0 ffffffff -; 3 0 0; 6 0 20; 6store data := 20, kept; 8 0 0; 7 0 20; 5 0 0; 8 0 0; \
             0 ffffffff -; keeps: [0/0] instead of [0/20]"
        ),
        "{run:?}"
    );
}
