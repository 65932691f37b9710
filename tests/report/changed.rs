//! Pages whose data was changed on purpose.

use std::io::{Read, Write};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;

/// Streams before those of the first method.
const HEAD: usize = 5;

/// Replace the streams of the block that holds a pixel.
fn with_block(
    text: &str,
    [x, y]: [u32; 2],
    [width, _]: [u32; 2],
    change: impl FnOnce(&mut Vec<Vec<u8>>, usize),
) -> String {
    let number = y / 64 * width.div_ceil(64) + x / 64;
    let mark = format!("id=\"b{number}\">");
    let from = text.find(&mark).expect("a block") + mark.len();
    let to = from + text[from..].find('<').expect("an end");
    let packed = STANDARD.decode(&text[from..to]).expect("base64");
    let mut bytes = Vec::new();
    ZlibDecoder::new(&packed[..]).read_to_end(&mut bytes).expect("zlib");
    let word = |i: usize| {
        u32::from_le_bytes(bytes[4 * i..4 * i + 4].try_into().expect("four bytes")) as usize
    };
    let mut at = 4 + 4 * word(0);
    let mut streams = Vec::new();
    for i in 0..word(0) {
        streams.push(bytes[at..at + word(i + 1)].to_vec());
        at += word(i + 1);
    }
    let across = (width - x / 64 * 64).min(64);
    change(&mut streams, (y % 64 * across + x % 64) as usize);
    let mut bytes = (streams.len() as u32).to_le_bytes().to_vec();
    streams.iter().for_each(|stream| bytes.extend((stream.len() as u32).to_le_bytes()));
    streams.iter().for_each(|stream| bytes.extend(stream));
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(&bytes).expect("packed");
    let packed = STANDARD.encode(encoder.finish().expect("packed"));
    format!("{}{packed}{}", &text[..from], &text[to..])
}

/// A pixel's first fragment has another fate with the first method. Counts and fates are below 128, and so are bytes.
pub(crate) fn fate(text: &str, pixel: [u32; 2], size: [u32; 2]) -> String {
    with_block(text, pixel, size, |streams, p| {
        let fragment: usize = streams[0][..p].iter().map(|&count| usize::from(count)).sum();
        let fates = &mut streams[HEAD + 1];
        let own = fates[fragment];
        fates[fragment] = *fates.iter().find(|&&other| other != own).expect("another fate");
    })
}

/// A pixel has one fragment less, and the next one more.
pub(crate) fn without_fragment(text: &str, pixel: [u32; 2], size: [u32; 2]) -> String {
    with_block(text, pixel, size, |streams, p| {
        streams[0][p] -= 1;
        streams[0][p + 1] += 1;
    })
}

/// The first method's picture differs by one at a pixel.
pub(crate) fn color(text: &str, pixel: [u32; 2], size: [u32; 2]) -> String {
    with_block(text, pixel, size, |streams, p| streams[HEAD + 3][p] ^= 1)
}

/// The table's first two rows have changed places.
pub(crate) fn rows_swapped(text: &str) -> String {
    let from = text.find("\"rows\":[").expect("rows") + "\"rows\":[".len();
    let end = |at: usize| at + text[at..].find("},{\"cells\"").expect("another row") + 1;
    let (first, second) = (end(from), end(end(from) + 1));
    let (one, two) = (&text[from..first], &text[first + 1..second]);
    format!("{}{two},{one}{}", &text[..from], &text[second..])
}
