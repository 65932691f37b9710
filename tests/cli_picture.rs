//! `render -o`: the formats of pictures, and what they hold.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "support/command.rs"]
mod support;

use std::io::Cursor;

use support::Dir;

const SCENE: &str = "layers:count=3 --size 24x16";

/// The channels of a PNG picture, and how many bits each has.
fn png(bytes: &[u8]) -> (Vec<u16>, u32) {
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut data).unwrap();
    match reader.output_color_type() {
        (png::ColorType::Rgba, png::BitDepth::Eight) => {
            (data.iter().map(|&byte| byte.into()).collect(), 8)
        }
        (png::ColorType::Rgba, png::BitDepth::Sixteen) => {
            let word = |two: &[u8]| u16::from_be_bytes([two[0], two[1]]);
            (data.chunks_exact(2).map(word).collect(), 16)
        }
        other => panic!("{other:?}"),
    }
}

/// The numbers of a PFM picture, the top row first.
fn pfm(bytes: &[u8], head: &str, row: usize) -> Vec<f32> {
    let numbers = bytes.strip_prefix(head.as_bytes()).unwrap();
    let number = |four: &[u8]| f32::from_le_bytes([four[0], four[1], four[2], four[3]]);
    numbers.chunks_exact(4 * row).rev().flat_map(|row| row.chunks_exact(4).map(number)).collect()
}

/// The pixels of an OpenEXR picture.
fn exr(bytes: Vec<u8>) -> Vec<[f32; 4]> {
    use exr::prelude::{ReadChannels, ReadLayers, read};
    let layers = read().no_deep_data().largest_resolution_level().rgba_channels(
        |size, _| (size.width(), vec![[0.0_f32; 4]; size.area()]),
        |(width, pixels): &mut (usize, Vec<[f32; 4]>), at, (r, g, b, a): (f32, f32, f32, f32)| {
            pixels[at.y() * *width + at.x()] = [r, g, b, a];
        },
    );
    let image = layers.first_valid_layer().all_attributes().from_buffered(Cursor::new(bytes));
    image.unwrap().layer_data.channel_data.pixels.1
}

fn srgb(c: f32) -> f64 {
    let c = f64::from(c);
    if c <= 0.003_130_8 { c * 12.92 } else { 1.055 * libm::pow(c, 1.0 / 2.4) - 0.055 }
}

#[test]
fn all_formats_hold_the_same_picture() {
    let dir = Dir::new();
    let mut hashes = Vec::new();
    for output in ["a.png", "b.png --bits 16", "c.pfm", "d.exr", "e.ppm", "f.png --bits 8"] {
        let run = dir.run(&format!("render {SCENE} -m ab-ll --json -o {output}"));
        assert_eq!(run.code, 0, "{run:?}");
        hashes.push(run.json()["image_hash"].clone());
    }
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "it is over the 8-bit picture");
    assert_eq!(dir.read("a.png"), dir.read("f.png"));
    let ((bytes, 8), (words, 16)) = (png(&dir.read("a.png")), png(&dir.read("b.png"))) else {
        panic!("bits");
    };
    let light = pfm(&dir.read("c.pfm"), "PF\n24 16\n-1.0\n", 3 * 24);
    let pixels = exr(dir.read("d.exr"));
    assert_eq!([bytes.len(), words.len(), 4 * pixels.len()], [4 * 24 * 16; 3]);
    assert_eq!(light, pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect::<Vec<f32>>());
    for (channel, light) in pixels.as_flattened().iter().enumerate() {
        let encoded = if channel % 4 == 3 { f64::from(*light) } else { srgb(*light) };
        assert_eq!(words[channel], (encoded * 65_535.0).round() as u16, "{channel}");
        let rounded = (u32::from(words[channel]) + 128) / 257;
        assert!(rounded.abs_diff(bytes[channel].into()) <= 1, "{channel}");
    }
    let distinct: std::collections::BTreeSet<u16> = words.iter().copied().collect();
    assert!(distinct.iter().any(|word| word % 257 != 0), "more than bytes hold");
}

#[test]
fn stdout_and_frames_have_them_too() {
    let dir = Dir::new();
    let words = ["render", "cubes", "--size", "24", "--bits", "16", "-o", "-"];
    let output = dir.command().args(words).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    assert_eq!(png(&output.stdout).1, 16);
    let run = dir.run("render cubes --size 8 --frames 2 -o turn.pfm -q");
    assert_eq!((run.code, dir.names()), (0, vec!["turn-0000.pfm".into(), "turn-0001.pfm".into()]));
    assert_ne!(dir.read("turn-0000.pfm"), dir.read("turn-0001.pfm"));
}

