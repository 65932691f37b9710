//! Reading accessors: numbers of any component type at any stride, with sparse replacements.

use std::borrow::Cow;

use serde_json::Value;

use super::json;
use crate::error::{Error, Result};
use crate::scene::model::Unplaced;

/// The most elements of an accessor without a buffer view, whose size nothing else limits.
const MAX_ZEROS: usize = 1 << 26;

/// A document with its buffers.
pub(super) struct Data<'a> {
    pub(super) root: &'a Value,
    pub(super) buffers: Vec<Result<Cow<'a, [u8]>>>,
    pub(super) place: &'a str,
}

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

/// How elements lie in a buffer view.
#[derive(Clone, Copy)]
struct Layout {
    component: Component,
    /// Components of an element.
    width: usize,
    offset: usize,
    count: usize,
}

/// The numbers of an accessor, element by element.
#[derive(Clone, Debug)]
pub(super) struct Numbers {
    /// Numbers of an element.
    pub(super) width: usize,
    pub(super) values: Vec<f64>,
}

impl Numbers {
    /// The first three of each element.
    pub(super) fn threes(&self) -> impl Iterator<Item = [f64; 3]> {
        self.values.chunks_exact(self.width).map(|v| [v[0], v[1], v[2]])
    }

    /// How many elements there are.
    pub(super) fn len(&self) -> usize {
        self.values.len() / self.width
    }
}

impl Data<'_> {
    /// The elements of an accessor whose type has one of `widths` components; f64 holds each of them exactly, and
    /// normalized ones are divided.
    pub(super) fn numbers(&self, index: usize, widths: &[usize], user: &str) -> Result<Numbers> {
        let wrong = |problem: String| self.wrong(&format!("{user}: accessor {index}"), &problem);
        let accessor = self.accessor(index).map_err(wrong)?;
        let width = width(accessor).filter(|width| widths.contains(width));
        let names = widths.iter().map(|&width| NAMES.get(width).copied().unwrap_or("MAT4"));
        let names: Vec<_> = names.collect();
        let width = width.ok_or_else(|| wrong(format!("type: must be {}", names.join(" or "))))?;
        let component = component(accessor).map_err(wrong)?;
        let mut values = self.values(accessor, component, width).map_err(wrong)?;
        let normalized = json::get(accessor, "normalized") == Some(&Value::Bool(true));
        if normalized && component != Component::F32 {
            let scale = component.largest();
            values.iter_mut().for_each(|value| *value = (*value / scale).max(-1.0));
        }
        Ok(Numbers { width, values })
    }

    /// Indices of any unsigned type.
    pub(super) fn indices(&self, index: usize, user: &str) -> Result<Vec<u32>> {
        let wrong = |problem: String| self.wrong(&format!("{user}: accessor {index}"), &problem);
        let accessor = self.accessor(index).map_err(wrong)?;
        if width(accessor) != Some(1) {
            return Err(wrong("type: must be SCALAR".to_owned()));
        }
        let component = component(accessor).map_err(wrong)?;
        if !matches!(component, Component::U8 | Component::U16 | Component::U32) {
            return Err(wrong("componentType: must be an unsigned integer".to_owned()));
        }
        let values = self.values(accessor, component, 1).map_err(wrong)?;
        Ok(values.into_iter().map(|value| value as u32).collect())
    }

    /// Whether an accessor has data of its own.
    pub(super) fn has_data(&self, index: usize) -> bool {
        let accessor = self.accessor(index).ok();
        let has = |key| accessor.is_some_and(|accessor| json::get(accessor, key).is_some());
        has("bufferView") || has("sparse")
    }

    pub(super) fn wrong(&self, name: &str, problem: &str) -> Error {
        Error::new(self.place, format!("{name}: {problem}"))
    }

    fn accessor(&self, index: usize) -> Unplaced<&Value> {
        let accessors = json::list(self.root, "accessors")?;
        let missing = || format!("is not among the {} accessors", accessors.len());
        accessors.get(index).ok_or_else(missing)
    }

    /// All components of all elements.
    fn values(&self, accessor: &Value, component: Component, width: usize) -> Unplaced<Vec<f64>> {
        let count = json::index(accessor, "count")?.unwrap_or_default();
        let offset = json::index(accessor, "byteOffset")?.unwrap_or_default();
        let mut values = match json::index(accessor, "bufferView")? {
            Some(view) => self.strided(view, Layout { component, width, offset, count })?,
            None if count <= MAX_ZEROS => vec![0.0; count * width],
            None => return Err(format!("count: must be at most {MAX_ZEROS}")),
        };
        if let Some(sparse) = json::get(accessor, "sparse") {
            self.replace(sparse, component, width, &mut values)
                .map_err(|problem| format!("sparse: {problem}"))?;
        }
        Ok(values)
    }

    fn replace(
        &self,
        sparse: &Value,
        component: Component,
        width: usize,
        values: &mut [f64],
    ) -> Unplaced<()> {
        let count = json::index(sparse, "count")?.unwrap_or_default();
        let part = |key: &str, component: Option<Component>, width: usize| {
            let wrong = |problem: String| format!("{key}: {problem}");
            let part = json::get(sparse, key).ok_or_else(|| wrong("is missing".to_owned()))?;
            let own = || self::component(part).map_err(wrong);
            let component = component.map_or_else(own, Ok)?;
            let offset = json::index(part, "byteOffset").map_err(wrong)?.unwrap_or_default();
            let view = json::index(part, "bufferView").map_err(wrong)?;
            let view = view.ok_or_else(|| wrong("bufferView: is missing".to_owned()))?;
            self.strided(view, Layout { component, width, offset, count }).map_err(wrong)
        };
        let (at, new) = (part("indices", None, 1)?, part("values", Some(component), width)?);
        for (index, new) in at.iter().zip(new.chunks_exact(width)) {
            let start = *index as usize * width;
            let old = values.get_mut(start..start + width);
            old.ok_or_else(|| format!("indices: {index} is out of range"))?.copy_from_slice(new);
        }
        Ok(())
    }

    /// The components that `layout` describes in a buffer view, after checking that they all are inside it.
    fn strided(&self, view: usize, layout: Layout) -> Unplaced<Vec<f64>> {
        let (bytes, stride) = self.view(view)?;
        let size = layout.component.size();
        let element = size * layout.width;
        let stride = stride.unwrap_or(element);
        if stride < element || stride > 252 {
            return Err(format!("byteStride: {stride} is not {element} to 252"));
        }
        let last = (layout.count as u128).saturating_sub(1) * stride as u128;
        let end = layout.offset as u128 + last + element as u128;
        if layout.count > 0 && end > bytes.len() as u128 {
            return Err(format!("needs {end} bytes, its buffer view has {}", bytes.len()));
        }
        let start = layout.offset.min(bytes.len());
        let elements = bytes[start..].chunks(stride).take(layout.count);
        let components = elements.flat_map(|e| e[..element].chunks_exact(size));
        Ok(components.map(|bytes| layout.component.number(bytes)).collect())
    }

    pub(super) fn view(&self, index: usize) -> Unplaced<(&[u8], Option<usize>)> {
        let views = json::list(self.root, "bufferViews")?;
        let missing = || format!("bufferView: {index} is not among the {}", views.len());
        let view = views.get(index).ok_or_else(missing)?;
        let field = |key| json::index(view, key).map_err(|p| format!("bufferView {index}: {p}"));
        let start = field("byteOffset")?.unwrap_or_default();
        let end = start.saturating_add(field("byteLength")?.unwrap_or_default());
        let buffer = field("buffer")?.unwrap_or_default();
        let outside = || format!("bufferView {index}: {start}..{end} is not in buffer {buffer}");
        let bytes = match self.buffers.get(buffer).ok_or_else(outside)? {
            Ok(bytes) => bytes.get(start..end).ok_or_else(outside)?,
            // The place is already that of the file, or of another one that is named here.
            Err(error) if error.place() == self.place => return Err(error.problem().to_owned()),
            Err(error) => return Err(error.to_string()),
        };
        Ok((bytes, field("byteStride")?))
    }
}

