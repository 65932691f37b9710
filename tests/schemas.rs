//! The documents of `--json` are as docs/schemas says. A schema allows no other keys than it names, so that a document
//! that changes fails here until its schema changes too.

#[path = "support/schema.rs"]
mod schema;
#[path = "support/command.rs"]
#[allow(dead_code, reason = "its other users use the rest")]
mod support;

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use schema::errors;
use serde_json::Value;
use support::Dir;

const SIZE: &str = "--size 24x16 --json -q";

const KB: &str = "fl2-AAJrYgVrZWVwcwEBAQICAAAgAP7___8PEAAAAAAEAAADAQACAAABAQACAPaMs9qErdXIe8g8JlM";
const ENDLESS: &str = "fl2-AA9rcGx1cy1hcnJheUBNMTkLdGVybWluYXRpb24BAQECAgAAIAD-____DxAAAAAB\
                       IAQAAAEBAAEAAAEBAAEBAAABvfnt75HSrLwVca7usg";
const PANIC: &str = "fl2-AA5jb250cm9sQHBhbmljcwZwYW5pY3MBAQECAgAAIAD-____DxAAAAEAAgAAAQEAAgC0x9m9-OKv\
                     v9sBsNxDwA";

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("docs/schemas")
}

/// The names of all schemas.
fn names() -> Vec<String> {
    let entries = fs::read_dir(folder()).expect("a folder");
    let names = entries.map(|entry| entry.expect("an entry").file_name());
    let names = names.map(|name| name.into_string().expect("text"));
    let mut names: Vec<String> =
        names.filter_map(|name| Some(name.strip_suffix(".json")?.to_owned())).collect();
    names.sort();
    names
}

fn read(name: &str) -> Value {
    let text = fs::read_to_string(folder().join(format!("{name}.json"))).expect(name);
    serde_json::from_str(&text).expect(name)
}

/// Lines that print documents of a schema.
fn lines(name: &str) -> Vec<String> {
    let sized = |lines: &[&str]| lines.iter().map(|line| format!("{line} {SIZE}")).collect();
    let plain = |lines: &[&str]| lines.iter().map(|line| format!("{line} --json")).collect();
    match name {
        "render" => sized(&[
            "render layers:count=12 -m ab-array",
            "render cubes -m kb --exec sim --reference exact",
            "render cubes -m ab-ll --exec threads --threads 2 --no-hash",
            "render cubes -m wboit",
            "render cubes -m skb+ofm -k 2",
            "render cubes -m ha64 --load 50",
            "render cubes -m k-variable --k-average 4",
            "render cubes -m kplus-array --cull occupancy",
            "render cubes -m ab-ll --effect ldi --voxels 8",
            "render cubes -m ab-ll --shadows",
            "render cubes -m ab-ll --memory-budget 100000",
            "render cubes -m ab-ll --exec sim --resident 64 --check-steps",
        ]),
        "frames" => sized(&["render cubes --frames 2", "render cubes --frames 2 -m hash-coherent"]),
        "compare" => sized(&[
            "compare cubes -m kb,ab-ll,wboit,skb+ofm,ha64,kplus-array --exec sim",
            "compare cubes -m k-variable,kplus-array --memory-budget 200000",
        ]),
        "errors" => ["kb,ab-ll,wboit", "z-buffer"]
            .map(|m| format!("compare cubes --size 24x16 -q -m {m} --exec sim --metrics json"))
            .to_vec(),
        "sweep" => sized(&["compare cubes -m kplus-array,ab-ll --sweep k=1,2"]),
        "check" => plain(&[
            "check kb -n 2 -k 1 --runs 20 -q",
            "check kplus-array@M19 -n 2 -k 1 --runs 0 -q --progress simt",
            "check --claim C6 -q",
            "check kb -n 2 -k 1 --outcomes -q",
            "check kb --scene cubes --size 16x16 --executions 3 -q",
        ]),
        "kill-matrix" => plain(&["check --mutation M1 -q", "check --mutation M11 -q"]),
        "bench" => plain(&[
            "bench layers:count=3 -m ab-ll --size 16x16 --repeats 2 -q",
            "bench layers:count=3 -m ab-ll --size 16x16 --repeats 1 -q --scaling pixels --steps 2",
            "bench --explore kb --repeats 1 -q",
        ]),
        "golden-record" => sized(&["golden record g cubes -m ab-ll"]),
        "golden-verify" => vec!["golden verify g --json -q".to_owned()],
        "inspect" => sized(&[
            "inspect cubes --pixel 12,8 -m kb,dfb+sfm,wboit --exec sim",
            "inspect cubes --pixel 0,0",
        ]),
        "judge" => sized(&[
            "judge cubes a.png",
            "judge cubes a.png b.png --report page.html",
            "judge cubes f.npz -k 2",
        ]),
        "report" => sized(&["report cubes -m kb,wboit -o page.html"]),
        "info" => plain(&["info cubes", "info layers:count=2 --size 16x16"]),
        "replay" => [KB, ENDLESS, PANIC].map(|token| format!("replay {token} --json")).to_vec(),
        "timeline" => [KB, ENDLESS, PANIC].map(|t| format!("replay {t} -o t.json -q")).to_vec(),
        "export" => sized(&["export cubes -o x.glb"]),
        "reproduce" => plain(&["reproduce ha-table1 -q"]),
        "stability" => plain(&["methods --stability"]),
        name => plain(&[name]),
    }
}

