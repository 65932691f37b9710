use super::*;

const TEXT: &str = r#"# Why.
format = 1

# The first.
[[entry]]
name = "one"
scene = "../a.toml"
options = ["-m", "exact"] # as it is
generated = 7
kept = 6
fragments_hash = "aaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaaa"
image_hash = "bbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbbb"
picture = "one.png"
program = "0.1.0"
inputs = [
    { file = "../a.toml", sha256 = "cccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccccc" },
    { file = "../gone.png" },
]

# By hand.
[[entry]]
name = "two"
scene = "cubes"
"#;

fn parse(text: &str) -> Result<Manifest> {
    Manifest::parse(PathBuf::from("golden.toml"), text.to_owned())
}

#[test]
fn an_entry_is_read_and_written_as_it_was() {
    let manifest = parse(TEXT).unwrap();
    assert_eq!(manifest.text(), TEXT);
    let [one, two] = manifest.entries() else { panic!("two entries") };
    assert_eq!(
        (one.scene.as_str(), &one.options[..]),
        ("../a.toml", &["-m", "exact"].map(str::to_owned)[..])
    );
    assert_eq!(one.results.as_ref().map(|r| (r.generated, r.kept)), Some((7, 6)));
    assert_eq!(one.inputs[1], Input { file: "../gone.png".to_owned(), sha256: None });
    assert_eq!((two.results.as_ref(), two.picture_file()), (None, "two.png".to_owned()));
    assert_eq!(manifest.entry("TWO"), Some(two));
    assert_eq!(manifest.folder(), Path::new("."));
}

#[test]
fn what_is_replaced_changes_its_own_lines_alone() {
    let mut manifest = parse(TEXT).unwrap();
    let mut one = manifest.entries()[0].clone();
    manifest.replace(one.clone());
    assert_eq!(manifest.text(), TEXT);
    one.results.as_mut().unwrap().kept = 5;
    one.inputs[1].sha256 = Some("d".repeat(64));
    manifest.replace(one.clone());
    let added = format!("../gone.png\", sha256 = \"{}\" }}", "d".repeat(64));
    let expected = TEXT.replace("kept = 6", "kept = 5").replace("../gone.png\" }", &added);
    assert_eq!(manifest.text(), expected);
    assert_eq!(parse(&manifest.text()).unwrap().entries()[0], one);
    one.results = None;
    one.picture = None;
    one.inputs.clear();
    manifest.replace(one.clone());
    assert_eq!(parse(&manifest.text()).unwrap().entries()[0], one);
}

#[test]
fn an_added_entry_is_read_back() {
    let mut manifest = parse(HEAD).unwrap();
    let mut entries = parse(TEXT).unwrap().entries;
    entries[0].options.push("--effect=csg=(a | \"b\")".to_owned());
    entries.iter().for_each(|entry| manifest.add(entry.clone()));
    manifest.keep_pictures(false);
    let again = parse(&manifest.text()).unwrap();
    assert_eq!(again.entries(), entries);
    assert!(!again.keeps_pictures() && parse(TEXT).unwrap().keeps_pictures());
    assert!(manifest.text().starts_with("# Golden pictures"), "{}", manifest.text());
    assert!(manifest.text().contains("\n\n[[entry]]\nname = \"two\"\n"), "{}", manifest.text());
}

#[test]
fn what_is_wrong_is_named() {
    let with = |old: &str, new: &str| {
        assert!(TEXT.contains(old), "{old}");
        parse(&TEXT.replacen(old, new, 1)).unwrap_err().to_string()
    };
    for (old, new, words) in [
        ("format = 1", "format = 2", &["format", "2"][..]),
        ("format = 1\n", "", &["format"]),
        ("kept = 6\n", "", &["\"one\"", "together"]),
        ("kept = 6", "kept = -6", &["line 10"]),
        ("kept = 6", "keeps = 6", &["line 10", "keeps"]),
        ("name = \"two\"", "name = \"ONE\"", &["\"ONE\"", "taken"]),
        ("name = \"two\"", "name = \"a/b\"", &["\"a/b\"", "a-z"]),
        ("name = \"two\"", "name = \"..\"", &["begin"]),
        ("name = \"two\"", "name = \"x.drawn\"", &[".drawn"]),
        ("name = \"two\"", "name = \"\"", &["1 to"]),
        ("\"cubes\"", "\"-\"", &["\"two\"", "scene"]),
        ("aaaa", "a", &["SHA-256"]),
        ("ccccc", "ccccg", &["SHA-256"]),
        ("[[entry]]", "[entry]", &["golden.toml"]),
    ] {
        let error = with(old, new);
        assert!(error.starts_with("golden.toml: ") && !error.contains('\n'), "{error}");
        assert!(words.iter().all(|word| error.contains(word)), "{words:?} in {error}");
    }
    let inline = "format = 1\nentry = [{ name = \"a\", scene = \"cubes\" }]\n";
    assert!(parse(inline).unwrap_err().problem().contains("[[entry]]"));
}

#[test]
fn paths_are_seen_from_the_folder() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    fs::create_dir_all(at("a/b")).unwrap();
    fs::write(at("a/x.obj"), "").unwrap();
    for (path, folder, expected) in [
        ("a/x.obj", "a", "x.obj"),
        ("a/x.obj", "a/b", "../x.obj"),
        ("a/./b/../x.obj", "a/b", "../x.obj"),
        ("c/new.obj", "a/b", "../../c/new.obj"),
        ("a/b", "a/b", ""),
    ] {
        assert_eq!(relative(&at(path), &at(folder)), expected, "{path} from {folder}");
    }
    let root = if cfg!(windows) { r"C:\" } else { "/" };
    let far = Path::new(root).join("nowhere/x.obj");
    assert!(relative(&far, dir.path()).ends_with("nowhere/x.obj"));
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(at("a"), at("link")).unwrap();
        assert_eq!(relative(&at("link/x.obj"), &at("a/b")), "../x.obj");
        assert_eq!(relative(&far, dir.path()), "/nowhere/x.obj");
    }
}

#[test]
fn a_file_has_its_hash() {
    let dir = tempfile::tempdir().unwrap();
    let (path, gone) = (dir.path().join("abc"), dir.path().join("gone"));
    fs::write(&path, "abc").unwrap();
    let hashes = Hashes::default();
    let found = inputs(&[path.clone(), gone.clone(), path], dir.path(), &hashes).unwrap();
    let sum = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    let expected = [("abc", Some(sum)), ("gone", None)]
        .map(|(file, sha256)| Input { file: file.to_owned(), sha256: sha256.map(str::to_owned) });
    assert_eq!(found, expected);
    assert!(hashes.of(dir.path()).is_err(), "a folder is no file");
}
