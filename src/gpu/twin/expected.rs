//! What a band's pixels must hold.

use rayon::prelude::*;

use super::light;
use super::merged::Promised;
use super::picture::Picture;
use crate::exec::Method;
use crate::exec::promise::Promise;
use crate::fragment::{Data, Fragment, data_of, depth_of, key};
use crate::raster::Record;
use crate::resolve::composite::Ray;
use crate::scheme::contract::{Contract, Keeps};
use crate::scheme::{Config, Depth, Held};

/// All that the right answer depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Question {
    /// What is stored of a fragment.
    pub(super) record: Record,
    pub(super) keeps: Keeps,
    /// Which of the methods that approximate: no two give the same.
    pub(super) approximates: Option<&'static str>,
    pub(super) identical: bool,
    pub(super) arrival: bool,
    pub(super) k: Option<u32>,
}

/// Records of every storage pixel, one after another.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lists {
    /// Where each pixel's records begin; one entry more than there are pixels.
    pub starts: Vec<u32>,
    /// All records.
    pub keys: Vec<u64>,
}

impl Lists {
    fn of(lists: &[Vec<u64>]) -> Self {
        let mut starts = vec![0];
        let mut keys = Vec::with_capacity(lists.iter().map(Vec::len).sum());
        for list in lists {
            keys.extend_from_slice(list);
            starts.push(keys.len() as u32);
        }
        Self { starts, keys }
    }

    /// A pixel's records.
    #[must_use]
    pub fn pixel(&self, pixel: usize) -> &[u64] {
        &self.keys[self.starts[pixel] as usize..self.starts[pixel + 1] as usize]
    }

    /// How many pixels there are.
    #[must_use]
    pub fn pixels(&self) -> usize {
        self.starts.len() - 1
    }
}

/// What a method must give.
#[derive(Clone, Debug)]
pub struct Expected {
    /// What was generated, sorted.
    pub generated: Lists,
    /// What is kept, front to back.
    pub kept: Lists,
    /// The pixels' colours, sRGB RGBA8.
    pub colors: Vec<u32>,
    /// Of a method that merges, all that it must give; nothing is then kept, and nothing coloured.
    pub merged: Option<Promised>,
    /// Of a method that approximates, all that it must give.
    pub light: Option<light::Promised>,
}

impl Expected {
    /// Where each pixel's places begin in the results of resolve, and the end.
    #[must_use]
    pub fn starts(&self) -> &[u32] {
        match (&self.merged, &self.light) {
            (Some(merged), _) => &merged.starts,
            (None, Some(light)) => &light.starts,
            (None, None) => &self.kept.starts,
        }
    }
}

/// What a method that merges must give for pixels with these fragments.
pub(super) fn merged(lists: &[Vec<Fragment>], promise: &Promise<'_>, config: &Config) -> Expected {
    let keys = |list: &Vec<Fragment>| list.iter().map(|f| f.key()).collect();
    let generated: Vec<Vec<u64>> = lists.iter().map(keys).collect();
    let promised = Promised::new(lists, config.k.unwrap_or(u32::MAX), config.distances, promise);
    Expected {
        generated: Lists::of(&generated),
        kept: Lists::of(&vec![Vec::new(); lists.len()]),
        colors: Vec::new(),
        merged: Some(promised),
        light: None,
    }
}

/// What a method that approximates must give for these fragments.
pub(super) fn colored(
    method: Method,
    config: &Config,
    fragments: Vec<Fragment>,
    promise: &Promise<'_>,
) -> Expected {
    let mut lists = vec![Vec::new(); config.pixels as usize];
    for fragment in fragments {
        lists[fragment.pixel as usize].push(fragment);
    }
    lists.par_iter_mut().for_each(|list| list.sort_unstable());
    let keys = |list: &Vec<Fragment>| list.iter().map(|f| f.key()).collect();
    let generated: Vec<Vec<u64>> = lists.iter().map(keys).collect();
    Expected {
        generated: Lists::of(&generated),
        kept: Lists::of(&vec![Vec::new(); lists.len()]),
        colors: Vec::new(),
        merged: None,
        light: light::Promised::new(method, config, &lists, promise),
    }
}

/// What any other method must give.
pub(super) fn kept(
    lists: &[Vec<u64>],
    picture: &Picture,
    contract: &Contract,
    promise: &Promise<'_>,
    Question { record, k, .. }: Question,
) -> Expected {
    let named = record.data == Data::Primitive;
    let word = |&exact: &u64| {
        let data = if named { data_of(exact) } else { 0 };
        key(record.depth.encode(depth_of(exact)), data)
    };
    let pixel = |(pixel, list): (usize, &Vec<u64>)| {
        let mut generated: Vec<u64> = list.iter().map(word).collect();
        generated.sort_unstable();
        let fragments: Vec<Fragment> = generated.iter().map(|&key| Fragment::of_key(key)).collect();
        let mut kept = match promise.pixel(pixel as u32, &fragments) {
            Some(Held::Keys(keys)) => keys,
            // A twin emits a depth as a record without data, and none for no depth.
            Some(Held::Depth(Depth(depth))) if depth < u32::MAX => vec![key(depth, 0)],
            _ => Vec::new(),
        };
        // Some of them, as many as there are slots.
        if let (Keeps::FirstArrivals, Some(slots)) = (contract.keeps, k) {
            kept.truncate(slots as usize);
        }
        (generated, kept)
    };
    let color = |list: &Vec<u64>| {
        let mut ray = Ray::default();
        for &key in list {
            let data = data_of(key);
            ray.over(if named { picture.palette[256 + data as usize] } else { data });
        }
        u32::from_le_bytes(ray.finish(picture.background))
    };
    let (generated, kept): (Vec<_>, Vec<_>) = lists.par_iter().enumerate().map(pixel).unzip();
    let colors = kept.par_iter().map(color).collect();
    Expected {
        generated: Lists::of(&generated),
        kept: Lists::of(&kept),
        colors,
        merged: None,
        light: None,
    }
}