/// The types by their numbers of components.
const NAMES: [&str; 5] = ["", "SCALAR", "VEC2", "VEC3", "VEC4"];

fn width(accessor: &Value) -> Option<usize> {
    let name = json::text(accessor, "type")?;
    if name == "MAT4" { Some(16) } else { NAMES.iter().position(|known| *known == name) }
}

fn component(object: &Value) -> Unplaced<Component> {
    Ok(match json::index(object, "componentType")? {
        Some(5120) => Component::I8,
        Some(5121) => Component::U8,
        Some(5122) => Component::I16,
        Some(5123) => Component::U16,
        Some(5125) => Component::U32,
        Some(5126) => Component::F32,
        _ => return Err("componentType: must be 5120 to 5123, 5125 or 5126".to_owned()),
    })
}

impl Component {
    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The value that normalized integers divide by.
    fn largest(self) -> f64 {
        match self {
            Self::I8 => 127.0,
            Self::U8 => 255.0,
            Self::I16 => 32_767.0,
            Self::U16 => 65_535.0,
            Self::U32 => 4_294_967_295.0,
            Self::F32 => 1.0,
        }
    }

    /// One little-endian component.
    fn number(self, bytes: &[u8]) -> f64 {
        let word = bytes.iter().rev().fold(0_u32, |word, &byte| word << 8 | u32::from(byte));
        match self {
            Self::I8 => f64::from(word as u8 as i8),
            Self::I16 => f64::from(word as u16 as i16),
            Self::F32 => f64::from(f32::from_bits(word)),
            Self::U8 | Self::U16 | Self::U32 => f64::from(word),
        }
    }
}
