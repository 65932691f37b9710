//! PCD, and that all formats and encodings of the same points give the same scene.

use fragloom::error::Result;
use fragloom::scene::{Disc, Model, pcd, ply};
use proptest::prelude::*;

use super::assert_fails;

const HEADER: &str = "# .PCD v.7 - Point Cloud Data file format\nVERSION .7\nFIELDS x y z radius\nSIZE 4 4 4 4\n\
    TYPE F F F F\nCOUNT 1 1 1 1\nWIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n";

const POINTS: &str = "0 0 0 1\n1 0.5 -2 3\n";

fn parse(text: &str) -> Result<Model> {
    pcd::parse(text.as_bytes(), "p.pcd")
}

fn discs(model: &Model) -> &[Disc] {
    assert_eq!(model.objects.len(), 1);
    &model.objects[0].mesh.discs
}

#[test]
fn text_with_fields_of_all_kinds() {
    let model = parse(&format!("{HEADER}{POINTS}")).unwrap();
    assert_eq!(discs(&model)[1].center, [1.0, 0.5, -2.0]);
    // A histogram is skipped, and an integer colour packed.
    let text = HEADER
        .replace("x y z radius", "y histogram x z rgba normal_x normal_y normal_z radius")
        .replace("SIZE 4 4 4 4", "SIZE 8 4 2 4 4 4 4 4 4")
        .replace("TYPE F F F F", "TYPE F F I F U F F F F")
        .replace("COUNT 1 1 1 1", "COUNT 1 3 1 1 1 1 1 1 1");
    let points = "2 7 7 7 -1 3 2164195328 0 0 1 5\n2 7 7 7 1 3 4278255360 0 0 1 5\n";
    let model = parse(&format!("{text}{points}")).unwrap();
    let first = discs(&model)[0];
    assert_eq!(first.center, [-1.0, 2.0, 3.0]);
    // 0x80FF0000 and 0xFF00FF00.
    let half = (128.0_f64 / 255.0) as f32;
    assert_eq!((first.color, first.alpha), ([1.0, 0.0, 0.0], half));
    assert_eq!((discs(&model)[1].color, discs(&model)[1].alpha), ([0.0, 1.0, 0.0], 1.0));
    assert_eq!(first.axes[0][2], 0.0);
}

/// The library writes a colour as the float that has its bits.
#[test]
fn a_colour_in_a_float() {
    let text = HEADER.replace("radius", "rgb");
    let color = f32::from_bits(0x00FF_3300);
    let model = parse(&format!("{text}0 0 0 {color:e}\n1 0 0 4.2108e+06\n")).unwrap();
    assert_eq!(discs(&model)[0].color, [1.0, 0.2, 0.0]);
    let [_, r, g, b] = 4.2108e6_f32.to_bits().to_be_bytes().map(|c| (f64::from(c) / 255.0) as f32);
    assert_eq!(discs(&model)[1].color, [r, g, b]);
}

#[test]
fn intensities_span_the_greys() {
    let text = HEADER.replace("radius", "intensity").replace("WIDTH 2", "WIDTH 4");
    let text = text.replace("POINTS 2\n", "");
    let model = parse(&format!("{text}0 0 0 -50\n1 0 0 150\n2 0 0 0\n3 0 0 nan\n")).unwrap();
    let greys: Vec<f32> = discs(&model).iter().map(|disc| disc.color[1]).collect();
    assert_eq!(greys, [0.0, 1.0, 0.25, 1.0]);
    let flat = parse(&format!("{text}0 0 0 7\n1 0 0 7\n2 0 0 7\n3 0 0 7\n")).unwrap();
    assert!(discs(&flat).iter().all(|disc| disc.color == [1.0; 3]));
}

#[test]
fn missing_points_of_an_organised_cloud_are_left_out() {
    let model = parse(&format!("{HEADER}nan nan nan 1\n1 0 0 2\n")).unwrap();
    assert_eq!(discs(&model).len(), 1);
    assert_eq!(model.warnings, ["p.pcd: 1 of 2 points have no finite position and are left out"]);
}

