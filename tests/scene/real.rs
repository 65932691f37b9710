//! Small files of each kind that public files showed: `tests/inputs/`. One unit is one pixel in their scene files, so that
//! fragments can be counted by hand: pixel centres inside of a polygon.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use fragloom::error::Result;
use fragloom::raster::{CullFace, FrontEnd, Grid};
use fragloom::scene::{Overrides, Scene, Shading, load};

use super::assert_fails;

/// What a drawing shows.
pub(crate) struct Shown {
    /// By pixel, how many fragments it has.
    pub(crate) counts: Vec<u32>,
    /// All different data words: RGBA8, red in the lowest byte.
    words: BTreeSet<u32>,
    warnings: Vec<String>,
}

impl Shown {
    pub(crate) fn fragments(&self) -> u32 {
        self.counts.iter().sum()
    }

    fn opacities(&self) -> Vec<u32> {
        self.words.iter().map(|word| word >> 24).collect::<BTreeSet<_>>().into_iter().collect()
    }

    fn colors(&self) -> Vec<[u8; 3]> {
        let color = |word: &u32| [*word as u8, (word >> 8) as u8, (word >> 16) as u8];
        self.words.iter().map(color).collect()
    }
}

fn path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/inputs").join(name)
}

fn scene(name: &str, overrides: &Overrides) -> Result<Scene> {
    load(path(name).to_str().unwrap(), overrides)
}

pub(crate) fn shown(scene: &Scene, cull: CullFace) -> Shown {
    let [width, height] = scene.size;
    let grid = Grid { width, height, tile: 64 };
    let front = FrontEnd::new(scene, grid, 8, cull);
    let mut counts = vec![0; (width * height) as usize];
    let mut words = BTreeSet::new();
    front.packets_in_order(|packet| {
        let surface = front.surface(packet.primitive);
        for bit in (0..64).filter(|bit| packet.mask >> bit & 1 == 1) {
            let x = u32::from(packet.column) * 8 + bit % 8;
            let y = u32::from(packet.row) * 8 + bit / 8;
            counts[(y * width + x) as usize] += 1;
            words.insert(surface.at(x, y));
        }
    });
    Shown { counts, words, warnings: scene.warnings.clone() }
}

/// As drawn from the folder's `s.toml`.
fn drawn(folder: &str) -> Shown {
    let scene = scene(&format!("{folder}/s.toml"), &Overrides::default()).unwrap();
    shown(&scene, CullFace::None)
}

/// Asserts how many fragments a folder has and that its warnings hold these parts, one each.
#[track_caller]
fn assert_drawn(folder: &str, fragments: u32, warnings: &[&str]) {
    let shown = drawn(folder);
    assert_eq!(shown.fragments(), fragments, "{folder}");
    assert_eq!(shown.warnings.len(), warnings.len(), "{folder}: {:?}", shown.warnings);
    for part in warnings {
        let said = shown.warnings.iter().any(|warning| warning.contains(part));
        assert!(said, "{folder}: {:?} do not say {part:?}", shown.warnings);
    }
}

#[test]
fn polygons_cover_each_pixel_once() {
    for (folder, fragments) in [
        ("concave-l-4", 864),
        ("concave-arrow-6", 912),
        ("concave-ply", 912),
        ("concave-star", 934),
        ("nonplanar-dart", 704),
    ] {
        assert_drawn(folder, fragments, &[]);
        assert!(drawn(folder).counts.iter().all(|&count| count <= 1), "{folder}");
    }
}

#[test]
fn mirrored_nodes_turn_their_faces_and_keep_their_shading() {
    let mirrored = scene("mirror-scale/s.toml", &Overrides::default()).unwrap();
    for (cull, fragments) in [(CullFace::None, 512), (CullFace::Back, 512), (CullFace::Front, 0)] {
        assert_eq!(shown(&mirrored, cull).fragments(), fragments, "{cull:?}");
    }
    let [mirrored, by_hand] = ["s", "hand"].map(|name| {
        let scene = scene(&format!("mirror-normals/{name}.toml"), &Overrides::default()).unwrap();
        shown(&scene, CullFace::Back)
    });
    assert_eq!((mirrored.fragments(), mirrored.counts), (512, by_hand.counts));
    assert_eq!(mirrored.words, by_hand.words);
}

