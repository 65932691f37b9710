//! Pictures on surfaces: a pane of 16x16 pixels with pictures of 2x2, so that each texel covers 8x8 pixels.

use std::collections::BTreeMap;
use std::fs;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use fragloom::error::Result;
use fragloom::image::{Image, png};
use fragloom::raster::{CullFace, FrontEnd, Grid};
use fragloom::scene::{Overrides, Scene, Shading, load};
use serde_json::{Value, json};

const RED: [u8; 4] = [255, 0, 0, 255];
const GREEN: [u8; 4] = [0, 255, 0, 51];
const BLUE: [u8; 4] = [0, 0, 255, 102];
const WHITE: [u8; 4] = [255, 255, 255, 204];

/// Red, green above blue, white: opaque, a fifth, two fifths, four fifths.
fn picture() -> Vec<u8> {
    let pixels = vec![RED, GREEN, BLUE, WHITE];
    png::encode(&Image { width: 2, height: 2, pixels }).unwrap()
}

fn data(kind: &str, bytes: &[u8]) -> String {
    format!("data:{kind};base64,{}", BASE64_STANDARD.encode(bytes))
}

/// The pane, with this material; its picture is drawn without mixing.
fn document(material: &Value) -> Value {
    let corners = [[8.0, 8.0, 0.0], [24.0, 8.0, 0.0], [24.0, 24.0, 0.0], [8.0, 24.0, 0.0_f32]];
    // v goes down, y goes up.
    let places = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0_f32]];
    let colors = [[1.0, 1.0, 0.5, 0.5_f32]; 4];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
    bytes.extend(places.iter().flatten().flat_map(|c| c.to_le_bytes()));
    bytes.extend(colors.iter().flatten().flat_map(|c| c.to_le_bytes()));
    bytes.extend([0u8, 1, 2, 0, 2, 3]);
    json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{
            "attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 3, "material": 0}]}],
        "materials": [material],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"magFilter": 9728, "wrapS": 33071, "wrapT": 33071}],
        "images": [{"uri": data("image/png", &picture())}],
        "buffers": [{"byteLength": bytes.len(), "uri": data("", &bytes)}],
        "bufferViews": [
            {"buffer": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 64},
            {"buffer": 0, "byteOffset": 144, "byteLength": 6}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC4"},
            {"bufferView": 3, "componentType": 5121, "count": 6, "type": "SCALAR"}],
    })
}

const SCENE: &str = "size = [32, 32]\n[camera]\neye = [16, 16, 50]\ntarget = [16, 16, 0]\n\
    ortho_height = 32\nnear = 1\nfar = 100\n[light]\ntowards = [0, 0, 1]\nambient = 1\n\
    [[object]]\nfile = \"m.gltf\"\n";

fn scene(document: &Value, files: &[(&str, &[u8])]) -> Result<Scene> {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    write("m.gltf", document.to_string().as_bytes());
    write("s.toml", SCENE.as_bytes());
    files.iter().for_each(|(name, bytes)| write(name, bytes));
    load(folder.path().join("s.toml").to_str().unwrap(), &Overrides::default())
}

/// How often each RGBA word is drawn.
fn words(scene: &Scene) -> BTreeMap<[u8; 4], u32> {
    let front = FrontEnd::new(scene, Grid { width: 32, height: 32, tile: 32 }, 8, CullFace::None);
    let mut words = BTreeMap::new();
    front.packets_in_order(|packet| {
        let surface = front.surface(packet.primitive);
        for bit in (0..64).filter(|bit| packet.mask >> bit & 1 == 1) {
            let (x, y) =
                (u32::from(packet.column) * 8 + bit % 8, u32::from(packet.row) * 8 + bit / 8);
            *words.entry(surface.at(x, y).to_le_bytes()).or_default() += 1;
        }
    });
    let counted: u32 = front.counts().iter().sum();
    assert_eq!(counted, words.values().sum::<u32>(), "what is counted is what is drawn");
    words
}

/// The word at a pixel that one triangle covers.
fn word(scene: &Scene, x: u32, y: u32) -> [u8; 4] {
    let front = FrontEnd::new(scene, Grid { width: 32, height: 32, tile: 32 }, 8, CullFace::None);
    let mut found = None;
    front.packets_in_order(|packet| {
        let bit = (y % 8) * 8 + x % 8;
        let here = (u32::from(packet.column), u32::from(packet.row)) == (x / 8, y / 8);
        if here && packet.mask >> bit & 1 == 1 {
            found = Some(front.surface(packet.primitive).at(x, y).to_le_bytes());
        }
    });
    found.unwrap()
}

fn drawn(document: &Value) -> BTreeMap<[u8; 4], u32> {
    let scene = scene(document, &[]).unwrap();
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    words(&scene)
}

