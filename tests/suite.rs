//! `suite/`: each scene is small, says what it is for, is recorded, and is the same when it is exported and read back.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use fragloom::exec::Method;
use fragloom::golden::Manifest;
use fragloom::render::{CullFace, Options, Rendering, render};
use fragloom::scene::export::{Exported, export};
use fragloom::scene::file::{self, Source};
use fragloom::scene::{self, Overrides, Scene, gltf};

/// Whose numbers 32 bits do not hold.
const ROUNDED: [&str; 1] = ["glass-ball"];

fn home() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("suite")
}

/// The names of all scenes, and their files.
fn scenes() -> Vec<(String, PathBuf)> {
    let files = fs::read_dir(home()).expect("the suite").map(|entry| entry.expect("a file").path());
    let mut scenes: Vec<(String, PathBuf)> = files
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .map(|path| (path.file_stem().expect("a name").to_string_lossy().into_owned(), path))
        .filter(|(name, _)| name != "golden")
        .collect();
    scenes.sort();
    scenes
}

fn load(path: &Path) -> Scene {
    scene::load(&path.display().to_string(), &Overrides::default()).expect("a scene")
}

fn draw(scene: &Scene, options: &Options) -> Rendering {
    render(scene, options).expect("it can be drawn")
}

/// The scene that the exported files are.
fn read_back(exported: &Exported) -> Scene {
    let description = file::parse(exported.scene.as_bytes(), "scene.toml").expect("a scene file");
    let mut model = |source: Source<'_>| match source {
        Source::File("scene.glb") => {
            gltf::parse(&exported.glb, "scene.glb", &mut |_| panic!("whole"))
        }
        other => panic!("{other:?}"),
    };
    description.build(&Overrides::default(), &mut model, &mut |_| panic!("whole")).expect("a scene")
}

#[test]
fn scenes_are_small_and_say_what_they_are_for() {
    let page = include_str!("../docs/suite.md");
    let scenes = scenes();
    assert!(scenes.len() >= 40, "{}", scenes.len());
    for (name, path) in &scenes {
        let scene = load(path);
        assert!(
            scene.size.iter().all(|edge| (61..=128).contains(edge)),
            "{name}: {:?}",
            scene.size
        );
        assert!(scene.warnings.is_empty(), "{name}: {:?}", scene.warnings);
        let text = fs::read_to_string(path).expect("text");
        let head =
            text.lines().map_while(|line| line.strip_prefix("# ")).collect::<Vec<_>>().join(" ");
        assert!(head.len() > 30 && head.ends_with('.'), "{name}: {head}");
        assert!(
            page.contains(&format!("| `{name}` | {head} |\n")),
            "docs/suite.md: {name}: {head}"
        );
    }
    let rows = page.lines().filter(|line| line.starts_with("| `") && line.ends_with(". |"));
    let listed: BTreeSet<&str> = rows.filter_map(|line| line.split('`').nth(1)).collect();
    let extra = listed
        .iter()
        .filter(|name| !name.starts_with('.') && !scenes.iter().any(|(s, _)| s == *name));
    let keys = ["channel", "edges", "ties"];
    assert_eq!(
        extra.filter(|name| !keys.contains(name)).count(),
        0,
        "docs/suite.md lists no others"
    );
}

#[test]
fn all_are_recorded_with_their_pictures() {
    let manifest = Manifest::read(&home()).expect("a manifest");
    for (name, _) in scenes() {
        let file = format!("{name}.toml");
        let entry = manifest.entries().iter().find(|entry| entry.name == format!("{name}-exact"));
        let entry = entry.unwrap_or_else(|| panic!("{name} is not recorded"));
        assert_eq!((&entry.scene, entry.picture.is_some()), (&file, true));
    }
    assert!(manifest.entries().len() > scenes().len(), "others are recorded with options");
}

/// Bit for bit the same lists and picture, with either number of sub-pixel bits and each of the cullings.
#[test]
fn what_is_exported_draws_the_same() {
    let mut same = 0;
    for (name, path) in scenes() {
        let scene = load(&path);
        for (sub_pixel_bits, cull_face) in
            [(8, CullFace::None), (8, CullFace::Back), (4, CullFace::Front)]
        {
            let exported = export(&scene, "scene.glb", sub_pixel_bits).expect("exported");
            assert_eq!(exported.rounded > 0, ROUNDED.contains(&name.as_str()), "{name}");
            let options =
                Options { method: Method::EXACT, sub_pixel_bits, cull_face, ..Options::default() };
            let (drawn, again) = (draw(&scene, &options), draw(&read_back(&exported), &options));
            assert!(drawn.report.generated > 0 || cull_face != CullFace::None, "{name}");
            if exported.rounded == 0 {
                assert_eq!(drawn.kept, again.kept, "{name}");
                assert_eq!(drawn.image, again.image, "{name}");
                same += 1;
            }
        }
    }
    assert!(same >= 3 * 40, "{same}");
}

/// Negative control: a coordinate that moves by one bit, a colour, or another order is seen.
#[test]
fn a_change_of_what_is_exported_is_seen() {
    let options = Options { method: Method::EXACT, ..Options::default() };
    for name in ["interpenetrating", "equal-depths", "perspective-colours", "mirrored"] {
        let scene = load(&home().join(format!("{name}.toml")));
        let exported = export(&scene, "scene.glb", 8).expect("exported");
        let drawn = draw(&scene, &options);
        let json =
            20 + u32::from_le_bytes(exported.glb[12..16].try_into().expect("4 bytes")) as usize;
        let mut changed = exported.clone();
        // The exponent of the first coordinate.
        changed.glb[json + 8 + 3] ^= 1;
        assert_ne!(draw(&read_back(&changed), &options).kept, drawn.kept, "{name}");
        let nearer = Exported {
            scene: exported.scene.replace("size = [64,", "size = [65,"),
            ..exported.clone()
        };
        let nearer =
            Exported { scene: nearer.scene.replace("size = [96,", "size = [95,"), ..nearer };
        assert_ne!(draw(&read_back(&nearer), &options).kept, drawn.kept, "{name}");
    }
}

/// What is drawn in another order is the same picture.
#[test]
fn the_order_of_drawing_does_not_show() {
    let options = Options { method: Method::EXACT, ..Options::default() };
    let [one, two, three] = ["front-to-back", "back-to-front", "shuffled"]
        .map(|name| draw(&load(&home().join(format!("{name}.toml"))), &options));
    assert!(one.report.generated > 10_000);
    assert_eq!((&one.kept, &one.image), (&two.kept, &two.image));
    assert_eq!((&one.kept, &one.image), (&three.kept, &three.image));
}

#[test]
fn what_gltf_cannot_hold_is_refused() {
    let load = |source: &str| {
        let size = Some([16, 16]);
        scene::load(source, &Overrides { size, ..Overrides::default() }).expect("a scene")
    };
    for (source, word) in [("surfels", "discs"), ("scenes/volume.toml", "volumes")] {
        let source = match source.ends_with(".toml") {
            true => format!("{}/{source}", env!("CARGO_MANIFEST_DIR")),
            false => source.to_owned(),
        };
        let error = export(&load(&source), "x.glb", 8).expect_err("refused");
        assert!(error.to_string().contains(word), "{error}");
    }
    let mut both = load("cubes");
    both.screen = load("layers:count=1").screen;
    let error = export(&both, "x.glb", 8).expect_err("refused");
    assert!(error.to_string().contains("apart"), "{error}");
}
