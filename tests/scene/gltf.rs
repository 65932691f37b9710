//! glTF and GLB.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use fragloom::error::{Error, Result};
use fragloom::scene::{GREY, Model, gltf};
use glam::DVec3;
use serde_json::{Value, json};

use super::{World, assert_fails};

/// Three positions, three u16 indices (padded), three RGBA8 colours, then sparse index 1 and its value.
fn buffer() -> Vec<u8> {
    let mut bytes = Vec::new();
    for value in [0.0_f32, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes.extend([0, 0, 1, 0, 2, 0, 0, 0]);
    bytes.extend([255, 0, 0, 255, 0, 255, 0, 128, 0, 0, 51, 0]);
    bytes.extend([1, 0, 0, 0]);
    for value in [5.0_f32, 6.0, 7.0] {
        bytes.extend(value.to_le_bytes());
    }
    bytes
}

/// A document with one triangle; tests change it.
fn document() -> Value {
    let uri = format!("data:application/octet-stream;base64,{}", BASE64_STANDARD.encode(buffer()));
    json!({
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5121, "count": 3, "type": "VEC4", "normalized": true},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 8},
            {"buffer": 0, "byteOffset": 44, "byteLength": 12},
            {"buffer": 0, "byteOffset": 56, "byteLength": 4},
            {"buffer": 0, "byteOffset": 60, "byteLength": 12},
        ],
        "buffers": [{"uri": uri, "byteLength": 72}],
    })
}

fn parse(document: &Value) -> Result<Model> {
    gltf::parse(document.to_string().as_bytes(), "test.gltf", &mut |name| match name {
        "a b.bin" => Ok(buffer()),
        _ => Err(Error::new(name, "cannot be read")),
    })
}

fn with(pointer: &str, value: Value) -> Value {
    let mut document = document();
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    let parent = document.pointer_mut(parent).unwrap();
    match parent {
        Value::Array(items) => items[key.parse::<usize>().unwrap()] = value,
        other => other[key] = value,
    }
    document
}

fn glb(json: &Value, bin: Option<&[u8]>) -> Vec<u8> {
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let chunk =
        |kind: &[u8; 4], data: &[u8]| [&(data.len() as u32).to_le_bytes()[..], kind, data].concat();
    let mut chunks = chunk(b"JSON", &json);
    chunks.extend(bin.map(|bin| chunk(b"BIN\0", bin)).unwrap_or_default());
    let length = chunks.len() as u32 + 12;
    [b"glTF", &2_u32.to_le_bytes()[..], &length.to_le_bytes(), &chunks].concat()
}

#[test]
fn a_triangle_from_a_data_uri_a_file_and_a_glb() {
    let model = parse(&document()).unwrap();
    let mesh = &model.objects[0].mesh;
    assert_eq!(mesh.positions, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    assert_eq!(mesh.triangles, [[0, 1, 2]]);
    assert_eq!(model.materials[model.objects[0].material].color, GREY);
    let file = parse(&with("/buffers/0/uri", json!("a%20b.bin"))).unwrap();
    assert_eq!(&file.objects[0].mesh, mesh);
    let embedded = glb(&with("/buffers/0", json!({"byteLength": 72})), Some(&buffer()));
    let embedded = gltf::parse(&embedded, "test.glb", &mut |_| unreachable!()).unwrap();
    assert_eq!(&embedded.objects[0].mesh, mesh);
}

#[test]
fn transforms_nest() {
    let mut document = with(
        "/nodes",
        json!([
            {"children": [1, 2], "translation": [10, 0, 0], "scale": [2, 2, 2]},
            {"mesh": 0, "rotation": [0, 0, 1, 1], "translation": [0, 1, 0]},
            {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 3, 4, 5, 1]},
        ]),
    );
    let model = parse(&document).unwrap();
    // Rotated (1, 0, 0) to (0, 1, 0), moved to (0, 2, 0), doubled, moved by 10.
    assert!((model.objects[0].world(1) - DVec3::new(10.0, 4.0, 0.0)).length() < 1e-6);
    assert_eq!(model.objects[1].world(0), DVec3::new(16.0, 8.0, 10.0));
    for key in ["scene", "scenes"] {
        document.as_object_mut().unwrap().remove(key);
    }
    assert_eq!(parse(&document).unwrap().objects.len(), 2, "without scenes, all roots are drawn");
}