#[test]
fn wrong_headers_are_named() {
    for (from, to, message) in [
        ("x y z radius", "x y u radius", "FIELDS: z is missing"),
        ("SIZE 4 4 4 4", "SIZE 4 4 4", "SIZE: has 3 values for 4 FIELDS"),
        ("SIZE 4 4 4 4", "SIZE 4 4 4 3", "SIZE: a Float of 3 bytes, field \"radius\""),
        ("SIZE 4 4 4 4", "SIZE 4 4 4 -4", "SIZE: \"-4\" must be a whole number"),
        ("TYPE F F F F", "TYPE F F F X", "TYPE: \"X\" must be I, U or F"),
        ("TYPE F F F F", "TYPE F F", "TYPE: has 2 values"),
        ("COUNT 1 1 1 1", "COUNT 1 1", "COUNT: has 2 values"),
        ("COUNT 1 1 1 1", "COUNT 1 1 1 99999999999", "COUNT: a point of 400000000008 bytes"),
        ("WIDTH 2", "WIDTH 3", "POINTS: 2 are not WIDTH times HEIGHT, 3"),
        ("WIDTH 2", "WIDTH", "WIDTH: needs one number"),
        ("POINTS 2", "POINTS 1 1", "POINTS: needs one number"),
        ("WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2", "", "POINTS: is missing"),
        ("HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2", "HEIGHT 9999999", "do not fit"),
        ("HEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2", "HEIGHT 99999999999999", "more than"),
        ("DATA ascii", "DATA text", "DATA: must be ascii, binary or binary_compressed"),
        ("DATA ascii", "DATA binary", "POINTS: 2 need 32 bytes after the header, which has 19"),
        ("DATA ascii", "ascii", "header: \"ascii\" is not known"),
        ("\n0 0 0 1", "\n0 0 O 1", "point 0: \"O\" is not a number of its type"),
        ("\n0 0 0 1", "\n0 0 0 0", "point 0: radius: 0 must be finite and above 0"),
        ("1 0.5 -2 3\n", "           ", "point 1: is missing"),
    ] {
        let text = format!("{HEADER}{POINTS}");
        assert!(text.contains(from), "{from}");
        assert_fails(parse(&text.replacen(from, to, 1)), &["p.pcd: ", message]);
    }
    assert_fails(parse("VERSION .7\nFIELDS x"), &["p.pcd: DATA: is missing"]);
    let packed = HEADER.replace("ascii", "binary_compressed");
    for (tail, message) in [
        (&[][..], "POINTS: 2 need 8 bytes"),
        (&[9, 0, 0, 0, 32, 0, 0, 0], "POINTS: 2 need 17 bytes"),
        (&[0, 0, 0, 0, 31, 0, 0, 0], "DATA: holds 31 bytes, but 2 points are 32"),
        (&[1, 0, 0, 0, 32, 0, 0, 0, 0], "DATA: ends in the middle"),
    ] {
        let bytes = [packed.as_bytes(), tail].concat();
        assert_fails(pcd::parse(&bytes, "p.pcd"), &["p.pcd: ", message]);
    }
}

/// A point as all formats can store it.
#[derive(Clone, Debug)]
struct Point {
    floats: [f32; 7],
    color: [u8; 4],
}

fn point() -> impl Strategy<Value = Point> {
    let floats = (prop::array::uniform6(-4.0_f32..4.0), 0.01_f32..1.0);
    (floats, any::<[u8; 4]>()).prop_map(|((six, radius), color)| {
        let [x, y, z, nx, ny, nz] = six;
        Point { floats: [x, y, z, nx, ny, nz, radius], color }
    })
}

const FLOATS: [&str; 7] = ["x", "y", "z", "nx", "ny", "nz", "radius"];
const CHANNELS: [&str; 4] = ["red", "green", "blue", "alpha"];

fn ply_header(points: &[Point], format: &str) -> String {
    let floats = FLOATS.map(|name| format!("property float {name}\n")).concat();
    let channels = CHANNELS.map(|name| format!("property uchar {name}\n")).concat();
    let count = points.len();
    format!("ply\nformat {format} 1.0\nelement vertex {count}\n{floats}{channels}end_header\n")
}

fn ply_text(points: &[Point]) -> Vec<u8> {
    let line = |p: &Point| {
        let floats = p.floats.map(|v| v.to_string());
        format!("{} {}\n", floats.join(" "), p.color.map(|c| c.to_string()).join(" "))
    };
    let lines: String = points.iter().map(line).collect();
    (ply_header(points, "ascii") + &lines).into_bytes()
}

fn ply_bytes(points: &[Point], big: bool) -> Vec<u8> {
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = ply_header(points, format).into_bytes();
    for p in points {
        let floats = p.floats.map(|v| if big { v.to_be_bytes() } else { v.to_le_bytes() });
        bytes.extend(floats.as_flattened());
        bytes.extend(p.color);
    }
    bytes
}

fn packed([r, g, b, a]: [u8; 4]) -> u32 {
    u32::from_be_bytes([a, r, g, b])
}