fn material(mode: &str) -> Value {
    json!({"alphaMode": mode, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
        "extensions": {"KHR_materials_unlit": {}}})
}

fn quarters(words: [[u8; 4]; 4]) -> BTreeMap<[u8; 4], u32> {
    let mut quarters = BTreeMap::new();
    words.into_iter().for_each(|word| *quarters.entry(word).or_default() += 64);
    quarters
}

#[test]
fn a_picture_gives_colour_and_opacity() {
    let document = document(&material("BLEND"));
    assert_eq!(drawn(&document), quarters([RED, GREEN, BLUE, WHITE]));
    let scene = scene(&document, &[]).unwrap();
    let places = [[9, 9], [22, 9], [9, 22], [22, 22]];
    assert_eq!(places.map(|[x, y]| word(&scene, x, y)), [RED, GREEN, BLUE, WHITE]);
}

#[test]
fn opaque_is_opaque() {
    let opaque = |[r, g, b, _]: [u8; 4]| [r, g, b, 255];
    let expected = quarters([RED, GREEN, BLUE, WHITE].map(opaque));
    assert_eq!(drawn(&document(&material("OPAQUE"))), expected);
}

/// What equals the cutoff is kept; what is left is opaque, and all else is not there for any method.
#[test]
fn a_mask_cuts_holes() {
    for (cutoff, left) in [
        (0.5, vec![RED, WHITE]),
        (0.4, vec![RED, BLUE, WHITE]),
        (102.0 / 255.0, vec![RED, BLUE, WHITE]),
        (0.41, vec![RED, WHITE]),
        (0.0, vec![RED, GREEN, BLUE, WHITE]),
        (1.0, vec![RED]),
        (1.01, vec![]),
    ] {
        let mut material = material("MASK");
        material["alphaCutoff"] = json!(cutoff);
        let expected: BTreeMap<_, _> =
            left.into_iter().map(|[r, g, b, _]| ([r, g, b, 255], 64)).collect();
        assert_eq!(drawn(&document(&material)), expected, "{cutoff}");
    }
    let mut material = material("MASK");
    material["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 1, 1, 0.5]);
    assert_eq!(drawn(&document(&material)), quarters_of(&[RED]), "the factor counts");
}

fn quarters_of(words: &[[u8; 4]]) -> BTreeMap<[u8; 4], u32> {
    words.iter().map(|&word| (word, 64)).collect()
}

/// Vertices (1, 1, 0.5, 0.5) times factor (1, 0.5, 1, 0.5) times picture.
#[test]
fn vertices_times_factor_times_picture() {
    let mut material = material("BLEND");
    material["pbrMetallicRoughness"]["baseColorFactor"] = json!([1, 0.5, 1, 0.5]);
    let mut document = document(&material);
    document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(2);
    let expected = [[255, 0, 0, 64], [0, 128, 0, 13], [0, 0, 128, 26], [255, 128, 128, 51]];
    assert_eq!(drawn(&document), quarters(expected));
}

#[test]
fn coordinates_are_scaled_then_turned_then_moved() {
    let with = |transform: &Value| {
        let mut material = material("BLEND");
        material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
            json!({"KHR_texture_transform": transform});
        drawn(&document(&material))
    };
    assert_eq!(with(&json!({"scale": [0.5, 0.5]})), BTreeMap::from([(RED, 256)]));
    let moved = json!({"scale": [0.5, 0.5], "offset": [0.5, 0.0]});
    assert_eq!(with(&moved), BTreeMap::from([(GREEN, 256)]));
    // The extension's example: the lower left quarter of the picture.
    let quarter = std::f64::consts::FRAC_PI_2;
    let turned = json!({"offset": [0, 1], "rotation": quarter, "scale": [0.5, 0.5]});
    assert_eq!(with(&turned), BTreeMap::from([(BLUE, 256)]));
    let beyond = json!({"offset": [1.25, 0.0], "scale": [0.5, 1.0]});
    assert_eq!(with(&beyond), BTreeMap::from([(GREEN, 128), (WHITE, 128)]), "clamped");
}

#[test]
fn pictures_go_on_as_their_samplers_say() {
    let with = |wrap: u32| {
        let mut material = material("BLEND");
        material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
            json!({"KHR_texture_transform": {"offset": [1.0, 0.0], "scale": [0.5, 0.5]}});
        let mut document = document(&material);
        document["samplers"][0]["wrapS"] = json!(wrap);
        drawn(&document)
    };
    assert_eq!(with(10_497), BTreeMap::from([(RED, 256)]));
    assert_eq!(with(33_648), BTreeMap::from([(GREEN, 256)]));
    assert_eq!(with(33_071), BTreeMap::from([(GREEN, 256)]));
}

/// Half way between the centres of red and green, light is half and half.
#[test]
fn pictures_are_mixed_unless_the_nearest_texel_is_asked_for() {
    let mut document = document(&material("OPAQUE"));
    document["samplers"] = json!([{"wrapS": 33071, "wrapT": 33071}]);
    let scene = scene(&document, &[]).unwrap();
    assert_eq!(word(&scene, 8, 8), RED, "beyond the centre of its texel, it is the texel");
    let [left, right] = [word(&scene, 15, 8), word(&scene, 16, 8)];
    assert_eq!(left, [143, 112, 0, 255], "(1 - f) * 255 with f = 7/16");
    assert_eq!(right, [112, 143, 0, 255]);
}

/// A grey JPEG of 8x8 pixels, by hand: one block whose coefficients are all 0.
fn jpeg() -> Vec<u8> {
    let mut bytes = vec![0xFF, 0xD8, 0xFF, 0xDB, 0, 67, 0];
    bytes.extend([1; 64]);
    bytes.extend([0xFF, 0xC0, 0, 11, 8, 0, 8, 0, 8, 1, 1, 0x11, 0]);
    for class in [0x00, 0x10] {
        bytes.extend([0xFF, 0xC4, 0, 20, class, 1]);
        bytes.extend([0; 15]);
        bytes.push(0);
    }
    bytes.extend([0xFF, 0xDA, 0, 8, 1, 1, 0, 0, 63, 0, 0b0011_1111, 0xFF, 0xD9]);
    bytes
}

/// From a file, a buffer view, or a URI; PNG of 8 or 16 bits, or JPEG.
#[test]
fn pictures_come_from_everywhere() {
    let mut document = document(&material("OPAQUE"));
    document["images"] = json!([{"uri": "a%20picture.png"}]);
    let found = scene(&document, &[("a picture.png", &picture())]).unwrap();
    assert_eq!(words(&found).len(), 4);
    assert!(found.files.iter().any(|file| file.ends_with("a picture.png")), "{:?}", found.files);
    document["images"] = json!([{"uri": data("image/jpeg", &jpeg())}]);
    // 128 of sRGB is 0.2159 of light: 55 of 255.
    assert_eq!(drawn(&document), BTreeMap::from([([55, 55, 55, 255], 256)]));
    let bytes = picture();
    document["buffers"]
        .as_array_mut()
        .unwrap()
        .push(json!({"byteLength": bytes.len(), "uri": data("", &bytes)}));
    document["bufferViews"]
        .as_array_mut()
        .unwrap()
        .push(json!({"buffer": 1, "byteLength": bytes.len()}));
    document["images"] = json!([{"bufferView": 4, "mimeType": "image/png"}]);
    assert_eq!(drawn(&document).len(), 4);
}

/// The surface is drawn without them, and they are named.
#[test]
fn pictures_that_cannot_be_had_are_left_out() {
    let plain = BTreeMap::from([([255, 255, 255, 255], 256)]);
    let mut cases = vec![];
    for (images, said) in [
        (json!([{"uri": "missing.png"}]), "image 0 \"missing.png\": cannot be read"),
        (json!([{"uri": "data:image/png;base64,AAAA"}]), "must be PNG or JPEG"),
        (json!([{"uri": data("", &picture()[..40])}]), "must be a PNG picture"),
        (json!([{"uri": data("", &jpeg()[..40])}]), "must be a whole JPEG picture"),
        (json!([{"uri": data("", b"RIFF....WEBP")}]), "is WebP"),
        (json!([{}]), "has neither uri nor bufferView"),
        (json!([{"bufferView": 9}]), "bufferView: 9 is not among the 4"),
    ] {
        let mut document = document(&material("OPAQUE"));
        document["images"] = images;
        cases.push((document, said));
    }
    let mut document = document(&material("OPAQUE"));
    document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(0);
    cases.push((document.clone(), "TEXCOORD_0: accessor 0: type: must be VEC2"));
    document["meshes"][0]["primitives"][0]["attributes"] = json!({"POSITION": 0});
    cases.push((document.clone(), "TEXCOORD_0: is missing"));
    document["textures"] = json!([{"extensions": {"EXT_texture_webp": {"source": 0}}}]);
    cases.push((document, "has no picture that is PNG or JPEG"));
    for (document, said) in cases {
        let scene = scene(&document, &[]).unwrap();
        assert_eq!(words(&scene), plain, "{said}");
        assert_eq!(scene.warnings.len(), 1, "{said}: {:?}", scene.warnings);
        assert!(scene.warnings[0].contains(said), "{said}: {:?}", scene.warnings);
    }
}

/// What is bare and opaque becomes half transparent, also where a picture is a mask.
#[test]
fn bare_files_keep_their_rule() {
    let bare = |document: &Value| {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.gltf");
        fs::write(&path, document.to_string()).unwrap();
        let scene = load(path.to_str().unwrap(), &Overrides::default()).unwrap();
        scene.materials[0].alpha
    };
    assert_eq!(bare(&document(&material("OPAQUE"))), 0.5);
    assert_eq!(bare(&document(&material("MASK"))), 0.5);
    assert_eq!(bare(&document(&material("BLEND"))), 1.0, "the picture lets light through");
}

/// A texture is no more than looks: the surface is drawn without it.
#[test]
fn broken_indices_are_named() {
    for (pointer, value, said) in [
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", json!(7), "index: 7 is not"),
        ("/materials/0/pbrMetallicRoughness/baseColorTexture/index", json!(-1), "index: must be"),
        ("/textures/0/source", json!(3), "image 3 is not among the 1"),
        ("/textures/0/source", json!("x"), "source: must be a whole number"),
    ] {
        let mut document = document(&material("BLEND"));
        *document.pointer_mut(pointer).unwrap() = value;
        let scene = scene(&document, &[]).unwrap();
        assert_eq!(words(&scene), BTreeMap::from([([255, 255, 255, 255], 256)]), "{said}");
        assert_eq!(scene.warnings.len(), 1, "{said}: {:?}", scene.warnings);
        for part in ["material", "baseColorTexture", said, "the texture is left out"] {
            assert!(scene.warnings[0].contains(part), "{part}: {:?}", scene.warnings);
        }
    }
}

/// The pane as an OBJ file, with a library in a folder, whose material has these lines.
fn obj(lines: &str) -> (BTreeMap<[u8; 4], u32>, Vec<String>, Vec<std::path::PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    fs::create_dir(folder.path().join("looks")).unwrap();
    write("looks/the picture.png", &picture());
    write("looks/a.mtl", format!("newmtl a\nillum 0\n{lines}\n").as_bytes());
    let model = "mtllib looks/a.mtl\nusemtl a\nv 8 8 0\nv 24 8 0\nv 24 24 0\nv 8 24 0\n\
        vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    write("m.gltf", b"");
    write("m.obj", model.as_bytes());
    write("s.toml", SCENE.replace("m.gltf", "m.obj").as_bytes());
    let overrides = Overrides { shading: Some(Shading::Flat), ..Overrides::default() };
    let scene = load(folder.path().join("s.toml").to_str().unwrap(), &overrides).unwrap();
    (words(&scene), scene.warnings, scene.files)
}

/// Between the centres of texels colours are mixed, so the corners tell: clamped, they are the texels.
fn has_all(words: &BTreeMap<[u8; 4], u32>, texels: [[u8; 4]; 4]) -> bool {
    texels.iter().all(|texel| words.contains_key(texel))
}

#[test]
fn materials_of_libraries_have_pictures_too() {
    let opaque = |[r, g, b, _]: [u8; 4]| [r, g, b, 255];
    let texels = [RED, GREEN, BLUE, WHITE];
    let (drawn, warnings, files) = obj("map_Kd -clamp on the picture.png");
    assert!(has_all(&drawn, texels.map(opaque)), "{drawn:?}");
    assert_eq!(drawn.values().sum::<u32>(), 256);
    assert!(warnings.is_empty(), "{warnings:?}");
    assert!(files.iter().any(|file| file.ends_with("looks/the picture.png")), "{files:?}");
    let half = |[r, g, b, _]: [u8; 4]| [r, g, b, 128];
    let (drawn, ..) = obj("d 0.5\nmap_Kd -clamp on the picture.png");
    assert!(has_all(&drawn, texels.map(half)), "the opacity is the material's: {drawn:?}");
    let (drawn, ..) = obj("Kd 1 0 1\nmap_Kd -clamp on the picture.png");
    assert!(
        has_all(&drawn, [RED, [0, 0, 0, 255], BLUE, [255, 0, 255, 255]].map(opaque)),
        "{drawn:?}"
    );
    let (drawn, warnings, _) = obj("map_Kd -clamp on the picture.png\nmap_d the picture.png");
    assert!(has_all(&drawn, texels), "its own opacity: {drawn:?}");
    assert!(warnings.is_empty(), "{warnings:?}");
    for (lines, said) in [
        ("map_Kd gone.png", "map_Kd gone.png: not found"),
        ("map_Kd a.mtl", "map_Kd a.mtl: must be PNG or JPEG"),
        ("map_d the picture.png", "map_d the picture.png: opacity is only read"),
        ("map_Kd -s 2 2 -mm 0 1 the picture.png", "options that move a picture"),
    ] {
        let (drawn, warnings, _) = obj(lines);
        assert_eq!(drawn.values().sum::<u32>(), 256, "{lines}");
        assert!(warnings.len() == 1 && warnings[0].contains(said), "{lines}: {warnings:?}");
    }
}