#[test]
fn coordinates_far_away_are_doubles() {
    for folder in ["utm-obj", "utm-ply-binary"] {
        let [near, far] = ["near", "far"].map(|name| {
            let scene = scene(&format!("{folder}/{name}.toml"), &Overrides::default()).unwrap();
            shown(&scene, CullFace::None)
        });
        assert_eq!((near.fragments(), near.counts), (1248, far.counts), "{folder}");
    }
}

#[test]
fn opacities_are_what_the_file_means() {
    for (folder, opacity) in [
        ("vertex-alpha-gltf", 64),
        ("vertex-alpha-ply", 51),
        ("alpha-opaque", 255),
        ("alpha-mask-in", 255),
        ("alpha-blend", 102),
    ] {
        let shown = drawn(folder);
        assert_eq!((shown.opacities(), shown.fragments()), (vec![opacity], 512), "{folder}");
        assert!(shown.warnings.is_empty(), "{folder}: {:?}", shown.warnings);
    }
}

#[test]
fn what_changes_geometry_is_drawn() {
    assert_drawn("instancing", 320, &[]);
    assert_drawn("morph-weights", 240, &[]);
    assert_drawn("draco-fallback", 160, &[]);
}

#[test]
fn what_is_valid_is_drawn() {
    for folder in [
        "bom-obj",
        "latin1-comment",
        "continuation",
        "usemtl-nothing",
        "extras-string",
        "animation-path",
        "unused-buffer",
        "glb-third-chunk",
        "ply-numbers",
        "stl-comments",
        "tristrip",
        "cr-only",
        "required-khr_materials_unlit",
        "required-khr_xmp_json_ld",
    ] {
        assert_drawn(folder, 512, &[]);
    }
}

#[test]
fn what_is_left_out_is_named() {
    for (folder, warning) in [
        ("normal-index-out", "m.obj: line 6: f: normal 9 is not among the 1 so far"),
        ("unused-nan-vertex", "m.obj: line 5: v: \"nan\" is not a finite number"),
        ("vertex-w", "m.obj: line 1: v 8 8 0 0.5: w is a weight of free-form curves"),
        ("no-position", "m.gltf: mesh 0 primitive 1: has no POSITION"),
        ("two-corners", "m.obj: line 6: f 1 2: faces of fewer than 3 corners"),
        ("looks-khr_materials_volume", "extensionsUsed: KHR_materials_volume: is not drawn"),
        ("looks-khr_technique_webgl", "extensionsUsed: KHR_technique_webgl: is not drawn"),
    ] {
        assert_drawn(folder, 512, &[warning]);
    }
    let basis = ["extensionsUsed: GOOGLE_texture_basis: is not drawn", "texture 0: has no picture"];
    assert_drawn("looks-google_texture_basis", 512, &basis);
    assert_drawn("lines", 512, &["line 6: l 1 2 3: lines are not drawn", "points are not drawn"]);
}

#[test]
fn materials_are_found_and_clamped() {
    let flat = Overrides { shading: Some(Shading::Flat), ..Overrides::default() };
    let clamped = shown(&scene("kd-large/s.toml", &flat).unwrap(), CullFace::None);
    assert_eq!((clamped.colors(), clamped.fragments()), (vec![[255, 0, 77]], 512));
    assert_eq!(clamped.warnings.len(), 1);
    assert!(clamped.warnings[0].contains("material \"a\": Kd: 1.5: is not within 0 to 1"));
    for folder in ["mtllib-two", "mtllib-backslash"] {
        let blue = shown(&scene(&format!("{folder}/m.obj"), &flat).unwrap(), CullFace::None);
        assert_eq!((blue.colors(), blue.warnings), (vec![[0, 0, 255]], Vec::new()), "{folder}");
    }
}

#[test]
fn what_cannot_be_drawn_says_why() {
    for (file, parts) in [
        ("message-json/m.gltf", ["m.gltf: nodes: must be a list, not the number 5", "nodes"]),
        ("gltf-one/m.gltf", ["is glTF 1.0; convert it", "asset.version"]),
        ("guard-index-shared/m.obj", ["m.obj: line 4: f: vertex 4 is not among the 3", "4"]),
        ("guard-nan-shared/m.obj", ["is not a finite number", "m.obj: line "]),
        ("packed-splats/m.ply", ["packed_position: packed splats are not supported", "scale_0"]),
        ("guard-counts-shared/m.ply", ["3000000000 do not fit into", "element vertex"]),
    ] {
        assert_fails(scene(file, &Overrides::default()), &parts);
    }
}