/// Opaque red, green of opacity 128 / 255 over nothing, and nothing: what is there in closed form.
#[test]
fn a_transparent_picture_keeps_its_opacity() {
    let dir = Dir::new();
    let square = |x: f64, color: &str| {
        let corner = |x: f64, y: f64| format!("[{x:.1}, {y:.1}, 0.5]");
        let [a, b, c, d] =
            [corner(x, 0.0), corner(x + 2.0, 0.0), corner(x + 2.0, 2.0), corner(x, 2.0)];
        let triangle = |p: &str, q: &str, r: &str| {
            format!("[[screen]]\npoints = [{p}, {q}, {r}]\ncolor = {color}\n")
        };
        triangle(&a, &b, &c) + &triangle(&a, &c, &d)
    };
    let scene = "size = [6, 2]\nbackground = [0.2, 0.4, 0.6]\n".to_owned()
        + &square(0.0, "[1.0, 0.0, 0.0, 1.0]")
        + &square(2.0, "[0.0, 1.0, 0.0, 0.5]");
    std::fs::write(dir.path("s.toml"), scene).unwrap();
    let hash = |line: &str| {
        let run = dir.run(&format!("render s.toml -m ab-ll --json {line}"));
        assert_eq!(run.code, 0, "{run:?}");
        run.json()["image_hash"].clone()
    };
    let alone = hash("--transparent -o a.png");
    assert_eq!(
        [hash("--transparent -o b.png --bits 16"), hash("--transparent")],
        [(); 2].map(|()| alone.clone())
    );
    assert_eq!(hash("--transparent -o c.exr"), alone);
    assert_ne!(hash("-o whole.png"), alone);
    let row = |pixels: [[u16; 4]; 3]| pixels.map(|pixel| [pixel; 2]).concat().concat().repeat(2);
    let bytes = [[255, 0, 0, 255], [0, 255, 0, 128], [0; 4]];
    assert_eq!(png(&dir.read("a.png")), (row(bytes), 8));
    let words = [[65_535, 0, 0, 65_535], [0, 65_535, 0, 128 * 257], [0; 4]];
    assert_eq!(png(&dir.read("b.png")), (row(words), 16));
    let half = 128.0 / 255.0;
    let light = [[1.0, 0.0, 0.0, 1.0], [0.0, half, 0.0, half], [0.0; 4]];
    assert_eq!(exr(dir.read("c.exr")), light.map(|pixel| [pixel; 2]).concat().repeat(2));
    let whole = png(&dir.read("whole.png")).0;
    assert_eq!((whole[3], whole[11], whole[23]), (255, 255, 255), "the background is opaque");
    assert_ne!(whole[16..19], [0; 3]);
}

#[test]
fn what_does_not_fit_is_one_message() {
    let dir = Dir::new();
    std::fs::write(
        dir.path("smoke.toml"),
        "[[volume]]\nprocedural = \"cloud\"\n[[object]]\nprocedural = \"cubes\"\n",
    )
    .unwrap();
    for (line, words) in [
        ("cubes -o a.hdr", &["-o:", ".png, .ppm, .pfm or .exr"][..]),
        ("cubes -o a.png --bits 12", &["--bits:", "8 or 16"]),
        ("cubes -o a.exr --bits 16", &["--bits:", ".png", "a.exr"]),
        ("cubes -o a.ppm --bits 16", &["--bits:", ".png", "a.ppm"]),
        ("cubes --bits 16", &["--bits:", "-o"]),
        ("cubes -o a.ppm --transparent", &["--transparent:", "a.ppm", "opacity", ".png or .exr"]),
        ("cubes -o a.pfm --transparent", &["--transparent:", "a.pfm", "opacity"]),
        ("cubes --transparent --effect media", &["--transparent:", "--effect media"]),
        ("smoke.toml --transparent -o a.png", &["--transparent:", "volumes"]),
        ("cubes --transparent --reference exact", &["--reference:", "--transparent"]),
        ("cubes -o a.exr --effect media", &["-o:", "--effect media", ".ppm"]),
        ("cubes -o a.png --bits 16 --effect ao", &["-o:", "--effect ao", "--bits 8"]),
        ("smoke.toml -o a.pfm", &["-o:", "volumes", ".ppm"]),
    ] {
        dir.run(&format!("render {line} --size 8")).is_error(words);
    }
    assert_eq!(dir.names(), ["smoke.toml"]);
    let run = dir.run("render smoke.toml --size 8 -o a.png --bits 8 -q");
    assert_eq!(run.code, 0, "{run:?}");
}
