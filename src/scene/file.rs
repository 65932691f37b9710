//! Scene files: TOML with a camera, a light, materials, objects, volumes and `screen` triangles. An unknown key is an error.
//! [`parse`] looks only at the text; [`Description::build`] then asks its caller for the models.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Deserialize;

use super::camera::AMBIENT;
use super::draft::{DEFAULT_BACKGROUND, Draft, Overrides, View, image_size};
use super::model::{MAX_TRIANGLES, Unplaced};
use super::parts::{plain, without_mark};
use super::placement::Placement;
use super::volume::VolumeTable;
use super::{
    Light, Material, Model, PointSize, Scene, ScreenTriangle, Shading, Thickness, check, names,
    procedural,
};
use crate::error::{Error, Result};

/// A scene file whose text is valid.
#[derive(Clone, Debug)]
pub struct Description {
    place: String,
    table: Document,
}

/// Where an object's model comes from.
#[derive(Clone, Copy, Debug)]
pub enum Source<'a> {
    /// A mesh file, relative to the scene file.
    File(&'a str),
    /// A point set, relative to the scene file, with radii.
    Points {
        /// The file.
        file: &'a str,
        /// The radii.
        size: PointSize,
    },
    /// A generator.
    Procedural {
        /// Its name.
        name: &'a str,
        /// Its settings.
        keys: &'a BTreeMap<String, toml::Value>,
        /// The image's width and height in pixels.
        size: [u32; 2],
    },
}