/// Whether a document needs a device: then it is validated where there is one, as `tests/cli_gpu.rs` does.
fn needs_device(name: &str) -> bool {
    ["adapters", "crosscheck", "crosscheck-litmus"].contains(&name)
}

fn documents(name: &str) -> Vec<Value> {
    let dir = Dir::new();
    if name == "golden-verify" {
        let made = dir.run("golden record g cubes layers:count=4 --size 24x16 -m ab-ll -q");
        assert_eq!(made.code, 0, "{made:?}");
        // Another k: it is drawn otherwise.
        let path = dir.path("g/golden.toml");
        let text = fs::read_to_string(&path).expect("a manifest");
        fs::write(&path, text.replacen("\"ab-ll\"", "\"z-buffer\"", 1)).expect("a manifest");
    }
    if name == "judge" {
        for line in ["-m kplus-array -k 1 -o a.png", "-m exact -o b.png --fragments f.npz"] {
            assert_eq!(dir.run(&format!("render cubes --size 24x16 -q {line}")).code, 0, "{line}");
        }
    }
    let document = |line: &String| {
        let run = dir.run(line);
        assert!(run.code < 2, "{line}: {run:?}");
        if name != "timeline" {
            return run.json();
        }
        serde_json::from_slice(&dir.read("t.json")).expect("JSON")
    };
    lines(name).iter().map(document).collect()
}

#[track_caller]
fn is_valid(document: &Value, name: &str) {
    let wrong = errors(&read(name), document);
    assert!(wrong.is_empty(), "{name}: {}", wrong.join("\n"));
}

#[test]
fn documents_are_as_their_schemas_say() {
    for name in names().iter().filter(|name| !needs_device(name)) {
        let documents = documents(name);
        assert!(!documents.is_empty());
        documents.iter().for_each(|document| is_valid(document, name));
    }
}

#[test]
fn documents_of_devices_are_as_their_schemas_say() {
    let dir = Dir::new();
    let run = dir.run("adapters --json");
    if run.code == 2 {
        assert!(std::env::var_os("FRAGLOOM_ADAPTERS").is_none(), "{run:?}");
        println!("skipped: documents of devices need a Vulkan driver");
        return;
    }
    is_valid(&run.json(), "adapters");
    for (name, line) in [
        ("crosscheck", "crosscheck gears --size 31x21 -m ab-ll,kb --json -q"),
        ("crosscheck-litmus", "crosscheck --litmus --repeats 1 -m ab-ll --json -q"),
    ] {
        let run = dir.run(line);
        assert!(run.code < 2, "{line}: {run:?}");
        is_valid(&run.json(), name);
    }
}

/// Every schema is one, says its version, and is listed.
#[test]
fn schemas_say_their_versions_and_are_listed() {
    let list = fs::read_to_string(folder().join("README.md")).expect("a list");
    let mut ids = BTreeSet::new();
    for name in names() {
        let schema = read(&name);
        let id = schema["$id"].as_str().expect("an $id").to_owned();
        let version = id.strip_prefix(&format!("urn:fragloom:schema:{name}:"));
        assert!(version.is_some_and(|version| version.parse::<u32>().is_ok()), "{id}");
        assert!(ids.insert(id));
        assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema", "{name}");
        assert!(list.contains(&format!("[{name}]({name}.json)")), "{name} is not listed");
    }
    assert!(ids.len() >= 24, "{ids:?}");
}

