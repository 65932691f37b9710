//! Reading accessors: numbers of any component type at any stride, with sparse replacements.

use std::borrow::Cow;

use rayon::prelude::*;
use serde_json::Value;

use super::json;
use crate::error::{Error, Result};
use crate::scene::model::Unplaced;

/// The most elements of an accessor without a buffer view, whose size nothing else limits.
const MAX_ZEROS: usize = 1 << 26;

/// How many elements a thread reads at once.
const BLOCK: usize = 1 << 12;

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

    /// The elements, where there are three numbers of each: the same memory.
    pub(super) fn into_threes(self) -> Vec<[f64; 3]> {
        match bytemuck::allocation::try_cast_slice_box(self.values.into()) {
            Ok(threes) if self.width == 3 => {
                let threes: Box<[[f64; 3]]> = threes;
                threes.into_vec()
            }
            Ok(_) | Err(_) => Vec::new(),
        }
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
        let normalized = json::get(accessor, "normalized") == Some(&Value::Bool(true));
        let scale = (normalized && component != Component::F32).then(|| component.largest());
        let number = |value: f64| scale.map_or(value, |scale| (value / scale).max(-1.0));
        let values = self.values(accessor, component, width, number).map_err(wrong)?;
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
        self.values(accessor, component, 1, |value| value as u32).map_err(wrong)
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

    /// What `number` makes of all components of all elements.
    fn values<T: Copy + Default + Send>(
        &self,
        accessor: &Value,
        component: Component,
        width: usize,
        number: impl Fn(f64) -> T + Sync,
    ) -> Unplaced<Vec<T>> {
        let count = json::index(accessor, "count")?.unwrap_or_default();
        let offset = json::index(accessor, "byteOffset")?.unwrap_or_default();
        let mut values = match json::index(accessor, "bufferView")? {
            Some(view) => {
                self.strided(view, Layout { component, width, offset, count }, &number)?
            }
            None if count <= MAX_ZEROS => vec![number(0.0); count * width],
            None => return Err(format!("count: must be at most {MAX_ZEROS}")),
        };
        if let Some(sparse) = json::get(accessor, "sparse") {
            self.replace(sparse, component, width, &mut values, &number)
                .map_err(|problem| format!("sparse: {problem}"))?;
        }
        Ok(values)
    }

    fn replace<T: Copy + Default + Send>(
        &self,
        sparse: &Value,
        component: Component,
        width: usize,
        values: &mut [T],
        number: impl Fn(f64) -> T + Sync,
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
            Ok::<_, String>((view, Layout { component, width, offset, count }))
        };
        let (view, layout) = part("indices", None, 1)?;
        let at = self.strided(view, layout, |value| value).map_err(|p| format!("indices: {p}"))?;
        let (view, layout) = part("values", Some(component), width)?;
        let new = self.strided(view, layout, number).map_err(|p| format!("values: {p}"))?;
        for (index, new) in at.iter().zip(new.chunks_exact(width)) {
            let start = *index as usize * width;
            let old = values.get_mut(start..start + width);
            old.ok_or_else(|| format!("indices: {index} is out of range"))?.copy_from_slice(new);
        }
        Ok(())
    }

    /// What `number` makes of the components that `layout` describes in a buffer view, after checking that they all are
    /// inside it.
    fn strided<T: Copy + Default + Send>(
        &self,
        view: usize,
        layout: Layout,
        number: impl Fn(f64) -> T + Sync,
    ) -> Unplaced<Vec<T>> {
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
        let mut values = vec![T::default(); layout.count * layout.width];
        let read = |(values, bytes): (&mut [T], &[u8])| {
            for (values, bytes) in values.chunks_mut(layout.width).zip(bytes.chunks(stride)) {
                let components = bytes[..element].chunks_exact(size);
                for (value, bytes) in values.iter_mut().zip(components) {
                    *value = number(layout.component.number(bytes));
                }
            }
        };
        if layout.count <= BLOCK {
            read((&mut values, &bytes[start..]));
        } else {
            let blocks = values.par_chunks_mut(BLOCK * layout.width);
            blocks.zip(bytes[start..].par_chunks(BLOCK * stride)).for_each(read);
        }
        Ok(values)
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
        let word = match *bytes {
            [a] => u32::from(a),
            [a, b] => u16::from_le_bytes([a, b]).into(),
            [a, b, c, d] => u32::from_le_bytes([a, b, c, d]),
            _ => 0,
        };
        match self {
            Self::I8 => f64::from(word as u8 as i8),
            Self::I16 => f64::from(word as u16 as i16),
            Self::F32 => f64::from(f32::from_bits(word)),
            Self::U8 | Self::U16 | Self::U32 => f64::from(word),
        }
    }
}