/// The keys of a file with points.
const POINT_KEYS: [&str; 2] = ["radius", "radius_scale"];

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    size: Option<[u32; 2]>,
    background: Option<[f32; 3]>,
    camera: Option<View>,
    light: Option<LightTable>,
    #[serde(default)]
    material: Vec<MaterialTable>,
    #[serde(default)]
    object: Vec<ObjectTable>,
    #[serde(default)]
    volume: Vec<VolumeTable>,
    #[serde(default)]
    screen: Vec<ScreenTable>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LightTable {
    towards: Option<[f64; 3]>,
    ambient: Option<f32>,
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MaterialTable {
    name: String,
    color: [f32; 3],
    alpha: Option<f32>,
    #[serde(default)]
    shading: Shading,
}

#[derive(Clone, Debug, Deserialize)]
struct ObjectTable {
    name: Option<String>,
    file: Option<String>,
    procedural: Option<String>,
    material: Option<String>,
    translate: Option<[f64; 3]>,
    rotate: Option<[f64; 4]>,
    scale: Option<f64>,
    thickness: Option<ThicknessValue>,
    /// The generator's own; a file has only [`POINT_KEYS`].
    #[serde(flatten)]
    keys: BTreeMap<String, toml::Value>,
}

/// World units, or text like "10x".
#[derive(Clone, Debug, Deserialize)]
#[serde(untagged)]
enum ThicknessValue {
    Number(f64),
    Text(String),
}

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ScreenTable {
    points: [[f64; 3]; 3],
    color: [f32; 4],
}

/// Reads a scene file. `place` names it in messages.
///
/// # Errors
/// Names the line where TOML knows it, else the table and the field.
pub fn parse(bytes: &[u8], place: &str) -> Result<Description> {
    let wrong = |problem: String| Error::new(place, problem);
    let bytes = without_mark(bytes);
    let text = std::str::from_utf8(bytes)
        .map_err(|error| wrong(format!("byte {}: is not UTF-8 text", error.valid_up_to())))?;
    let table: Document = toml::from_str(text).map_err(|error| {
        wrong(plain(error.message(), text, error.span().map_or(0, |span| span.start)))
    })?;
    let description = Description { place: place.to_owned(), table };
    description.check()?;
    Ok(description)
}

impl Description {
    /// The scene, with the models that `model` gives for its objects, and the files of its volumes that `read` gives.
    ///
    /// # Errors
    /// The errors of both, and everything that makes a scene wrong as a whole.
    pub fn build(
        &self,
        overrides: &Overrides,
        model: &mut dyn FnMut(Source<'_>) -> Result<Model>,
        read: &mut dyn FnMut(&str) -> Result<Vec<u8>>,
    ) -> Result<Scene> {
        let size = image_size(&self.place, self.table.size, overrides)?;
        let mut whole = Model::default();
        whole.materials.extend(self.table.material.iter().map(MaterialTable::material));
        for (i, object) in self.table.object.iter().enumerate() {
            let transform = object
                .placement()
                .transform()
                .map_err(|problem| self.wrong("object", i, &problem))?;
            let material = object.material.as_deref().and_then(|name| self.material(name));
            let found = model(object.source(size))?;
            if object.points().is_some() && found.objects.iter().any(|o| o.mesh.discs.is_empty()) {
                let problem = "radius, radius_scale: are keys of point sets, and the file is none";
                return Err(self.wrong("object", i, problem));
            }
            let first = whole.objects.len();
            whole.append(found, transform, material);
            if let Some(thickness) = &object.thickness {
                let own = thickness.read().map_err(|problem| self.wrong("object", i, &problem))?;
                whole.objects[first..].iter_mut().for_each(|o| o.thickness = Some(own));
            }
            whole.call(&object.name(i));
            if whole.triangles() > MAX_TRIANGLES {
                return Err(self.wrong(
                    "object",
                    i,
                    &format!("more than {MAX_TRIANGLES} triangles"),
                ));
            }
        }
        for (i, volume) in self.table.volume.iter().enumerate() {
            let built = volume.build(read);
            let built = built.map_err(|error| self.wrong("volume", i, &error.to_string()))?;
            whole.volumes.push(built);
        }
        whole.screen.extend(self.table.screen.iter().map(ScreenTable::triangle));
        let view = self.table.camera.clone();
        let background = self.table.background.unwrap_or(DEFAULT_BACKGROUND);
        let mut draft =
            Draft { size: Some(size), background, view, ..Draft::new(self.place.clone(), whole) };
        draft.light = self.table.light.as_ref().map(|light| light.light(&draft));
        draft.finish(overrides)
    }

    fn wrong(&self, table: &str, index: usize, problem: &str) -> Error {
        Error::new(&self.place, format!("{table} {index}: {problem}"))
    }

    fn material(&self, name: &str) -> Option<usize> {
        self.table.material.iter().position(|material| material.name == name)
    }

    /// All checks that do not need the models.
    fn check(&self) -> Result<()> {
        let (place, table) = (self.place.as_str(), &self.table);
        check::size(place, table.size.unwrap_or([1, 1]))?;
        check::color(place, "background", table.background.unwrap_or_default())?;
        if let Some(problem) = table.camera.as_ref().and_then(View::problem) {
            return Err(Error::new(place, problem));
        }
        for (i, material) in table.material.iter().enumerate() {
            if self.material(&material.name) != Some(i) {
                return Err(self.wrong(
                    "material",
                    i,
                    &format!("name: {:?} is taken", material.name),
                ));
            }
        }
        for (i, object) in table.object.iter().enumerate() {
            object.check().map_err(|problem| self.wrong("object", i, &problem))?;
            let name = object.material.as_deref();
            if let Some(name) = name.filter(|name| self.material(name).is_none()) {
                return Err(self.wrong("object", i, &format!("material: there is no {name:?}")));
            }
        }
        let objects = table.object.iter().enumerate().map(|(i, object)| object.name(i));
        names::check(objects).map_err(|(i, problem)| self.wrong("object", i, &problem))?;
        for (i, volume) in table.volume.iter().enumerate() {
            volume.check().map_err(|problem| self.wrong("volume", i, &problem))?;
        }
        let mut screen = table.screen.iter().enumerate();
        screen.try_for_each(|(i, triangle)| check::screen(place, i, &triangle.triangle()))
    }
}

impl LightTable {
    fn light(&self, draft: &Draft) -> Light {
        let camera = || {
            View::camera(draft.view.as_ref(), draft.model.bounds(), draft.size.unwrap_or([1, 1]))
        };
        let towards = self.towards.map(|towards| DVec3::from(towards).normalize_or_zero());
        Light {
            towards: towards.unwrap_or_else(|| camera().default_light().towards),
            ambient: self.ambient.unwrap_or(AMBIENT),
        }
    }
}

impl MaterialTable {
    fn material(&self) -> Material {
        let alpha = self.alpha.unwrap_or(1.0);
        Material { shading: self.shading, ..Material::new(&self.name, self.color, alpha) }
    }
}

impl ObjectTable {
    fn placement(&self) -> Placement {
        let Self { translate, rotate, scale, .. } = *self;
        Placement { translate, rotate, scale }
    }

    /// As written, or the letter of its place.
    fn name(&self, index: usize) -> String {
        self.name.clone().unwrap_or_else(|| names::letters(index))
    }

    /// What a file's object says of its points' radii, if anything.
    fn points(&self) -> Option<PointSize> {
        let [radius, scale] = POINT_KEYS.map(|key| self.number(key).unwrap_or_default());
        let given = self.file.is_some() && (radius.is_some() || scale.is_some());
        given.then_some(PointSize { radius, scale })
    }

    /// A number among the keys.
    fn number(&self, key: &str) -> Unplaced<Option<f32>> {
        match self.keys.get(key) {
            None => Ok(None),
            Some(toml::Value::Float(value)) => Ok(Some(*value as f32)),
            Some(toml::Value::Integer(value)) => Ok(Some(*value as f32)),
            Some(other) => Err(format!("{key}: {other} must be a number")),
        }
    }

    /// The file or generator; [`ObjectTable::check`] has seen that there is one.
    fn source(&self, size: [u32; 2]) -> Source<'_> {
        match (&self.file, &self.procedural) {
            (Some(file), _) => match self.points() {
                Some(size) => Source::Points { file, size },
                None => Source::File(file),
            },
            (None, name) => Source::Procedural {
                name: name.as_deref().unwrap_or_default(),
                keys: &self.keys,
                size,
            },
        }
    }

    fn check(&self) -> Unplaced<()> {
        match (&self.file, &self.procedural) {
            (Some(_), None) => {
                if let Some(key) = self.keys.keys().find(|key| !POINT_KEYS.contains(&key.as_str()))
                {
                    return Err(format!("{key}: is not a key of an object with a file"));
                }
                for key in POINT_KEYS {
                    self.number(key)?;
                }
                let size = self.points().unwrap_or_default();
                size.check(POINT_KEYS).map_err(|(name, problem)| format!("{name}: {problem}"))?;
            }
            (None, Some(name)) => self.check_generator(name)?,
            _ => return Err("file: needs either file or procedural".to_owned()),
        }
        self.thickness.as_ref().map_or(Ok(()), |thickness| thickness.read().map(drop))?;
        self.placement().transform().map(drop)
    }

    fn check_generator(&self, name: &str) -> Unplaced<()> {
        let builtin = procedural::find(name).map_err(|error| format!("procedural: {error}"))?;
        if builtin.in_pixels && (self.placement().is_given() || self.material.is_some()) {
            return Err(format!(
                "procedural: {name} is drawn in pixels; it takes no translate, rotate, scale or material"
            ));
        }
        Ok(())
    }
}

impl ThicknessValue {
    fn read(&self) -> Unplaced<Thickness> {
        let text = match self {
            Self::Number(units) => units.to_string(),
            Self::Text(text) => text.clone(),
        };
        Thickness::parse(&text).map_err(|problem| format!("thickness: {problem}"))
    }
}

impl ScreenTable {
    fn triangle(&self) -> ScreenTriangle {
        ScreenTriangle { points: self.points, color: self.color }
    }
}
