//! Pictures as files, in the format that the name's ending says.

use std::path::Path;

use crate::error::{Error, Result};
use crate::image::{Image, png};

/// A format of picture files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `.png`: 8 bits a channel, with opacity, sRGB.
    Png,
    /// `.ppm`: 8 bits a channel, binary (P6), without opacity.
    Ppm,
}

impl Format {
    /// By the ending of a file's name. What is no file, like `/dev/null`, and stdout (`-`) get PNG.
    ///
    /// # Errors
    /// `option`, and the endings that there are.
    pub fn of(option: &str, path: &Path) -> Result<Self> {
        let special = path == Path::new("-") || (path.exists() && !path.is_file());
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("ppm") => Ok(Self::Ppm),
            _ if special => Ok(Self::Png),
            _ => {
                let problem = format!("{} must end in .png or .ppm", path.display());
                Err(Error::new(option, problem))
            }
        }
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// A picture without pixels; `path` is named.
    pub fn encode(self, image: &Image, path: &Path) -> Result<Vec<u8>> {
        match self {
            Self::Png => png::encode(image)
                .map_err(|error| Error::new(path.display().to_string(), error.to_string())),
            Self::Ppm => {
                let mut bytes = format!("P6\n{} {}\n255\n", image.width, image.height).into_bytes();
                bytes.extend(image.pixels.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]));
                Ok(bytes)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn endings_are_formats() {
        let of = |name: &str| Format::of("-o", Path::new(name));
        assert_eq!(
            [of("a.png"), of("b.PPM"), of("-")],
            [Ok(Format::Png), Ok(Format::Ppm), Ok(Format::Png)]
        );
        for name in ["a.jpg", "png", "a.exr", ".png"] {
            assert!(of(name).unwrap_err().problem().contains(".png or .ppm"), "{name}");
        }
    }

    #[test]
    fn a_ppm_is_its_header_and_its_bytes() {
        let image = Image { width: 2, height: 1, pixels: vec![[1, 2, 3, 9], [4, 5, 6, 255]] };
        let bytes = Format::Ppm.encode(&image, Path::new("a.ppm")).unwrap();
        assert_eq!(bytes, b"P6\n2 1\n255\n\x01\x02\x03\x04\x05\x06");
    }
}
