//! The pictures of materials: `map_Kd` with its options, and `map_d` where it is the same file, whose opacity then counts.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::super::parts::Tally;
use super::super::texture::{MAX_TEXELS, Opacity, Picture, Texture, Wrap};
use super::statement::clipped;

/// What a library says of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Map {
    /// As written, behind the options; it may have blanks.
    pub(super) name: String,
    clamp: bool,
    /// An option that changes how it lies is not followed.
    moved: bool,
}

impl Map {
    /// The rest of a line: options with their values, then the name.
    pub(super) fn parse(rest: &str) -> Self {
        let mut map = Self::default();
        let mut words = rest.split_whitespace().peekable();
        while let Some(option) = words.next_if(|word| word.starts_with('-')) {
            let most = match option {
                "-s" | "-o" | "-t" => 3,
                "-mm" => 2,
                _ => 1,
            };
            map.moved |= most == 3;
            let first = words.peek().copied();
            map.clamp |= option == "-clamp" && first == Some("on");
            // Numbers may be fewer; other values are one word.
            for i in 0..most {
                let is_number = |word: &&str| word.parse::<f64>().is_ok();
                if words.next_if(|word| (most == 1 && i == 0) || is_number(word)).is_none() {
                    break;
                }
            }
        }
        map.name = words.collect::<Vec<_>>().join(" ").trim_matches('"').replace('\\', "/");
        map
    }
}

/// Pictures by name, each decoded once.
pub(super) struct Pictures<'a> {
    read: &'a mut dyn FnMut(&str) -> Option<Vec<u8>>,
    /// By name, and whether their opacity counts.
    known: BTreeMap<(String, bool), Option<Arc<Picture>>>,
    texels: usize,
}

impl<'a> Pictures<'a> {
    /// `read` gives the bytes of a file.
    pub(super) fn new(read: &'a mut dyn FnMut(&str) -> Option<Vec<u8>>) -> Self {
        Self { read, known: BTreeMap::new(), texels: 0 }
    }

    /// A material's texture, if its picture can be had; the rest is among the warnings. `folder` is the library's.
    pub(super) fn texture(
        &mut self,
        material: &str,
        [color, opacity]: [Option<&Map>; 2],
        folder: &str,
        tally: &mut Tally,
    ) -> Option<Texture> {
        let same = color.map(|map| &map.name) == opacity.map(|map| &map.name);
        if let Some(map) = opacity.filter(|_| !same) {
            tally.add("opacity is only read from the picture of the colour", || {
                format!("material {material:?}: map_d {}", clipped(&map.name))
            });
        }
        let map = color?;
        if map.moved {
            tally.add("options that move a picture are not followed", || {
                format!("material {material:?}: map_Kd {}", clipped(&map.name))
            });
        }
        let picture = match self.picture(&map.name, same, folder) {
            Ok(picture) => picture,
            Err(problem) => {
                tally.add("the picture is left out", || {
                    format!("material {material:?}: map_Kd {}: {problem}", clipped(&map.name))
                });
                return None;
            }
        };
        let wrap = [if map.clamp { Wrap::Clamp } else { Wrap::Repeat }; 2];
        Some(Texture { picture, wrap, nearest: false, opacity: Opacity::Blend })
    }

    fn picture(&mut self, name: &str, counts: bool, folder: &str) -> Result<Arc<Picture>, String> {
        let beside = Path::new(folder).join(name).to_string_lossy().into_owned();
        for name in [&beside, name] {
            let key = (name.to_owned(), counts);
            match self.known.get(&key) {
                Some(Some(picture)) => return Ok(Arc::clone(picture)),
                Some(None) => continue,
                None => {}
            }
            let picture = match (self.read)(name) {
                Some(bytes) => Some(Picture::of_file(&bytes)?),
                None => None,
            };
            self.texels += picture.as_ref().map_or(0, Picture::texels);
            if self.texels > MAX_TEXELS {
                return Err(format!("all pictures together have more than {MAX_TEXELS} texels"));
            }
            let picture = picture.map(|own| Arc::new(if counts { own } else { own.opaque() }));
            self.known.insert(key, picture.clone());
            if let Some(picture) = picture {
                return Ok(picture);
            }
        }
        Err("not found".to_owned())
    }
}
