//! Where a glTF file's bytes are: in the GLB's second chunk, in base64 data URIs, or in files beside it.

use std::borrow::Cow;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use serde_json::Value;

use super::super::model::Unplaced;
use super::json;
use crate::error::{Error, Result};

/// As browsers read it: exporters differ in whether they pad, and in what the last bits are.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new()
        .with_decode_padding_mode(DecodePaddingMode::Indifferent)
        .with_decode_allow_trailing_bits(true),
);

/// What to do with a file of the version before.
pub(super) const CONVERT: &str =
    "is glTF 1.0; convert it to glTF 2.0, for example by importing and exporting it in Blender";

type Chunks<'a> = (&'a [u8], Option<&'a [u8]>);

/// The JSON and, of a GLB file, the binary chunk. Other chunks are left out.
pub(super) fn split(bytes: &[u8]) -> Unplaced<Chunks<'_>> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes, None));
    }
    let word = |at: usize| {
        let word = bytes.get(at..at + 4)?.try_into().ok()?;
        Some(u32::from_le_bytes(word) as usize)
    };
    let header = word(4).zip(word(8)).filter(|(_, length)| *length >= 12);
    let (version, length) = header.ok_or("GLB header: length: must be at least 12")?;
    match version {
        1 => return Err(format!("GLB header: version 1 {CONVERT}")),
        2 => {}
        _ => return Err(format!("GLB header: version: {version} must be 2")),
    }
    if length > bytes.len() {
        let have = bytes.len();
        return Err(format!("GLB header: length: is {length}, but the file has {have} bytes"));
    }
    let (mut json, mut bin, mut at) = (None, None, 12);
    while let Some((size, kind)) = word(at).zip(bytes.get(at + 4..at + 8)) {
        let Some(data) = bytes.get(at + 8..).and_then(|left| left.get(..size)) else {
            return Err(format!("GLB chunk at byte {at}: its {size} bytes are not in the file"));
        };
        match kind {
            b"JSON" if json.is_none() => json = Some(data),
            b"BIN\0" if bin.is_none() => bin = Some(data),
            _ => {}
        }
        at += 8 + size;
    }
    Ok((json.ok_or("GLB: there is no JSON chunk")?, bin))
}

/// The bytes of every buffer, each at least as long as it says, or what is wrong with it, which matters only where it
/// is used.
pub(super) fn load<'a>(
    root: &Value,
    mut bin: Option<&'a [u8]>,
    place: &str,
    read: &mut dyn FnMut(&str) -> Result<Vec<u8>>,
) -> Unplaced<Vec<Result<Cow<'a, [u8]>>>> {
    let mut buffers = Vec::new();
    for (i, buffer) in json::list(root, "buffers")?.iter().enumerate() {
        let wrong = |problem: String| Error::new(place, format!("buffer {i}: {problem}"));
        let uri = json::text(buffer, "uri");
        let mut bytes = || match uri {
            Some(uri) => match source(uri).map_err(&wrong)? {
                Source::Inside(bytes) => Ok(Cow::from(bytes)),
                Source::File(name) => Ok(Cow::from(read(&name)?)),
            },
            None => bin
                .take()
                .map(Cow::from)
                .ok_or_else(|| wrong("uri: is missing, and there is no GLB chunk".to_owned())),
        };
        buffers.push(bytes().and_then(|bytes| {
            let need = json::index(buffer, "byteLength").map_err(&wrong)?.unwrap_or_default();
            let have = bytes.len();
            if have >= need {
                return Ok(bytes);
            }
            Err(wrong(format!("byteLength: is {need}, but there are only {have} bytes")))
        }));
    }
    Ok(buffers)
}

/// Where a URI's bytes are.
pub(super) enum Source {
    /// In the URI.
    Inside(Vec<u8>),
    /// In the file of this relative path.
    File(String),
}

/// Takes a URI apart.
pub(super) fn source(uri: &str) -> Unplaced<Source> {
    if uri.starts_with("data:") {
        return decode(uri).map(Source::Inside);
    }
    if uri.contains("://") {
        return Err("uri: must be a relative path or a data: URI".to_owned());
    }
    percent_decoded(uri).map(Source::File)
}

fn decode(uri: &str) -> Unplaced<Vec<u8>> {
    let (_, payload) = uri.split_once(";base64,").ok_or("uri: a data: URI must be base64")?;
    let payload: Cow<'_, str> = match payload.contains(|c: char| c.is_ascii_whitespace()) {
        true => payload.split_ascii_whitespace().collect::<String>().into(),
        false => payload.into(),
    };
    BASE64.decode(payload.as_bytes()).map_err(|error| format!("uri: base64: {error}"))
}

/// `%20` and the like in paths.
fn percent_decoded(uri: &str) -> Unplaced<String> {
    let mut parts = uri.split('%');
    let mut bytes = parts.next().unwrap_or_default().as_bytes().to_vec();
    for part in parts {
        let digits = part.get(..2).and_then(|digits| u8::from_str_radix(digits, 16).ok());
        bytes.push(digits.ok_or("uri: % needs two hexadecimal digits")?);
        bytes.extend_from_slice(&part.as_bytes()[2..]);
    }
    String::from_utf8(bytes).map_err(|_| "uri: is not UTF-8".to_owned())
}
