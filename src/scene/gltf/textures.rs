//! The pictures of base colours: where their bytes are, how they are sampled, and how they lie on a mesh.

use std::sync::Arc;

use serde_json::Value;

use super::super::model::Unplaced;
use super::super::parts::Tally;
use super::super::texture::{MAX_TEXELS, Opacity, Picture, Texture, Wrap};
use super::accessor::Data;
use super::buffers::{Source, source};
use super::json;
use crate::error::Result;

/// How a picture lies on a mesh: by which of its coordinates, moved by `KHR_texture_transform`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lying {
    set: usize,
    offset: [f64; 2],
    /// The angle's sine and cosine.
    turn: [f64; 2],
    scale: [f64; 2],
}

/// A file's pictures, each decoded where it is first asked for.
pub(super) struct Pictures<'a> {
    data: &'a Data<'a>,
    read: &'a mut dyn FnMut(&str) -> Result<Vec<u8>>,
    known: Vec<(usize, Option<Arc<Picture>>)>,
    texels: usize,
}

impl<'a> Pictures<'a> {
    /// `read` gives the bytes of a file by its relative path.
    pub(super) fn new(
        data: &'a Data<'a>,
        read: &'a mut dyn FnMut(&str) -> Result<Vec<u8>>,
    ) -> Self {
        Self { data, read, known: Vec::new(), texels: 0 }
    }

    /// A material's texture and how it lies, by what its `baseColorTexture` says; `None` if it cannot be drawn, with
    /// the reason among the warnings.
    pub(super) fn texture(
        &mut self,
        info: &Value,
        opacity: Opacity,
        material: &str,
        tally: &mut Tally,
    ) -> Unplaced<Option<(Texture, Lying)>> {
        let root = self.data.root;
        let index = json::index(info, "index")?.ok_or("index: is missing")?;
        let textures = json::list(root, "textures")?;
        let missing = || format!("index: {index} is not among the {} textures", textures.len());
        let texture = textures.get(index).ok_or_else(missing)?;
        let Some(image) = json::index(texture, "source")? else {
            tally.add("has no picture that is PNG or JPEG, and is left out", || {
                format!("material {material:?}: texture {index}")
            });
            return Ok(None);
        };
        let Some(picture) = self.picture(image, tally)? else { return Ok(None) };
        let none = Value::Null;
        let sampler = match json::index(texture, "sampler")? {
            Some(index) => json::list(root, "samplers")?.get(index).unwrap_or(&none),
            None => &none,
        };
        let mut wrap = |key| {
            Ok::<_, String>(match json::index(sampler, key)? {
                None | Some(10_497) => Wrap::Repeat,
                Some(33_071) => Wrap::Clamp,
                Some(33_648) => Wrap::Mirror,
                Some(other) => {
                    tally.add("is none that glTF has, and is taken for 10497", || {
                        format!("material {material:?}: sampler: {key}: {other}")
                    });
                    Wrap::Repeat
                }
            })
        };
        let wrap = [wrap("wrapS")?, wrap("wrapT")?];
        let nearest = json::index(sampler, "magFilter")? == Some(9_728);
        Ok(Some((Texture { picture, wrap, nearest, opacity }, lying(info)?)))
    }

    fn picture(&mut self, index: usize, tally: &mut Tally) -> Unplaced<Option<Arc<Picture>>> {
        if let Some((_, picture)) = self.known.iter().find(|(known, _)| *known == index) {
            return Ok(picture.clone());
        }
        let images = json::list(self.data.root, "images")?;
        let missing = || format!("image {index} is not among the {}", images.len());
        let image = images.get(index).ok_or_else(missing)?;
        let picture = match self.image(image) {
            Ok(picture) => Some(Arc::new(picture)),
            Err(problem) => {
                let name = json::text(image, "uri").filter(|uri| uri.len() < 200);
                let name = name.map_or_else(String::new, |uri| format!(" {uri:?}"));
                tally.add("the picture is left out", || format!("image {index}{name}: {problem}"));
                None
            }
        };
        self.known.push((index, picture.clone()));
        Ok(picture)
    }

    fn image(&mut self, image: &Value) -> Unplaced<Picture> {
        let own;
        let bytes = match json::index(image, "bufferView")? {
            Some(view) => self.data.view(view)?.0,
            None => {
                let uri = json::text(image, "uri").ok_or("has neither uri nor bufferView")?;
                own = match source(uri)? {
                    Source::Inside(bytes) => bytes,
                    Source::File(name) => (self.read)(&name).map_err(|e| e.problem().to_owned())?,
                };
                &own
            }
        };
        let picture = Picture::of_file(bytes)?;
        self.texels += picture.texels();
        if self.texels > MAX_TEXELS {
            return Err(format!("all pictures together have more than {MAX_TEXELS} texels"));
        }
        Ok(picture)
    }
}

/// The files that a document names as pictures, drawn or not.
pub(super) fn names(root: &Value) -> Vec<String> {
    let images = json::list(root, "images").unwrap_or_default();
    let file = |image: &Value| match source(json::text(image, "uri")?).ok()? {
        Source::File(name) => Some(name),
        Source::Inside(_) => None,
    };
    images.iter().filter_map(file).collect()
}

fn lying(info: &Value) -> Unplaced<Lying> {
    let own = json::index(info, "texCoord")?.unwrap_or_default();
    let none = Value::Null;
    let moved = json::deep(info, &["extensions", "KHR_texture_transform"]).unwrap_or(&none);
    let angle = json::number(moved, "rotation")?.unwrap_or_default();
    Ok(Lying {
        set: json::index(moved, "texCoord")?.unwrap_or(own),
        offset: json::numbers(moved, "offset")?.unwrap_or_default(),
        turn: [libm::sin(angle), libm::cos(angle)],
        scale: json::numbers(moved, "scale")?.unwrap_or([1.0; 2]),
    })
}

impl Lying {
    /// First scaled, then turned, then moved. The extension's text turns the other way than its examples and than all
    /// programs that draw it do; this is what they do.
    fn place(&self, [u, v]: [f64; 2]) -> [f32; 2] {
        let ([u, v], [sine, cosine]) = ([u * self.scale[0], v * self.scale[1]], self.turn);
        [
            (u * cosine + v * sine + self.offset[0]) as f32,
            (v * cosine - u * sine + self.offset[1]) as f32,
        ]
    }
}

impl Data<'_> {
    /// Where the vertices of a primitive lie in its material's picture; `None` if it does not say, with a warning.
    pub(super) fn places(
        &self,
        primitive: &Value,
        lying: Lying,
        count: usize,
        name: &str,
        tally: &mut Tally,
    ) -> Result<Option<Vec<[f32; 2]>>> {
        let key = format!("TEXCOORD_{}", lying.set);
        let user = format!("{name}: {key}");
        let attributes = json::get(primitive, "attributes").unwrap_or(&Value::Null);
        let index = json::index(attributes, &key).map_err(|problem| self.wrong(name, &problem))?;
        let Some(index) = index else {
            tally.add("is missing, and the texture is left out", || user);
            return Ok(None);
        };
        let found = self.sound(Some(self.numbers(index, &[2], &user)), count, &user, tally);
        let Some(found) = found else { return Ok(None) };
        let places: Vec<[f32; 2]> =
            found.values.as_chunks().0.iter().map(|&place| lying.place(place)).collect();
        if places.iter().all(|place| place.iter().all(|c| c.is_finite())) {
            return Ok(Some(places));
        }
        tally.add("the attribute is left out", || format!("{user}: not all numbers are finite"));
        Ok(None)
    }
}
