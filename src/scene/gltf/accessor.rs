//! Reading accessors: numbers of any component type at any stride, with sparse replacements.

use std::borrow::Cow;

use gltf::json::accessor::{Accessor, ComponentType, Type, sparse::Sparse};
use gltf::json::buffer::View;
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use crate::error::{Error, Result};

/// The most elements of an accessor without a buffer view, whose size nothing else limits.
const MAX_ZEROS: usize = 1 << 26;

/// A document with its buffers.
pub(super) struct Data<'a> {
    pub(super) root: &'a Root,
    pub(super) buffers: Vec<Cow<'a, [u8]>>,
    pub(super) place: &'a str,
}

/// How elements lie in a buffer view.
#[derive(Clone, Copy)]
struct Layout {
    component: ComponentType,
    /// Components of an element.
    width: usize,
    offset: u64,
    count: usize,
}

impl Data<'_> {
    /// Three numbers per element: VEC3, or VEC4 without its last one (the opacity of a colour).
    pub(super) fn vectors(
        &self,
        index: usize,
        semantic: &str,
        user: &str,
    ) -> Result<Vec<[f32; 3]>> {
        let name = format!("{user}: {semantic}: accessor {index}");
        let accessor = self.accessor(index, &name)?;
        let width = match accessor.type_ {
            Checked::Valid(Type::Vec3) => 3,
            Checked::Valid(Type::Vec4) if semantic == "COLOR_0" => 4,
            _ => return Err(self.wrong(&name, "type: must be VEC3 (or VEC4 for colours)")),
        };
        let component = self.component(accessor, &name)?;
        let normalized = accessor.normalized && component != ComponentType::F32;
        let values = self.values(accessor, component, width, &name)?;
        let scale = if normalized { largest(component) } else { 1.0 };
        let number = |value: f64| (value / scale).max(if normalized { -1.0 } else { value }) as f32;
        Ok(values.chunks_exact(width).map(|v| [number(v[0]), number(v[1]), number(v[2])]).collect())
    }

    /// Indices of any unsigned type.
    pub(super) fn indices(&self, index: usize, user: &str) -> Result<Vec<u32>> {
        let name = format!("{user}: indices: accessor {index}");
        let accessor = self.accessor(index, &name)?;
        if accessor.type_ != Checked::Valid(Type::Scalar) {
            return Err(self.wrong(&name, "type: must be SCALAR"));
        }
        let component = self.component(accessor, &name)?;
        if !matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32) {
            return Err(self.wrong(&name, "componentType: must be an unsigned integer"));
        }
        let values = self.values(accessor, component, 1, &name)?;
        Ok(values.into_iter().map(|value| value as u32).collect())
    }

    fn wrong(&self, name: &str, problem: impl std::fmt::Display) -> Error {
        Error::new(self.place, format!("{name}: {problem}"))
    }

    fn accessor(&self, index: usize, name: &str) -> Result<&Accessor> {
        let count = self.root.accessors.len();
        let missing = || self.wrong(name, format!("is not among the {count} accessors"));
        self.root.accessors.get(index).ok_or_else(missing)
    }

    fn component(&self, accessor: &Accessor, name: &str) -> Result<ComponentType> {
        match accessor.component_type {
            Checked::Valid(component) => Ok(component.0),
            Checked::Invalid => Err(self.wrong(name, "componentType: is not one of glTF's")),
        }
    }

    /// All components of all elements, as f64, which holds each of them exactly.
    fn values(
        &self,
        accessor: &Accessor,
        component: ComponentType,
        width: usize,
        name: &str,
    ) -> Result<Vec<f64>> {
        let count = usize::try_from(accessor.count.0).unwrap_or(usize::MAX);
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let mut values = match accessor.buffer_view {
            Some(view) => self.strided(view, Layout { component, width, offset, count }, name)?,
            None if count <= MAX_ZEROS => vec![0.0; count * width],
            None => return Err(self.wrong(name, format!("count: must be at most {MAX_ZEROS}"))),
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace(sparse, component, width, &mut values, name)?;
        }
        Ok(values)
    }

    fn replace(
        &self,
        sparse: &Sparse,
        component: ComponentType,
        width: usize,
        values: &mut [f64],
        name: &str,
    ) -> Result<()> {
        let count = usize::try_from(sparse.count.0).unwrap_or(usize::MAX);
        let Checked::Valid(index_type) = sparse.indices.component_type else {
            return Err(self.wrong(name, "sparse.indices.componentType: must be unsigned"));
        };
        let at = Layout {
            component: index_type.0,
            width: 1,
            offset: sparse.indices.byte_offset.0,
            count,
        };
        let new = Layout { component, width, offset: sparse.values.byte_offset.0, count };
        let indices = self.strided(sparse.indices.buffer_view, at, name)?;
        let news = self.strided(sparse.values.buffer_view, new, name)?;
        for (index, new) in indices.iter().zip(news.chunks_exact(width)) {
            let start = *index as usize * width;
            match values.get_mut(start..start + width) {
                Some(old) => old.copy_from_slice(new),
                None => {
                    return Err(
                        self.wrong(name, format!("sparse.indices: {index} is out of range"))
                    );
                }
            }
        }
        Ok(())
    }

    /// The components that `layout` describes in a buffer view, after checking that they all are inside it.
    fn strided(&self, view: Index<View>, layout: Layout, name: &str) -> Result<Vec<f64>> {
        let (bytes, stride) = self.view(view, name)?;
        let size = layout.component.size();
        let element = size * layout.width;
        let stride = stride.unwrap_or(element);
        if stride < element || stride > 252 {
            return Err(self.wrong(name, format!("byteStride: {stride} is not {element} to 252")));
        }
        let last = (layout.count as u128).saturating_sub(1) * stride as u128;
        let end = u128::from(layout.offset) + last + element as u128;
        if layout.count > 0 && end > bytes.len() as u128 {
            let have = bytes.len();
            return Err(self.wrong(name, format!("needs {end} bytes, its buffer view has {have}")));
        }
        let start = (layout.offset as usize).min(bytes.len());
        let elements = bytes[start..].chunks(stride).take(layout.count);
        let components = elements.flat_map(|e| e[..element].chunks_exact(size));
        Ok(components.map(|bytes| number(bytes, layout.component)).collect())
    }

    fn view(&self, index: Index<View>, name: &str) -> Result<(&[u8], Option<usize>)> {
        let index = index.value();
        let count = self.root.buffer_views.len();
        let missing = || self.wrong(name, format!("bufferView: {index} is not among the {count}"));
        let view = self.root.buffer_views.get(index).ok_or_else(missing)?;
        let start = view.byte_offset.unwrap_or_default().0;
        let end = start.saturating_add(view.byte_length.0);
        let range = usize::try_from(start).unwrap_or(usize::MAX)
            ..usize::try_from(end).unwrap_or(usize::MAX);
        let bytes = self.buffers.get(view.buffer.value()).and_then(|buffer| buffer.get(range));
        let outside = || {
            let buffer = view.buffer.value();
            self.wrong(
                name,
                format!("bufferView {index}: {start}..{end} is not in buffer {buffer}"),
            )
        };
        Ok((bytes.ok_or_else(outside)?, view.byte_stride.map(|stride| stride.0)))
    }
}

/// The value that normalized integers divide by.
fn largest(component: ComponentType) -> f64 {
    match component {
        ComponentType::I8 => 127.0,
        ComponentType::U8 => 255.0,
        ComponentType::I16 => 32_767.0,
        ComponentType::U16 => 65_535.0,
        ComponentType::U32 => 4_294_967_295.0,
        ComponentType::F32 => 1.0,
    }
}

/// One little-endian component.
fn number(bytes: &[u8], component: ComponentType) -> f64 {
    let word = bytes.iter().rev().fold(0_u32, |word, &byte| word << 8 | u32::from(byte));
    match component {
        ComponentType::I8 => f64::from(word as u8 as i8),
        ComponentType::I16 => f64::from(word as u16 as i16),
        ComponentType::F32 => f64::from(f32::from_bits(word)),
        ComponentType::U8 | ComponentType::U16 | ComponentType::U32 => f64::from(word),
    }
}
