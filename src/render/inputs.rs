//! Inputs: what the application fills before a frame, by the names that a method declares.

use crate::error::{Error, Result};
use crate::exec::Method;
use crate::memory::{Declared, Inputs, Layout, Per};
use crate::raster::Grid;
use crate::scene::Scene;

/// The words of an input, as the application has them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Given {
    /// One word for all.
    Every(u32),
    /// A word for every pixel, row by row; as large as the picture.
    Image {
        /// Pixels across and down.
        size: [u32; 2],
        /// The words.
        words: Vec<u32>,
    },
    /// A word for every triangle and disc, in the order of submission.
    ByPrimitive(Vec<u32>),
    /// A word for every object of the scene, in their order; triangles given in pixels have the input's default.
    ByObject(Vec<u32>),
    /// Words for the frame.
    Frame(Vec<u32>),
}

impl Given {
    /// The words in the order of memory.
    fn words(&self, declared: &Declared, scene: &Scene, grid: &Grid) -> Result<Vec<u32>> {
        let triangles = triangles(scene);
        let all: usize = triangles.iter().sum::<usize>() + scene.screen.len();
        let wrong = |problem: String| Error::new(place(declared.name), problem);
        let count = |found: usize, needed: usize, what: &str| {
            let right = found == needed;
            right
                .then_some(())
                .ok_or_else(|| wrong(format!("has {found} words, but there are {needed} {what}")))
        };
        match (self, declared.per) {
            (Self::Every(word), Per::Pixel) => Ok(vec![*word; grid.storage_pixels()]),
            (Self::Every(word), Per::Primitive) => Ok(vec![*word; all]),
            (Self::Every(word), Per::Frame(words)) => Ok(vec![*word; words as usize]),
            (Self::Image { size: [w, h], words }, Per::Pixel) => {
                let [width, height] = [grid.width, grid.height];
                if [*w, *h] != [width, height] {
                    return Err(wrong(format!(
                        "is an image of {w}x{h} words, but the picture has {width}x{height} pixels"
                    )));
                }
                count(words.len(), width as usize * height as usize, "pixels")?;
                let mut stored = vec![declared.default; grid.storage_pixels()];
                for (i, &word) in (0..).zip(words) {
                    stored[grid.pixel(i % width, i / width) as usize] = word;
                }
                Ok(stored)
            }
            (Self::ByPrimitive(words), Per::Primitive) => {
                count(words.len(), all, "triangles")?;
                Ok(words.clone())
            }
            (Self::ByObject(words), Per::Primitive) => {
                count(words.len(), triangles.len(), "objects")?;
                let of_object = |(&word, &count)| std::iter::repeat_n(word, count);
                Ok(words.iter().zip(&triangles).flat_map(of_object).collect())
            }
            (Self::Frame(words), Per::Frame(needed)) => {
                count(words.len(), needed as usize, "words of the frame")?;
                Ok(words.clone())
            }
            (_, Per::Pixel) => Err(wrong("has a word for every pixel: give an image".to_owned())),
            (_, Per::Primitive) => {
                let how = "has a word for every triangle: give them by triangle or object";
                Err(wrong(how.to_owned()))
            }
            (_, Per::Frame(words)) => {
                Err(wrong(format!("has {words} words for the frame: give those")))
            }
        }
    }
}

fn place(name: &str) -> String {
    format!("input '{name}'")
}

/// The number of triangles and discs of every object.
fn triangles(scene: &Scene) -> Vec<usize> {
    scene.objects.iter().map(|object| object.mesh.primitives()).collect()
}

/// Fill the words of all inputs of a layout.
///
/// # Errors
/// An input that the method does not have, or words of another number or kind.
pub(super) fn fill(
    given: &[(String, Given)],
    method: Method,
    layout: &Layout,
    scene: &Scene,
    grid: &Grid,
) -> Result<Inputs> {
    let declared = layout.inputs();
    let mut inputs = Inputs::defaults(layout);
    for (name, given) in given {
        let Some(input) = declared.iter().position(|d| d.name == name) else {
            let names: Vec<&str> = declared.iter().map(|d| d.name).collect();
            let known = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
            let problem = format!("{} has no such input; it has {known}", method);
            return Err(Error::new(place(name), problem));
        };
        inputs.fill(input, given.words(&declared[input], scene, grid)?);
    }
    Ok(inputs)
}
