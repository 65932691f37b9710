//! Dumped fragments against the exact lists, fragment by fragment.

mod lists;
mod read;

use rayon::prelude::*;
use serde::Serialize;

use super::Settings;
use super::answer::{Answer, Entry};
use super::class::Class;
use super::pixel::edge::{Near, fragments};
use super::verdict::{Counted, counted};
use crate::error::{Error, Result};
use crate::render::Data;
use lists::{Fate, Pair, Same, compare};

pub use read::Dump;

/// Fragments told one by one.
const TOLD: usize = 10;

/// What is said of a dump.
#[derive(Clone, Debug, Serialize)]
pub struct DumpVerdict {
    /// Its file.
    pub dump: String,
    /// Every fragment is an exact one, or within the tolerances.
    pub right: bool,
    /// Fragments of the exact answer.
    pub exact: u64,
    /// Fragments of the dump.
    pub dumped: u64,
    /// Classes of pixels, in the order of [`Class::ALL`]: of each pixel, that of its fragments that says most.
    pub classes: Vec<Counted>,
    /// Classes of fragments, of the dump and of those that are missing from it.
    pub fragments: Vec<FragmentClass>,
    /// The first fragments that are not right.
    pub first: Vec<Odd>,
    /// By pixel, row by row.
    #[serde(skip)]
    pub map: Vec<Class>,
}

/// How many fragments have a class.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct FragmentClass {
    /// The class.
    pub class: Class,
    /// What it means.
    pub meaning: &'static str,
    /// Fragments.
    pub fragments: u64,
    /// The largest difference of a depth word among them.
    pub max_codes: u64,
}

/// A fragment that is not right.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Odd {
    /// What is the matter.
    pub class: Class,
    /// Column and row of its pixel.
    pub pixel: [u32; 2],
    /// Its place in the pixel's exact list from 0 at the front, or if it is not there, in the dumped one.
    pub index: u32,
    /// Its depth word.
    pub depth: u32,
    /// Its data word.
    pub data: u32,
    /// The triangle, of an exact one.
    pub triangle: Option<u32>,
    /// Its object.
    pub object: Option<String>,
}

/// Judge dumped fragments; `name` names the dump in messages, and `data` says what its data words are.
///
/// # Errors
/// A dump of another size.
pub fn judge(
    answer: &Answer<'_>,
    dump: &Dump,
    data: Data,
    name: &str,
    settings: &Settings,
) -> Result<DumpVerdict> {
    let size = answer.scene.size;
    let wrong = |problem: String| Err(Error::new(name, problem));
    if let Some([w, h]) = dump.size.filter(|own| *own != size) {
        let [width, height] = size;
        let scene = &answer.scene.name;
        return wrong(format!("is {w}x{h}, but {scene} is drawn at {width}x{height} (--size)"));
    }
    let outside = |(place, ..): &&([u32; 2], u32, u32)| place[0] >= size[0] || place[1] >= size[1];
    if let Some(([x, y], ..)) = dump.fragments.iter().find(outside) {
        let [width, height] = size;
        return wrong(format!("the pixel {x},{y} is outside of the picture of {width}x{height}"));
    }
    let dumped = gathered(dump, size);
    let pixels = size[0] as usize * size[1] as usize;
    let deepest = dumped.iter().map(Vec::len).max().unwrap_or(0);
    let near = Near::new(answer, settings.edge_distance, |_| true);
    let format = answer.options.record().depth;
    let word = |entry: &Entry| match data {
        Data::Primitive => entry.triangle,
        Data::Color => entry.color,
        Data::Nothing => 0,
    };
    let is_near =
        |a: u32, b: u32| (format.decode(a) - format.decode(b)).abs() <= settings.depth_distance;
    let is_alike = |a: u32, b: u32| {
        let mut bytes = a.to_le_bytes().into_iter().zip(b.to_le_bytes());
        a == b || data == Data::Color && bytes.all(|(a, b)| a.abs_diff(b) <= settings.tolerance)
    };
    let most = answer.options.k.map_or(usize::MAX, |k| k as usize);
    let exact = |pixel: usize| {
        let list = answer.list(pixel);
        let mut pairs: Vec<Pair> = list.iter().map(|e| (e.depth, word(e))).collect();
        // By depth and word, as the exact answer with this word is.
        pairs.sort_unstable();
        pairs.truncate(most);
        pairs
    };
    let one = |pixel: usize| {
        let edges = fragments(answer, pixel, near.of(pixel));
        let is_edge = |(depth, data): Pair| {
            edges.iter().any(|edge| is_near(edge.depth, depth) && is_alike(word(edge), data))
        };
        let same = Same { is_near: &is_near, is_alike: &is_alike, is_edge: &is_edge };
        let (exact, own) = (exact(pixel), &dumped[pixel]);
        let mut fates = compare(&exact, own, &same);
        // What lies behind as many as are kept anywhere.
        if own.len() == deepest && own.len() < exact.len() {
            let behind =
                |fate: &&mut Fate| fate.class == Class::Missing && fate.index as usize >= own.len();
            fates.iter_mut().filter(behind).for_each(|fate| fate.class = Class::BeyondK);
        }
        fates
    };
    let fates: Vec<Vec<Fate>> = (0..pixels).into_par_iter().map(one).collect();
    let map: Vec<Class> = fates.iter().map(|fates| class(fates)).collect();
    let first = fates
        .iter()
        .enumerate()
        .flat_map(|(pixel, fates)| fates.iter().map(move |fate| (pixel, fate)))
        .filter(|(_, fate)| !fate.class.is_right())
        .take(TOLD)
        .map(|(pixel, fate)| odd(answer, pixel, fate, &exact(pixel), &dumped[pixel], word));
    Ok(DumpVerdict {
        dump: name.to_owned(),
        right: map.iter().all(|class| class.is_right()),
        exact: (0..pixels).map(|pixel| answer.list(pixel).len().min(most) as u64).sum(),
        dumped: dump.fragments.len() as u64,
        first: first.collect(),
        classes: counted(&map, &vec![0; pixels], size[0]),
        fragments: by_fragment(&fates),
        map,
    })
}

