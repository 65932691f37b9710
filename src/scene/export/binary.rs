//! The binary chunk, and the container with both chunks.

use serde_json::{Value, json};

use crate::error::{Error, Result};

/// What a view of the bytes is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    Vertices,
    Indices,
    Picture,
}

/// The bytes, in views.
#[derive(Default)]
pub(super) struct Binary {
    bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
}

impl Binary {
    /// Add bytes as a view; gives its number.
    pub(super) fn view(&mut self, bytes: &[u8], what: Use) -> usize {
        let mut view = json!({
            "buffer": 0,
            "byteOffset": self.bytes.len(),
            "byteLength": bytes.len(),
        });
        match what {
            Use::Vertices => view["target"] = 34_962.into(),
            Use::Indices => view["target"] = 34_963.into(),
            Use::Picture => {}
        }
        self.bytes.extend_from_slice(bytes);
        // Numbers begin at multiples of their size.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(view);
        self.views.len() - 1
    }

    /// The whole file.
    ///
    /// # Errors
    /// More than 4 GiB.
    pub(super) fn glb(self, mut root: Value) -> Result<Vec<u8>> {
        if !self.bytes.is_empty() {
            root["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        }
        let mut text = root.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let chunks = [(&b"JSON"[..], &text), (b"BIN\0", &self.bytes)];
        let chunks = chunks.iter().filter(|(_, bytes)| !bytes.is_empty());
        let length: usize = 12 + chunks.clone().map(|(_, bytes)| 8 + bytes.len()).sum::<usize>();
        let word = |number: usize| {
            let word = u32::try_from(number).map(u32::to_le_bytes);
            word.map_err(|_| {
                Error::new("export", format!("{number} bytes are more than a .glb file holds"))
            })
        };
        let mut file = Vec::with_capacity(length);
        file.extend_from_slice(b"glTF");
        file.extend(2u32.to_le_bytes());
        file.extend(word(length)?);
        for (kind, bytes) in chunks {
            file.extend(word(bytes.len())?);
            file.extend_from_slice(kind);
            file.extend_from_slice(bytes);
        }
        Ok(file)
    }
}
