//! Where a glTF file's bytes are: in the GLB's second chunk, in base64 data URIs, or in files beside it.

use std::borrow::Cow;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::binary::Glb;
use gltf::json::Root;

use super::super::model::Unplaced;
use crate::error::{Error, Result};

/// Exporters differ in whether they pad.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

type Chunks<'a> = (Cow<'a, [u8]>, Option<Cow<'a, [u8]>>);

/// The JSON and, of a GLB file, the binary chunk.
pub(super) fn split<'a>(bytes: &'a [u8], place: &str) -> Result<Chunks<'a>> {
    if !bytes.starts_with(b"glTF") {
        return Ok((bytes.into(), None));
    }
    // The crate subtracts the header from the file's own length without checking.
    let length = bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    if length.is_none_or(|length| length < 12) {
        return Err(Error::new(place, "GLB header: length: must be at least 12"));
    }
    let glb = Glb::from_slice(bytes).map_err(|error| Error::new(place, format!("GLB: {error}")))?;
    Ok((glb.json, glb.bin))
}

/// The bytes of every buffer, each at least as long as it says.
pub(super) fn load<'a>(
    root: &Root,
    mut bin: Option<Cow<'a, [u8]>>,
    place: &str,
    read: &mut dyn FnMut(&str) -> Result<Vec<u8>>,
) -> Result<Vec<Cow<'a, [u8]>>> {
    let mut buffers = Vec::new();
    for (i, buffer) in root.buffers.iter().enumerate() {
        let wrong = |problem: String| Error::new(place, format!("buffer {i}: {problem}"));
        let bytes = match &buffer.uri {
            Some(uri) if uri.starts_with("data:") => Cow::from(decode(uri).map_err(&wrong)?),
            Some(uri) if uri.contains("://") => {
                return Err(wrong("uri: must be a relative path or a data: URI".to_owned()));
            }
            Some(uri) => Cow::from(read(&percent_decoded(uri).map_err(&wrong)?)?),
            None => bin
                .take()
                .ok_or_else(|| wrong("uri: is missing, and there is no GLB chunk".into()))?,
        };
        let (have, need) = (bytes.len() as u64, buffer.byte_length.0);
        if have < need {
            return Err(wrong(format!("byteLength: is {need}, but there are only {have} bytes")));
        }
        buffers.push(bytes);
    }
    Ok(buffers)
}

fn decode(uri: &str) -> Unplaced<Vec<u8>> {
    let (_, payload) = uri.split_once(";base64,").ok_or("uri: a data: URI must be base64")?;
    BASE64.decode(payload).map_err(|error| format!("uri: base64: {error}"))
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
