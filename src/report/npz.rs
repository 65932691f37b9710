//! NumPy's `.npz`: a zip archive of `.npy` arrays, here stored uncompressed with fixed times and permissions, so
//! that equal fragments give equal bytes. Members are streamed and may exceed 4 GiB.

use std::io::{self, Seek, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, System, ZipWriter};

use crate::effect::ldi::Voxels;
use crate::error::{Error, Result};
use crate::render::{Kept, Lists};
use crate::scheme::Record;

/// Bytes gathered before a write.
const CHUNK: usize = 1 << 16;

/// What is written for a frame's pixels.
#[derive(Clone, Copy, Debug)]
pub enum Written<'a> {
    /// [`write()`].
    Fragments(&'a Lists),
    /// [`write_records`].
    Records(&'a Lists<Record>),
}

impl<'a> Written<'a> {
    /// What can be written of `kept`.
    ///
    /// # Errors
    /// `kept` has no lists.
    pub fn of(kept: &'a Kept, method: &str) -> Result<Self> {
        match kept {
            Kept::Fragments(lists) => Ok(Self::Fragments(lists)),
            Kept::Records(lists) => Ok(Self::Records(lists)),
            Kept::Color(_) | Kept::Depths(_) | Kept::Gone(_) => {
                let problem = format!("needs lists, but {method} gives {}", kept.kind().name());
                Err(Error::new("--fragments", problem))
            }
        }
    }

    /// Write it.
    ///
    /// # Errors
    /// What `out` reports.
    pub fn write<W: Write + Seek>(self, out: W) -> io::Result<()> {
        match self {
            Self::Fragments(lists) => write(out, lists),
            Self::Records(lists) => write_records(out, lists),
        }
    }
}

/// Write `lists` as `offsets` (u64, pixels + 1), `depth` and `data` (u32, one per fragment), `width` and
/// `height` (u32 scalars), all little-endian.
///
/// # Errors
/// What `out` reports.
pub fn write<W: Write + Seek>(out: W, lists: &Lists) -> io::Result<()> {
    let mut archive = Archive { zip: ZipWriter::new(out) };
    archive.array("offsets", &lists.offsets, u64::to_le_bytes)?;
    archive.array("depth", &lists.entries, |key| ((key >> 32) as u32).to_le_bytes())?;
    archive.array("data", &lists.entries, |key| (key as u32).to_le_bytes())?;
    archive.scalar("width", lists.width)?;
    archive.scalar("height", lists.height)?;
    archive.zip.finish()?;
    Ok(())
}

/// Write merged records: as [`write()`], with the colour as RGBA8 in `data`; and in addition `thickness` (f64, world
/// units), `rgba` (f64, records x 4, premultiplied) and `weight` (f64, fragments).
///
/// # Errors
/// What `out` reports.
pub fn write_records<W: Write + Seek>(out: W, lists: &Lists<Record>) -> io::Result<()> {
    let mut archive = Archive { zip: ZipWriter::new(out) };
    let records = &lists.entries;
    archive.array("offsets", &lists.offsets, u64::to_le_bytes)?;
    archive.array("depth", records, |record| record.depth.to_le_bytes())?;
    archive.array("data", records, |record| record.color().to_le_bytes())?;
    archive.reals(
        "thickness",
        &format!("({},)", records.len()),
        records.iter().map(|r| r.thickness),
    )?;
    let colors = records.iter().flat_map(|record| record.rgba);
    archive.reals("rgba", &format!("({}, 4)", records.len()), colors)?;
    archive.reals("weight", &format!("({},)", records.len()), records.iter().map(|r| r.weight))?;
    archive.scalar("width", lists.width)?;
    archive.scalar("height", lists.height)?;
    archive.zip.finish()?;
    Ok(())
}

/// Write a layered depth image: `offsets`, `depth`, `width` and `height` as [`write()`] does, without data; and, if
/// they are given, `voxels` (bool, slices x height x width).
///
/// # Errors
/// What `out` reports.
pub fn write_ldi<W: Write + Seek>(
    out: W,
    lists: &Lists,
    voxels: Option<&Voxels>,
) -> io::Result<()> {
    let mut archive = Archive { zip: ZipWriter::new(out) };
    archive.array("offsets", &lists.offsets, u64::to_le_bytes)?;
    archive.array("depth", &lists.entries, |key| ((key >> 32) as u32).to_le_bytes())?;
    if let Some(Voxels { width, height, slices, inside }) = voxels {
        archive.start("voxels", inside.len() as u64)?;
        archive.zip.write_all(&header("|b1", &format!("({slices}, {height}, {width})")))?;
        archive.zip.write_all(inside)?;
    }
    archive.scalar("width", lists.width)?;
    archive.scalar("height", lists.height)?;
    archive.zip.finish()?;
    Ok(())
}

struct Archive<W: Write + Seek> {
    zip: ZipWriter<W>,
}

impl<W: Write + Seek> Archive<W> {
    fn array<T: Copy, const N: usize>(
        &mut self,
        name: &str,
        words: &[T],
        bytes: impl Fn(T) -> [u8; N],
    ) -> io::Result<()> {
        self.start(name, (words.len() as u64).saturating_mul(N as u64))?;
        self.zip.write_all(&header(&format!("<u{N}"), &format!("({},)", words.len())))?;
        let mut chunk = Vec::with_capacity(CHUNK);
        for some in words.chunks(CHUNK / N) {
            chunk.clear();
            chunk.extend(some.iter().flat_map(|&word| bytes(word)));
            self.zip.write_all(&chunk)?;
        }
        Ok(())
    }

    fn reals(
        &mut self,
        name: &str,
        shape: &str,
        values: impl Iterator<Item = f64>,
    ) -> io::Result<()> {
        let bytes: Vec<u8> = values.flat_map(f64::to_le_bytes).collect();
        self.start(name, bytes.len() as u64)?;
        self.zip.write_all(&header("<f8", shape))?;
        self.zip.write_all(&bytes)
    }

    fn scalar(&mut self, name: &str, value: u32) -> io::Result<()> {
        self.start(name, 4)?;
        self.zip.write_all(&header("<u4", "()"))?;
        self.zip.write_all(&value.to_le_bytes())
    }

    fn start(&mut self, name: &str, bytes: u64) -> io::Result<()> {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .last_modified_time(DateTime::DEFAULT)
            .unix_permissions(0o644)
            .system(System::Unix)
            .large_file(bytes >= u64::from(u32::MAX) - 1_024);
        Ok(self.zip.start_file(format!("{name}.npy"), options)?)
    }
}

/// The header of a `.npy` file, version 1.0, padded so that the data begins at a multiple of 64 bytes.
fn header(word: &str, shape: &str) -> Vec<u8> {
    let text = format!("{{'descr': '{word}', 'fortran_order': False, 'shape': {shape}, }}");
    let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    // Far below 2^16: a number has at most 20 digits.
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{text:<width$}\n", width = length - 1).into_bytes());
    bytes
}

#[cfg(test)]
mod tests {
    use std::io::{Cursor, Read};

    use super::*;

    fn lists() -> Lists {
        let entries = vec![0x0102_0304_0506_0708, 0x1112_1314_1516_1718, 0xFFFF_FFFE_0000_00FF];
        Lists { width: 2, height: 1, offsets: vec![0, 1, 3], entries }
    }

    fn archive(lists: &Lists) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        write(&mut bytes, lists).unwrap();
        bytes.into_inner()
    }

    fn npy(word: char, shape: &str, data: &[u8]) -> Vec<u8> {
        let text = format!("{{'descr': '<u{word}', 'fortran_order': False, 'shape': {shape}, }}");
        let mut bytes = vec![0x93, b'N', b'U', b'M', b'P', b'Y', 1, 0, 118, 0];
        bytes.extend(text.bytes());
        bytes.resize(127, b' ');
        bytes.push(b'\n');
        bytes.extend(data);
        bytes
    }

    #[test]
    fn members_are_the_arrays() {
        let mut zip = zip::ZipArchive::new(Cursor::new(archive(&lists()))).unwrap();
        let names: Vec<String> = zip.file_names().map(|name| name.unwrap().into_owned()).collect();
        assert_eq!(names, ["offsets.npy", "depth.npy", "data.npy", "width.npy", "height.npy"]);
        let offsets: Vec<u8> = [0u64, 1, 3].into_iter().flat_map(u64::to_le_bytes).collect();
        let depth = [4, 3, 2, 1, 0x14, 0x13, 0x12, 0x11, 0xFE, 0xFF, 0xFF, 0xFF];
        let data = [8, 7, 6, 5, 0x18, 0x17, 0x16, 0x15, 0xFF, 0, 0, 0];
        let expected = [
            npy('8', "(3,)", &offsets),
            npy('4', "(3,)", &depth),
            npy('4', "(3,)", &data),
            npy('4', "()", &[2, 0, 0, 0]),
            npy('4', "()", &[1, 0, 0, 0]),
        ];
        for (name, expected) in names.iter().zip(expected) {
            let mut bytes = Vec::new();
            zip.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
            assert_eq!(bytes, expected, "{name}");
        }
    }

    #[test]
    fn records_have_thickness_colour_and_weight_besides() {
        let record = Record { depth: 7, thickness: 0.5, rgba: [0.25, 0.0, 0.0, 0.5], weight: 2.0 };
        let lists = Lists { width: 1, height: 1, offsets: vec![0, 1], entries: vec![record] };
        let kept = Kept::Records(lists);
        let mut out = Cursor::new(Vec::new());
        Written::of(&kept, "m").unwrap().write(&mut out).unwrap();
        let mut zip = zip::ZipArchive::new(out).unwrap();
        let mut end = |name: &str, length: usize| {
            let mut bytes = Vec::new();
            zip.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
            bytes.split_off(bytes.len() - length)
        };
        assert_eq!(end("depth.npy", 4), [7, 0, 0, 0]);
        assert_eq!(end("data.npy", 4), [128, 0, 0, 128]);
        assert_eq!(end("thickness.npy", 8), 0.5f64.to_le_bytes());
        assert_eq!(end("rgba.npy", 32)[..8], 0.25f64.to_le_bytes());
        assert_eq!(end("weight.npy", 8), 2.0f64.to_le_bytes());
        let none = Written::of(&Kept::Color(Vec::new()), "m").unwrap_err();
        assert_eq!(none.place(), "--fragments");
    }

    #[test]
    fn a_layered_depth_image_has_depths_and_voxels() {
        let voxels = Voxels { width: 2, height: 1, slices: 2, inside: vec![0, 1, 1, 0] };
        let mut out = Cursor::new(Vec::new());
        write_ldi(&mut out, &lists(), Some(&voxels)).unwrap();
        let mut zip = zip::ZipArchive::new(out).unwrap();
        let names: Vec<String> = zip.file_names().map(|name| name.unwrap().into_owned()).collect();
        assert_eq!(names, ["offsets.npy", "depth.npy", "voxels.npy", "width.npy", "height.npy"]);
        let mut bytes = Vec::new();
        zip.by_name("voxels.npy").unwrap().read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes.len(), 128 + 4);
        assert!(
            bytes[10..]
                .starts_with(b"{'descr': '|b1', 'fortran_order': False, 'shape': (2, 1, 2), }")
        );
        assert_eq!(bytes[128..], [0, 1, 1, 0]);
    }

    #[test]
    fn bytes_do_not_depend_on_the_time_or_the_system() {
        let bytes = archive(&lists());
        assert_eq!(bytes, archive(&lists()));
        let expected = [
            b'P', b'K', 3, 4, 10, 0, 0, 0, // needs version 1.0, no flags
            0, 0, 0, 0, 33, 0, // stored; 1980-01-01 00:00:00
        ];
        assert_eq!(bytes[..14], expected);
        let central = bytes.windows(6).position(|w| w == b"PK\x01\x02\x0A\x03").unwrap();
        assert_eq!(bytes[central + 38..central + 42], [0, 0, 0xA4, 0x81], "-rw-r--r--");
    }

    #[test]
    fn no_fragments_are_empty_arrays() {
        let empty = Lists { width: 1, height: 1, offsets: vec![0, 0], entries: Vec::new() };
        let mut zip = zip::ZipArchive::new(Cursor::new(archive(&empty))).unwrap();
        let mut bytes = Vec::new();
        zip.by_name("depth.npy").unwrap().read_to_end(&mut bytes).unwrap();
        assert_eq!(bytes, npy('4', "(0,)", &[]));
    }
}