#[test]
fn materials_and_colours() {
    let mut document = with(
        "/materials",
        json!([{"name": "m", "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 0.25, 0.125, 0.75],
            "baseColorTexture": {"index": 0}}, "alphaMode": "BLEND"}]),
    );
    document["meshes"][0]["primitives"][0] =
        json!({"attributes": {"POSITION": 0, "COLOR_0": 2}, "material": 0});
    document["textures"] = json!([{"source": 0}, {"source": 0}]);
    document["images"] = json!([{"uri": "missing.png"}]);
    let model = parse(&document).unwrap();
    let material = &model.materials[model.objects[0].material];
    assert_eq!((material.color, material.alpha), ([0.5, 0.25, 0.125], 0.75));
    assert_eq!(model.objects[0].mesh.colors, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 0.2]]);
    assert_eq!(model.objects[0].mesh.alphas, [1.0, 128.0 / 255.0, 0.0]);
    assert_eq!(model.objects[0].mesh.triangles, [[0, 1, 2]], "not indexed");
    assert_eq!(model.warnings.len(), 1, "{:?}", model.warnings);
}

#[test]
fn strips_fans_and_points() {
    let mut document = with(
        "/accessors/1",
        json!({"bufferView": 1, "componentType": 5121, "count": 6, "type": "SCALAR"}),
    );
    let triangles = |document: &Value| parse(document).unwrap().objects[0].mesh.triangles.clone();
    // Read as bytes, the indices are 0 0 1 0 2 0.
    document["meshes"][0]["primitives"][0]["mode"] = json!(5);
    assert_eq!(triangles(&document), [[0, 0, 1], [0, 0, 1], [1, 0, 2], [0, 0, 2]]);
    document["meshes"][0]["primitives"][0]["mode"] = json!(6);
    assert_eq!(triangles(&document), [[0, 1, 0], [1, 0, 0], [0, 2, 0], [2, 0, 0]]);
    document["meshes"][0]["primitives"][0]["mode"] = json!(0);
    assert_fails(parse(&document), &["test.gltf: meshes: the scene has no triangle"]);
}

#[test]
fn sparse_values_replace() {
    let sparse = json!({"count": 1,
        "indices": {"bufferView": 3, "componentType": 5121}, "values": {"bufferView": 4}});
    let document = with("/accessors/0/sparse", sparse.clone());
    let model = parse(&document).unwrap();
    assert_eq!(model.objects[0].mesh.positions[1], [5.0, 6.0, 7.0]);
    let zeros = json!({"componentType": 5126, "count": 3, "type": "VEC3", "sparse": sparse});
    let model = parse(&with("/accessors/0", zeros)).unwrap();
    assert_eq!(model.objects[0].mesh.positions, [[0.0; 3], [5.0, 6.0, 7.0], [0.0; 3]]);
}

