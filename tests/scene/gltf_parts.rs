//! glTF: what makes geometry (instances, morph targets, skins, hidden nodes), opacities, and parts that nobody draws.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use fragloom::error::Result;
use fragloom::scene::{Model, Shading, gltf};
use glam::DVec3;
use serde_json::{Value, json};

use super::{World, assert_fails};

/// A document whose accessors are these numbers, in f32.
fn document(accessors: &[(&str, &[f32])]) -> Value {
    let (mut bytes, mut views, mut list) = (Vec::new(), Vec::new(), Vec::new());
    for (i, (kind, values)) in accessors.iter().enumerate() {
        views.push(json!({"buffer": 0, "byteOffset": bytes.len(), "byteLength": 4 * values.len()}));
        bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
        let width = match *kind {
            "MAT4" => 16,
            "SCALAR" => 1,
            vector => vector[3..].parse::<usize>().unwrap(),
        };
        let count = values.len() / width;
        list.push(json!({"bufferView": i, "componentType": 5126, "count": count, "type": kind}));
    }
    let uri = format!("data:;base64,{}", BASE64_STANDARD.encode(&bytes));
    json!({
        "asset": {"version": "2.0"},
        "nodes": [{"mesh": 0, "name": "Pine"}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": list, "bufferViews": views,
        "buffers": [{"byteLength": bytes.len(), "uri": uri}],
    })
}

fn push(list: &mut Value, item: Value) {
    list.as_array_mut().unwrap().push(item);
}

const TRIANGLE: (&str, &[f32]) = ("VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 4.0, 0.0]);

fn parse(document: &Value) -> Result<Model> {
    gltf::parse(document.to_string().as_bytes(), "m.gltf", &mut |_| unreachable!())
}

#[test]
fn instances_are_objects() {
    let mut document = document(&[
        TRIANGLE,
        ("VEC3", &[0.0, 0.0, 0.0, 10.0, 0.0, 0.0]),
        ("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0]),
        ("VEC3", &[1.0, 1.0, 1.0, 2.0, 2.0, -2.0]),
    ]);
    let attributes = json!({"TRANSLATION": 1, "ROTATION": 2, "SCALE": 3});
    document["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    document["nodes"][0]["translation"] = json!([1, 0, 0]);
    document["extensionsRequired"] = json!(["EXT_mesh_gpu_instancing"]);
    let model = parse(&document).unwrap();
    assert_eq!((model.objects.len(), model.warnings.len()), (2, 0));
    assert_eq!(model.objects[0].world(1), DVec3::new(5.0, 0.0, 0.0));
    // Doubled, a quarter turn, moved by 10, then by 1.
    assert!((model.objects[1].world(1) - DVec3::new(11.0, 8.0, 0.0)).length() < 1e-12);
    document["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["SCALE"] = json!(0);
    assert_fails(parse(&document), &["node 0 \"Pine\": EXT_mesh_gpu_instancing: SCALE: 3 of them"]);
}

#[test]
fn morph_targets_move_by_their_weights() {
    let mut document =
        document(&[TRIANGLE, ("VEC3", &[0.0, 0.0, 2.0, 0.0, 0.0, 2.0, 0.0, 0.0, 2.0])]);
    document["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": 1}, {"POSITION": 9}]);
    document["meshes"][0]["weights"] = json!([0.5, 0]);
    document["nodes"] = json!([{"mesh": 0}, {"mesh": 0, "weights": [2.0, 0.0]}]);
    let model = parse(&document).unwrap();
    assert_eq!(model.objects[0].world(0).z, 1.0);
    assert_eq!(model.objects[1].world(0).z, 4.0);
    document["meshes"][0]["weights"] = json!([0, 1]);
    assert_fails(parse(&document), &["mesh 0 primitive 0: targets 1: POSITION: accessor 9"]);
}

#[test]
fn skins_stand_as_their_joints_do() {
    let mut unit = [0.0_f32; 16];
    (0..4).for_each(|i| unit[5 * i] = 1.0);
    let mut back = unit;
    back[12] = -1.0;
    let inverse = [unit, back].concat();
    let mut document = document(&[
        TRIANGLE,
        ("VEC4", &[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        ("VEC4", &[1.0, 0.0, 0.0, 0.0, 0.5, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
        ("MAT4", &inverse),
    ]);
    document["meshes"][0]["primitives"][0]["attributes"] =
        json!({"POSITION": 0, "JOINTS_0": 1, "WEIGHTS_0": 2});
    document["nodes"] = json!([
        {"mesh": 0, "skin": 0, "translation": [100, 0, 0]},
        {"children": [2]}, {"translation": [1, 2, 0]},
    ]);
    document["skins"] = json!([{"joints": [1, 2], "inverseBindMatrices": 3}]);
    let model = parse(&document).unwrap();
    assert!(model.warnings.is_empty(), "{:?}", model.warnings);
    // The second joint moves by (1, 2, 0) - (1, 0, 0).
    let found: Vec<_> = (0..3).map(|i| model.objects[0].world(i)).collect();
    assert_eq!(found, [DVec3::ZERO, DVec3::new(4.0, 1.0, 0.0), DVec3::new(0.0, 6.0, 0.0)]);
    document["skins"][0]["joints"] = json!([1, 7]);
    let model = parse(&document).unwrap();
    assert_eq!(model.objects[0].world(0).x, 100.0);
    assert!(model.warnings[0].contains("node 0: skin 0: a joint is not in the scene: the skin"));
}

#[test]
fn hidden_nodes_hide_their_children() {
    let mut document = document(&[TRIANGLE]);
    let hidden = json!({"KHR_node_visibility": {"visible": false}});
    document["nodes"] = json!([{"children": [1], "extensions": hidden}, {"mesh": 0}, {"mesh": 0}]);
    assert_eq!(parse(&document).unwrap().objects.len(), 1);
    document["nodes"][2]["extensions"] = hidden;
    let nothing = parse(&document).unwrap();
    assert_eq!((nothing.triangles(), nothing.objects.len()), (0, 1));
    assert!(nothing.warnings[0].contains("nothing is left to draw"));
}

/// The doubled area of what is left of the triangle.
fn area(model: &Model) -> f64 {
    let mesh = &model.objects[0].mesh;
    let areas = mesh.triangles.iter().map(|t| {
        let [a, b, c] = t.map(|i| DVec3::from(mesh.positions[i as usize]));
        (b - a).cross(c - a).z
    });
    areas.sum()
}

#[test]
fn masks_cut_where_the_opacity_is_too_low() {
    // Opacity 0.75, 0.25, 0.25.
    let colors: Vec<f32> = [0.75, 0.25, 0.25].iter().flat_map(|a| [1.0, 1.0, 1.0, *a]).collect();
    let mut document = document(&[TRIANGLE, ("VEC4", &colors)]);
    document["meshes"][0]["primitives"][0] =
        json!({"attributes": {"POSITION": 0, "COLOR_0": 1}, "material": 0});
    let mut with = |material: Value| {
        document["materials"] = json!([material]);
        parse(&document).unwrap()
    };
    let half = with(json!({"alphaMode": "MASK"}));
    assert_eq!((area(&half), half.objects[0].mesh.alphas.len()), (4.0, 0), "a quarter of 16");
    assert_eq!(half.materials[0].alpha, 1.0);
    assert_eq!(
        area(&with(json!({"alphaMode": "MASK", "alphaCutoff": 0.25}))),
        16.0,
        "equal is kept"
    );
    let factor = json!({"baseColorFactor": [1, 1, 1, 0.5]});
    let most = json!({"alphaMode": "MASK", "alphaCutoff": 0.25, "pbrMetallicRoughness": factor});
    assert_eq!(area(&with(most)), 4.0);
    assert_eq!(area(&with(json!({"alphaMode": "MASK", "alphaCutoff": 2}))), 0.0);
    assert!(with(json!({"alphaMode": "OPAQUE"})).objects[0].mesh.alphas.is_empty());
    let blend = with(json!({"alphaMode": "BLEND", "pbrMetallicRoughness": factor}));
    assert_eq!((blend.materials[0].alpha, blend.objects[0].mesh.alphas[0]), (0.5, 0.75));
    let strange = with(json!({"alphaMode": "GLASS", "extensions": {"KHR_materials_unlit": {}}}));
    assert_eq!((strange.materials[0].shading, strange.warnings.len()), (Shading::Flat, 1));
}

#[test]
fn vertex_colours_are_not_darkened_by_the_default_grey() {
    let mut document = document(&[TRIANGLE, ("VEC3", &[1.0; 9])]);
    document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(1);
    let model = parse(&document).unwrap();
    assert_eq!(model.materials[model.objects[0].material].color, [1.0; 3]);
}

#[test]
fn parts_that_nobody_draws_may_be_anything() {
    let mut document = document(&[TRIANGLE, ("VEC3", &[f32::NAN; 9])]);
    for key in ["asset", "nodes", "meshes", "buffers", "accessors"] {
        for extras in [json!("a note"), json!(3.5), json!([1, null]), json!({"a": {}}), Value::Null]
        {
            let object = &mut document[key];
            let object = if object.is_array() { &mut object[0] } else { object };
            object["extras"] = extras;
            assert_eq!(parse(&document).unwrap().triangles(), 1, "{key}");
        }
    }
    document["scene"] = json!(0.0);
    document["scenes"] = json!([{"nodes": [0.0]}, {"name": "empty"}, 7]);
    document["animations"] = json!([{"channels": "none", "samplers": [{"input": "x"}]}]);
    document["cameras"] = json!([{"type": "spherical"}]);
    document["textures"] = json!({});
    document["samplers"] = json!([{"magFilter": "soft"}]);
    push(&mut document["meshes"], json!({"primitives": [{"attributes": {"POSITION": 99}}]}));
    push(&mut document["buffers"], json!({"byteLength": 9}));
    document["nodes"][0]["camera"] = json!("here");
    document["nodes"][0]["mesh"] = Value::Null;
    document["nodes"][0] = json!({"mesh": 0e0, "name": 5});
    document["accessors"][0]["count"] = json!(3e0);
    let model = parse(&document).unwrap();
    assert_eq!((model.triangles(), model.warnings.len()), (1, 0), "{:?}", model.warnings);
    // Broken attributes are left out.
    document["meshes"][0]["primitives"][0]["attributes"] =
        json!({"POSITION": 0, "NORMAL": 1, "COLOR_0": 99, "_OWN": "x"});
    let model = parse(&document).unwrap();
    assert!(model.objects[0].mesh.normals.is_empty() && model.objects[0].mesh.colors.is_empty());
    assert!(
        model.warnings[0].contains("NORMAL: not all numbers are finite"),
        "{:?}",
        model.warnings
    );
    // With a byte order mark, and a name in Latin-1.
    document["nodes"][0]["name"] = json!("gr\u{fc}n");
    let latin: Vec<u8> = document.to_string().chars().map(|c| c as u8).collect();
    let marked = [&b"\xEF\xBB\xBF"[..], document.to_string().as_bytes()].concat();
    for bytes in [latin, marked] {
        assert_eq!(gltf::parse(&bytes, "m.gltf", &mut |_| unreachable!()).unwrap().triangles(), 1);
    }
}

#[test]
fn extensions_are_judged_by_what_they_change() {
    let mut document = document(&[TRIANGLE]);
    for (name, warning) in [
        ("KHR_materials_clearcoat", "KHR_materials_clearcoat: is not drawn"),
        ("KHR_lights_punctual", "KHR_lights_punctual: is not drawn"),
        ("KHR_xmp_json_ld", ""),
        ("KHR_animation_pointer", ""),
        ("KHR_mesh_quantization", ""),
    ] {
        document["extensionsRequired"] = json!([name]);
        document["extensionsUsed"] = json!([name]);
        let warnings = parse(&document).unwrap().warnings.join(";");
        assert!(
            warnings.contains(warning) && warnings.is_empty() == warning.is_empty(),
            "{warnings}"
        );
    }
    for name in ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "ACME_geometry"] {
        document["extensionsRequired"] = json!([name]);
        assert_fails(parse(&document), &["m.gltf: extensionsRequired: ", name, "is not supported"]);
    }
    document["extensionsRequired"] = json!([]);
    document["extensionsUsed"] = json!(["ACME_geometry"]);
    assert!(parse(&document).unwrap().warnings[0].contains("ACME_geometry: is not known"));
    document["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    push(
        &mut document["meshes"][0]["primitives"],
        json!({"attributes": {"POSITION": 1},
        "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0}}}),
    );
    push(&mut document["accessors"], json!({"componentType": 5126, "count": 3, "type": "VEC3"}));
    let packed = parse(&document).unwrap().warnings;
    assert!(packed[0].contains("mesh 0 primitive 1: KHR_draco_mesh_compression"), "{packed:?}");
}

/// As browsers do: blanks do not matter, nor what the last bits are, nor padding.
#[test]
fn base64_is_read_leniently() {
    let plain = document(&[TRIANGLE]);
    let expected = parse(&plain).unwrap().objects[0].mesh.clone();
    let uri = plain["buffers"][0]["uri"].as_str().unwrap();
    let (head, payload) = uri.split_once(',').unwrap();
    let broken = format!("{head},{}", payload[..20].to_owned() + "\n \t" + &payload[20..]);
    let mut longer = BASE64_STANDARD.decode(payload).unwrap();
    longer.push(0);
    // One byte more: two letters, the second of which has four bits to spare.
    let mut spare = BASE64_STANDARD.encode(&longer);
    assert!(spare.ends_with("AA=="));
    spare.replace_range(spare.len() - 3.., "B==");
    for uri in
        [broken, format!("{head},{spare}"), format!("{head},{}", spare.trim_end_matches('='))]
    {
        let mut document = plain.clone();
        document["buffers"][0]["uri"] = json!(uri);
        assert_eq!(*parse(&document).unwrap().objects[0].mesh, *expected, "{uri}");
    }
}

/// Where nothing is left to draw, the error says why.
#[test]
fn reasons_are_in_the_error() {
    let mut document = document(&[TRIANGLE]);
    document["meshes"][0]["primitives"][0]["mode"] = json!(0);
    assert_fails(
        parse(&document),
        &["no triangle", "mesh 0 primitive 0: points and lines are not drawn"],
    );
    let obj = fragloom::scene::obj::parse(b"v 0 0 0\np 1\n", "p.obj", &mut |_| None);
    assert_fails(obj, &["p.obj: f: there is no face", "line 2"]);
}