/// The places of a document's keys, each once for all elements of an array.
fn places(value: &Value, at: &str, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                let own = format!("{at}/{key}");
                places(value, &own, found);
                found.insert(own);
            }
        }
        Value::Array(list) => {
            list.iter().take(1).for_each(|value| places(value, &format!("{at}/0"), found));
        }
        _ => {}
    }
}

/// Whether an object's keys are free: names of counters, of phases, of reasons.
fn is_free(at: &str) -> bool {
    ["dropped", "counters", "seconds", "open_pixels", "keeps"]
        .iter()
        .any(|free| at.contains(&format!("/{free}/")))
}

/// Negative control: a key that is renamed, left out or of another type is found, wherever it stands.
#[test]
fn a_changed_document_is_refused() {
    let mut count = 0;
    for name in
        ["render", "compare", "errors", "inspect", "info", "replay", "timeline", "golden-verify"]
    {
        let schema = read(name);
        let document = documents(name).swap_remove(0);
        let mut found = BTreeSet::new();
        places(&document, "", &mut found);
        for at in found.iter().filter(|at| !is_free(at)) {
            let (parent, key) = at.rsplit_once('/').expect("a key");
            let change = |change: &dyn Fn(&mut serde_json::Map<String, Value>)| {
                let mut changed = document.clone();
                let object = changed.pointer_mut(parent).and_then(Value::as_object_mut);
                change(object.expect("an object"));
                changed
            };
            let renamed = change(&|object| {
                let value = object.remove(key).expect("it is there");
                object.insert(format!("{key}_"), value);
            });
            assert!(!schema::is_valid(&schema, &renamed), "{name}: {at} renamed");
            // No key has pairs of text and truth.
            let retyped = change(&|object| {
                object.insert(key.to_owned(), serde_json::json!([["", true]]));
            });
            assert!(!schema::is_valid(&schema, &retyped), "{name}: {at} of another type");
            let absent = change(&|object| {
                object.remove(key);
            });
            let optional = !schema::is_valid(&schema, &absent);
            count += usize::from(optional);
        }
    }
    println!("{count} keys must be there");
    assert!(count > 200, "{count}");
}

/// The validator against cases that are right by reading.
#[test]
fn the_validator_knows_right_from_wrong() {
    use serde_json::json;
    let schema = json!({
        "type": "object",
        "properties": {
            "a": { "type": ["integer", "null"], "minimum": 0 },
            "b": { "type": "array", "items": { "$ref": "#/$defs/word" } },
            "c": { "anyOf": [{ "type": "number" }, { "enum": ["x", "y"] }] },
            "d": { "type": "object", "additionalProperties": { "type": "boolean" } },
            "e": { "oneOf": [{ "const": 1 }, { "type": "integer" }] },
        },
        "required": ["a"],
        "additionalProperties": false,
        "$defs": { "word": { "type": "string", "pattern": "^fl2-" } },
    });
    for right in [
        json!({ "a": 0 }),
        json!({ "a": null, "b": ["fl2-a", "fl2-"], "c": 0.5, "d": { "p": true }, "e": 2 }),
        json!({ "a": 7, "b": [], "c": "y", "d": {} }),
    ] {
        assert_eq!(errors(&schema, &right), Vec::<String>::new(), "{right}");
    }
    for wrong in [
        json!([]),
        json!({}),
        json!({ "a": -1 }),
        json!({ "a": 1.5 }),
        json!({ "a": "1" }),
        json!({ "a": 1, "z": 1 }),
        json!({ "a": 1, "b": ["fl1-a"] }),
        json!({ "a": 1, "b": [1] }),
        json!({ "a": 1, "c": "z" }),
        json!({ "a": 1, "d": { "p": 1 } }),
        json!({ "a": 1, "e": 1 }),
    ] {
        assert_eq!(errors(&schema, &wrong).len(), 1, "{wrong}");
    }
    let unknown = std::panic::catch_unwind(|| errors(&json!({ "maxItems": 1 }), &json!([])));
    assert!(unknown.is_err(), "a keyword that is not checked");
}
