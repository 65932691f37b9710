//! Pictures as files, in the format that the name's ending says.

use std::path::Path;

use crate::error::{Error, Result};
use crate::image::linear::{Linear, exr, pfm};
use crate::image::{Image, png};

/// A format of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.png`: 8 bits a channel, with opacity, sRGB.
    Png,
    /// `.png` with 16 bits a channel.
    Png16,
    /// `.ppm`: 8 bits a channel, binary (P6), without opacity.
    Ppm,
    /// `.pfm`: 32-bit floating point, linear, without opacity.
    Pfm,
    /// `.exr`: 32-bit floating point, linear, with opacity.
    Exr,
}

/// A picture as it was drawn.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    /// In sRGB, 8 bits a channel.
    pub image: &'a Image,
    /// In linear light, where it was asked for.
    pub linear: Option<&'a Linear>,
}

impl Format {
    /// By the ending of a file's name. What is no file, like `/dev/null`, and stdout (`-`) get PNG. `bits` a channel,
    /// 8 or 16, can be chosen for PNG alone.
    ///
    /// # Errors
    /// `option` and the endings that there are, or `--bits` and what it can be.
    pub fn of(option: &str, path: &Path, bits: Option<u32>) -> Result<Self> {
        let special = path == Path::new("-") || (path.exists() && !path.is_file());
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        let format = match ending.as_deref() {
            Some("png") => Self::Png,
            Some("ppm") => Self::Ppm,
            Some("pfm") => Self::Pfm,
            Some("exr") => Self::Exr,
            _ if special => Self::Png,
            _ => {
                let problem = format!("{} must end in .png, .ppm, .pfm or .exr", path.display());
                return Err(Error::new(option, problem));
            }
        };
        match (format, bits) {
            (_, None) | (Self::Png, Some(8)) => Ok(format),
            (Self::Png, Some(16)) => Ok(Self::Png16),
            (Self::Png, Some(bits)) => {
                Err(Error::new("--bits", format!("{bits} a channel must be 8 or 16")))
            }
            _ => {
                let problem = format!("is for .png alone, and not for {}", path.display());
                Err(Error::new("--bits", problem))
            }
        }
    }

    /// Whether it is written from linear light.
    #[must_use]
    pub fn is_linear(self) -> bool {
        matches!(self, Self::Png16 | Self::Pfm | Self::Exr)
    }

    /// Whether it holds opacity.
    #[must_use]
    pub fn has_opacity(self) -> bool {
        !matches!(self, Self::Ppm | Self::Pfm)
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// A picture without pixels, or without linear light where the format needs it; `path` is named.
    pub fn encode(self, drawn: Drawn<'_>, path: &Path) -> Result<Vec<u8>> {
        let wrong = |problem: String| Error::new(path.display().to_string(), problem);
        let linear = || drawn.linear.ok_or_else(|| wrong("needs linear light".to_owned()));
        match self {
            Self::Png => png::encode(drawn.image).map_err(|error| wrong(error.to_string())),
            Self::Png16 => png::encode16(linear()?).map_err(|error| wrong(error.to_string())),
            Self::Exr => exr::encode(linear()?).map_err(|error| wrong(error.to_string())),
            Self::Pfm => Ok(pfm::encode(linear()?)),
            Self::Ppm => {
                let Image { width, height, pixels } = drawn.image;
                let mut bytes = format!("P6\n{width} {height}\n255\n").into_bytes();
                bytes.extend(pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]));
                Ok(bytes)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, bits: Option<u32>) -> Result<Format> {
        Format::of("-o", Path::new(name), bits)
    }

    #[test]
    fn endings_are_formats() {
        for (name, expected) in [
            ("a.png", Format::Png),
            ("b.PPM", Format::Ppm),
            ("c.pfm", Format::Pfm),
            ("d.Exr", Format::Exr),
            ("-", Format::Png),
        ] {
            assert_eq!(of(name, None), Ok(expected));
        }
        for name in ["a.jpg", "png", "a.hdr", ".png"] {
            let error = of(name, None).unwrap_err();
            assert_eq!(error.place(), "-o");
            assert!(error.problem().contains(".png, .ppm, .pfm or .exr"), "{name}");
        }
    }

    #[test]
    fn bits_are_for_png() {
        assert_eq!([of("a.png", Some(8)), of("-", Some(8))], [Ok(Format::Png), Ok(Format::Png)]);
        assert_eq!([of("a.png", Some(16)), of("-", Some(16))], [const { Ok(Format::Png16) }; 2]);
        for (name, bits) in [("a.png", 10), ("-", 0), ("a.ppm", 16), ("a.exr", 8), ("a.pfm", 16)] {
            assert_eq!(of(name, Some(bits)).unwrap_err().place(), "--bits", "{name} {bits}");
        }
    }

    #[test]
    fn each_format_is_written_from_what_it_needs() {
        let pixels = vec![[1, 2, 3, 9], [4, 5, 6, 255]];
        let image = Image { width: 2, height: 1, pixels };
        let linear = Linear { width: 2, height: 1, pixels: vec![[1, 2, 3, 9], [4, 5, 6, 65_535]] };
        let (whole, without) =
            (Drawn { image: &image, linear: Some(&linear) }, Drawn { image: &image, linear: None });
        let path = Path::new("a");
        for (format, start) in [
            (Format::Png, &b"\x89PNG\r\n\x1A\n"[..]),
            (Format::Png16, b"\x89PNG\r\n\x1A\n"),
            (Format::Ppm, b"P6\n2 1\n255\n\x01\x02\x03\x04\x05\x06"),
            (Format::Pfm, b"PF\n2 1\n"),
            (Format::Exr, b"\x76\x2F\x31\x01"),
        ] {
            assert!(format.encode(whole, path).unwrap().starts_with(start), "{format:?}");
            assert_eq!(format.encode(without, path).is_err(), format.is_linear(), "{format:?}");
            let other = Image { pixels: vec![[1, 2, 3, 8], [4, 5, 6, 255]], ..image.clone() };
            let pixels = vec![[1, 2, 3, 8], [4, 5, 6, 65_535]];
            let light = Linear { pixels, ..linear.clone() };
            let other = Drawn { image: &other, linear: Some(&light) };
            let differs = format.encode(other, path) != format.encode(whole, path);
            assert_eq!(differs, format.has_opacity(), "{format:?}");
        }
    }
}