#[test]
fn bad_documents_are_named() {
    let huge = u64::MAX;
    for (pointer, value, message) in [
        (
            "/accessors/0/count",
            json!(4),
            "POSITION: accessor 0: needs 48 bytes, its buffer view has 36",
        ),
        ("/accessors/0/count", json!(huge), "POSITION: accessor 0: needs"),
        ("/accessors/0/count", json!(0), "triangle 0: vertex of [0, 1, 2] is not below the 0"),
        ("/accessors/0/byteOffset", json!(huge), "POSITION: accessor 0: needs"),
        ("/accessors/0/type", json!("VEC2"), "POSITION: accessor 0: type: must be VEC3"),
        ("/accessors/0/type", json!("VEC9"), "POSITION: accessor 0: type: must be VEC3"),
        ("/accessors/0/componentType", json!(1), "accessor 0: componentType"),
        ("/accessors/0/bufferView", json!(9), "accessor 0: bufferView: 9 is not among the 5"),
        ("/accessors/1/type", json!("VEC3"), "indices: accessor 1: type: must be SCALAR"),
        ("/accessors/1/componentType", json!(5126), "indices: accessor 1: componentType"),
        ("/accessors/1/bufferView", json!(2), "triangle 0: vertex of [255, "),
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            json!(9),
            "POSITION: accessor 9: is not among the 3",
        ),
        ("/meshes/0/primitives/0/attributes", json!({}), "meshes: the scene has no triangle"),
        ("/meshes/0/primitives/0/indices", json!(9), "indices: accessor 9: is not among"),
        (
            "/meshes/0/primitives/0/material",
            json!(0),
            "mesh 0 primitive 0: material: 0 is not among the 0",
        ),
        ("/meshes/0/primitives/0/mode", json!(7), "mesh 0 primitive 0: mode"),
        (
            "/bufferViews/0/byteLength",
            json!(huge),
            "bufferView 0: 0..18446744073709551615 is not in buffer 0",
        ),
        ("/bufferViews/0/byteOffset", json!(huge), "bufferView 0: 18446744073709551615.."),
        ("/bufferViews/0/buffer", json!(1), "bufferView 0: 0..36 is not in buffer 1"),
        ("/bufferViews/0/byteStride", json!(4), "accessor 0: byteStride: 4 is not 12 to 252"),
        ("/bufferViews/0/byteStride", json!(0), "accessor 0: byteStride: 0 is not 12 to 252"),
        (
            "/buffers/0/byteLength",
            json!(73),
            "buffer 0: byteLength: is 73, but there are only 72 bytes",
        ),
        ("/buffers/0/uri", json!("none.bin"), "none.bin: cannot be read"),
        ("/buffers/0/uri", json!("http://host/a.bin"), "buffer 0: uri: must be a relative path"),
        ("/buffers/0/uri", json!("data:;base64,!!!!"), "buffer 0: uri: base64"),
        ("/buffers/0/uri", json!("data:,abc"), "buffer 0: uri: a data: URI must be base64"),
        ("/buffers/0/uri", json!("a%2"), "buffer 0: uri: % needs two"),
        ("/buffers/0", json!({"byteLength": 72}), "buffer 0: uri: is missing"),
        (
            "/nodes/0/children",
            json!([0]),
            "node 0: children: each node must have one parent and no cycle",
        ),
        ("/nodes/0/children", json!([7]), "node 7: there is no such node"),
        ("/nodes/0/mesh", json!(3), "nodes: mesh 3 is not among the 1"),
        ("/scenes/0/nodes", json!([4]), "node 4: there is no such node"),
        ("/scenes/0/nodes", json!([]), "needs at least one (1 in the file, but on no node"),
        ("/scene", json!(5), "scene: 5 is not among the 1"),
        (
            "/materials",
            json!([{"pbrMetallicRoughness": {"baseColorFactor": [2, 0, 0]}}]),
            "material \"material 0\": baseColorFactor: must be a list of 4 numbers",
        ),
        ("/nodes/0/matrix", json!([1, 2]), "node 0: matrix: must be a list of 16 numbers"),
        ("/nodes/0/mesh", json!(-1), "mesh: must be a whole number from 0, not the number -1"),
        ("/nodes/0/mesh", json!("a"), "mesh: must be a whole number from 0, not a text"),
        ("/nodes", json!(5), "nodes: must be a list, not the number 5"),
        ("/asset", json!({"version": "3.1"}), "asset.version: \"3.1\" is not known"),
        ("/asset", json!({"version": "1.0"}), "asset.version: is glTF 1.0; convert it"),
        (
            "/asset",
            json!({"version": "2.0", "minVersion": "2.1"}),
            "asset.minVersion: the file needs",
        ),
        (
            "/extensionsRequired",
            json!(["KHR_draco_mesh_compression"]),
            "extensionsRequired: \"KHR_draco",
        ),
        ("/asset", json!(3), "asset.version: is missing"),
    ] {
        assert_fails(parse(&with(pointer, value)), &[message]);
    }
}

#[test]
fn bad_containers_are_named() {
    let fails = |bytes: &[u8], message| {
        let result = gltf::parse(bytes, "test.glb", &mut |_| unreachable!());
        assert_fails(result, &["test.glb: ", message]);
    };
    fails(b"", "JSON: line 1: the text ends too early");
    fails(b"[1]", "JSON: must be an object");
    fails(br#"{"asset": 1e999}"#, "the number is too large");
    fails(b"glTF", "GLB header: length");
    fails(b"glTF\x02\0\0\0\x0b\0\0\0", "GLB header: length: must be at least 12");
    fails(b"glTF\x02\0\0\0\xff\xff\xff\xff", "GLB");
    let whole = glb(&document(), None);
    fails(&whole[..whole.len() - 4], "GLB");
    fails(&[&whole[..4], &[1, 0, 0, 0], &whole[8..]].concat(), "GLB");
    let cyclic = r#"{"asset":{"version":"2.0"},"nodes":[{"children":[1]},{"children":[0]}]}"#;
    fails(cyclic.as_bytes(), "meshes: the scene has no triangle");
    fails("[".repeat(100_000).as_bytes(), "JSON");
}