/// The fragments of every pixel, in their order.
fn gathered(dump: &Dump, size: [u32; 2]) -> Vec<Vec<Pair>> {
    let mut lists = vec![Vec::new(); size[0] as usize * size[1] as usize];
    for &([x, y], depth, data) in &dump.fragments {
        lists[y as usize * size[0] as usize + x as usize].push((depth, data));
    }
    lists
}

/// What a pixel's fragments say together.
fn class(fates: &[Fate]) -> Class {
    const ORDER: [Class; 11] = [
        Class::Missing,
        Class::Extra,
        Class::Duplicated,
        Class::Data,
        Class::Depth,
        Class::Order,
        Class::BeyondK,
        Class::Tie,
        Class::Edge,
        Class::Rounding,
        Class::Equal,
    ];
    let has = |class: &&Class| fates.iter().any(|fate| fate.class == **class);
    ORDER.iter().find(has).copied().unwrap_or(Class::Equal)
}

fn by_fragment(fates: &[Vec<Fate>]) -> Vec<FragmentClass> {
    let count = |class: Class| {
        let own = || fates.iter().flatten().filter(|fate| fate.class == class);
        let fragments = own().count() as u64;
        let max_codes = own().map(|fate| fate.codes).max().unwrap_or(0);
        FragmentClass { class, meaning: class.meaning(), fragments, max_codes }
    };
    Class::ALL.into_iter().map(count).filter(|count| count.fragments > 0).collect()
}

fn odd(
    answer: &Answer<'_>,
    pixel: usize,
    fate: &Fate,
    exact: &[Pair],
    dumped: &[Pair],
    word: impl Fn(&Entry) -> u32,
) -> Odd {
    let (depth, data) = match fate.is_exact {
        true => exact[fate.index as usize],
        false => dumped[fate.index as usize],
    };
    let entry = answer.list(pixel).iter().find(|e| (e.depth, word(e)) == (depth, data));
    let triangle = entry.map(|entry| entry.triangle);
    let object = triangle.and_then(|triangle| answer.object(triangle)).map(str::to_owned);
    let width = answer.scene.size[0];
    let pixel = [pixel as u32 % width, pixel as u32 / width];
    Odd { class: fate.class, pixel, index: fate.index, depth, data, triangle, object }
}