fn pcd_header(points: &[Point], data: &str) -> String {
    let count = points.len();
    format!(
        "VERSION 0.7\nFIELDS x y z normal_x normal_y normal_z radius rgba\nSIZE 4 4 4 4 4 4 4 4\n\
         TYPE F F F F F F F U\nCOUNT 1 1 1 1 1 1 1 1\nWIDTH {count}\nHEIGHT 1\n\
         VIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {data}\n"
    )
}

fn pcd_text(points: &[Point]) -> Vec<u8> {
    let line =
        |p: &Point| format!("{} {}\n", p.floats.map(|v| v.to_string()).join(" "), packed(p.color));
    let lines: String = points.iter().map(line).collect();
    (pcd_header(points, "ascii") + &lines).into_bytes()
}

fn pcd_words(point: &Point) -> [u32; 8] {
    let [a, b, c, d, e, f, g] = point.floats.map(f32::to_bits);
    [a, b, c, d, e, f, g, packed(point.color)]
}

fn pcd_bytes(points: &[Point]) -> Vec<u8> {
    let words = points.iter().flat_map(pcd_words).flat_map(u32::to_le_bytes);
    pcd_header(points, "binary").into_bytes().into_iter().chain(words).collect()
}

/// Field after field, compressed as far as `pack` does it.
fn pcd_packed(points: &[Point]) -> Vec<u8> {
    let fields = (0..8).flat_map(|field| points.iter().map(move |p| pcd_words(p)[field]));
    let bytes: Vec<u8> = fields.flat_map(u32::to_le_bytes).collect();
    let packed = pack(&bytes);
    let lengths = [packed.len() as u32, bytes.len() as u32].map(u32::to_le_bytes);
    let header = pcd_header(points, "binary_compressed").into_bytes();
    [header, lengths.concat(), packed].concat()
}

/// LZF that repeats the longest of the last 300 starts, and else writes one byte as it is.
fn pack(bytes: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        let length = |back: usize| {
            let same = |&i: &usize| at + i < bytes.len() && bytes[at + i] == bytes[at + i - back];
            (0..264).take_while(same).count()
        };
        let best = (1..=at.min(300)).map(|back| (length(back), back)).max();
        match best.filter(|&(length, _)| length >= 3) {
            Some((length, back)) => {
                let (high, low) = (((back - 1) >> 8) as u8, ((back - 1) & 255) as u8);
                match length - 2 {
                    count @ 1..7 => packed.extend([(count as u8) << 5 | high, low]),
                    count => packed.extend([7 << 5 | high, (count - 7) as u8, low]),
                }
                at += length;
            }
            None => {
                packed.extend([0, bytes[at]]);
                at += 1;
            }
        }
    }
    packed
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn all_encodings_give_the_same_scene(points in prop::collection::vec(point(), 1..40)) {
        let expected = ply::parse(&ply_text(&points), "p").unwrap();
        for bytes in [ply_bytes(&points, false), ply_bytes(&points, true)] {
            let found = ply::parse(&bytes, "p").unwrap();
            prop_assert_eq!(discs(&found), discs(&expected));
        }
        for bytes in [pcd_text(&points), pcd_bytes(&points), pcd_packed(&points)] {
            let found = pcd::parse(&bytes, "p").unwrap();
            prop_assert_eq!(discs(&found), discs(&expected));
            prop_assert_eq!(&found.materials, &expected.materials);
        }
    }
}

/// As the library does: the version is not looked at, and lines about types may be missing.
#[test]
fn headers_of_all_versions() {
    let expected = discs(&parse(&format!("{HEADER}{POINTS}")).unwrap()).to_vec();
    for (old, new) in [
        ("VERSION .7\n", "VERSION .5\n"),
        ("VERSION .7\n", "VERSION 0.70\n"),
        ("VERSION .7\n", ""),
        ("SIZE 4 4 4 4\n    TYPE F F F F\nCOUNT 1 1 1 1\n", ""),
        ("COUNT 1 1 1 1\n", ""),
    ] {
        let text = format!("{HEADER}{POINTS}").replace("\n    ", "\n");
        let (old, new) = (old.replace("\n    ", "\n"), new);
        assert!(text.contains(&old), "{old}");
        assert_eq!(discs(&parse(&text.replace(&old, new)).unwrap()), expected, "{old}");
    }
}

#[test]
fn points_with_too_few_or_too_many_values_are_left_out() {
    for line in ["5 6 7\n", "5 6 7 8 9\n"] {
        let text = HEADER.replace("WIDTH 2", "WIDTH 3").replace("POINTS 2", "POINTS 3");
        let model = parse(&format!("{text}0 0 0 1\n{line}1 0.5 -2 3\n")).unwrap();
        assert_eq!(discs(&model).len(), 2, "{line}");
        assert_eq!(model.warnings.len(), 1, "{line}: {:?}", model.warnings);
    }
}
