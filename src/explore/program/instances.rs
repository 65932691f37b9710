//! The instances of a method: every litmus pixel up to a size, from its contract.
//!
//! Fragments matter to a scheme only through the order of their (depth, data), so they are enumerated up to order:
//! sorted neighbours differ in depth, only in data, or not at all, which gives 3^(n-1) patterns. The first depth is 0
//! and, with several, the last is the far plane's, so the ends of the range are always included. Other values of the
//! same patterns: [`super::values`].

use super::litmus::{Entry, Litmus};
use super::subject::Subject;
use crate::fragment::{Data, key};
use crate::memory::{Declared, Per};
use crate::num::depth::{FARTHEST, Format};
use crate::scheme::Contract;
use crate::scheme::contract::{Extra, Keeps};
use crate::scheme::hash_table::table::{Offsets, TableSettings};

/// How many fragments have all patterns of neighbours; more have distinct depths.
pub const ALL_PATTERNS: u32 = 5;

/// Opacities of fragments whose colours matter, by their data words: of the first at a depth some, and another at
/// another depth; of the second all; of others none.
fn opacity(data: u32) -> u32 {
    match data % 16 {
        0 => [0xC0, 0x80, 0x60, 0x40][(data / 16 % 4) as usize],
        1 => 0xFF,
        _ => 0x00,
    }
}

/// How a fragment relates to the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Farther,
    OtherData,
    Same,
}

/// Fragments at pixels: how many pixels there are, and the pixel of each fragment.
type Places = (u32, Vec<u32>);

/// Which instances to make.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Family {
    /// The most fragments.
    pub fragments: u32,
    /// The k to try, for methods that take one.
    pub ks: Vec<u32>,
    /// Helper invocations next to the first fragments.
    pub helpers: u32,
}

/// All instances of a method with at least one fragment, smallest first: by n, then k, then room and pixels, then pattern.
#[must_use]
pub fn instances(subject: &Subject, family: &Family) -> Vec<Litmus> {
    (1..=family.fragments).flat_map(|n| of_size(subject, family, n)).collect()
}

/// The instances with exactly `n` fragments.
#[must_use]
pub fn of_size(subject: &Subject, family: &Family, n: u32) -> Vec<Litmus> {
    let all = of_contract(subject.contract, family, n);
    let Some(first) = all.first() else { return all };
    let declared = subject.case(first).instance.layout().inputs().to_vec();
    if declared.is_empty() {
        return all;
    }
    all.into_iter().flat_map(|litmus| with_inputs(litmus, &declared)).collect()
}

/// An instance with every choice of the values to try for its inputs, for up to three words of an input that matter;
/// with more words, one value for all of them, and the values in turn.
fn with_inputs(litmus: Litmus, declared: &[Declared]) -> Vec<Litmus> {
    let mut all = vec![litmus];
    for input in declared {
        let longer = |litmus: &Litmus| {
            let choices = choices(litmus, input);
            let litmus = litmus.clone();
            choices.into_iter().map(move |words| {
                let mut litmus = litmus.clone();
                litmus.inputs.push(words);
                litmus
            })
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

/// The words of one input to try on an instance.
fn choices(litmus: &Litmus, input: &Declared) -> Vec<Vec<u32>> {
    const MOST: usize = 3;
    let tried = if input.tried.is_empty() { &[input.default][..] } else { input.tried };
    let mut places: Vec<u32> = match input.per {
        Per::Pixel => (0..litmus.pixels).collect(),
        Per::Primitive => litmus.fragments.iter().map(|f| f.2).collect(),
        Per::Frame(words) => (0..words as u32).collect(),
    };
    places.sort_unstable();
    places.dedup();
    let spread = |values: &[u32]| {
        let mut words = vec![input.default; places.last().map_or(0, |&last| last as usize + 1)];
        for (&place, &value) in places.iter().zip(values) {
            words[place as usize] = value;
        }
        words
    };
    let mut values: Vec<Vec<u32>> = vec![Vec::new()];
    if places.len() <= MOST {
        for _ in &places {
            let longer = |head: &Vec<u32>| {
                let head = head.clone();
                tried.iter().map(move |&value| [head.as_slice(), &[value]].concat())
            };
            values = values.iter().flat_map(longer).collect();
        }
    } else {
        values = tried.iter().map(|&value| vec![value; places.len()]).collect();
        values.push((0..places.len()).map(|i| tried[i % tried.len()]).collect());
    }
    values.iter().map(|values| spread(values)).collect()
}

/// The instances with exactly `n` fragments, for any inputs.
fn of_contract(contract: &Contract, family: &Family, n: u32) -> Vec<Litmus> {
    let ks: Vec<Option<u32>> = if contract.default_k.is_some() {
        family.ks.iter().copied().filter(|&k| k <= contract.max_k).map(Some).collect()
    } else {
        vec![None]
    };
    let short = contract.is_pooled() && n > 1;
    let rooms = if short { vec![n, n - 1] } else { vec![n] };
    let mut all = Vec::new();
    if contract.crosses() {
        return hashed(contract, family, n);
    }
    for &k in &ks {
        for &room in &rooms {
            for (pixels, places) in in_turns(n, 3).into_iter().chain(sparse(n)) {
                for relations in patterns(n, pixels) {
                    let sorted = fragments(&relations, &places, contract);
                    let helpers = family.helpers.min(n);
                    let few = pixels > 1 || room < n || n > ALL_PATTERNS;
                    for thick in thicknesses(&sorted, contract, few) {
                        for fragments in arrivals(thick, contract) {
                            let (table, inputs) = (None, Vec::new());
                            all.push(Litmus { pixels, k, room, fragments, helpers, table, inputs });
                        }
                    }
                }
            }
        }
    }
    all
}

/// The instances of a method with a hash table: also with tables of one to eight cells, and with fragments spread over
/// up to three pixels (over two, in every way).
fn hashed(contract: &Contract, family: &Family, n: u32) -> Vec<Litmus> {
    let helpers = family.helpers.min(n);
    let mut all = Vec::new();
    let in_turns = in_turns(n, n).into_iter().map(|places| (places, true));
    let sparse = sparse(n).into_iter().map(|places| (places, false));
    for ((pixels, places), divides) in in_turns.chain(sparse) {
        let mut lists: Vec<Vec<Entry>> = Vec::new();
        for relations in patterns(n, pixels) {
            lists.extend(colored(fragments(&relations, &places, contract), contract));
        }
        if divides && pixels == 2 && n <= ALL_PATTERNS {
            lists = lists.iter().flat_map(|list| divided(list)).collect();
        }
        for table in tables(contract, n, pixels) {
            for fragments in lists.iter().cloned() {
                let table = Some(table);
                let (k, inputs) = (None, Vec::new());
                all.push(Litmus { pixels, k, room: n, fragments, helpers, table, inputs });
            }
        }
    }
    all
}

/// On one pixel; and, from two up to `most` fragments, on two or three, in turns.
fn in_turns(n: u32, most: u32) -> Vec<Places> {
    let several = if (2..=most).contains(&n) { n.min(3) } else { 1 };
    (1..=several).map(|pixels| (pixels, (0..n).map(|i| i % pixels).collect())).collect()
}

/// Pixels without fragments: none at all, and beside those that have some.
fn sparse(n: u32) -> Vec<Places> {
    match n {
        0 => vec![(2, vec![]), (3, vec![])],
        1 => vec![(2, vec![0]), (2, vec![1]), (3, vec![1])],
        2 => vec![(2, vec![0, 0]), (2, vec![1, 1]), (3, vec![0, 2])],
        _ => vec![],
    }
}

/// The fragments divided between two pixels in every way that leaves some at both.
fn divided(list: &[Entry]) -> Vec<Vec<Entry>> {
    let ways = 1..(1u32 << list.len()) - 1;
    let way = |bits: u32| {
        let pixel = move |i: usize| bits >> i & 1;
        list.iter().enumerate().map(|(i, f)| Entry(pixel(i), f.1, f.2, f.3)).collect()
    };
    ways.map(way).collect()
}

/// For a method that depends on opacity: every choice of opaque fragments, and of those that let nearly all light pass.
fn colored(list: Vec<Entry>, contract: &Contract) -> Vec<Vec<Entry>> {
    if contract.keeps != Keeps::Visible {
        return vec![list];
    }
    let alphas = |bits: u32| {
        let mut list = list.clone();
        for (i, fragment) in list.iter_mut().enumerate() {
            let alpha: u32 = if bits >> i & 1 == 1 { 240 } else { 16 };
            fragment.2 |= alpha << 24;
        }
        list
    };
    let mut all: Vec<_> = (0..1u32 << list.len().min(5)).map(alphas).collect();
    all.iter_mut().for_each(|list| list.sort_by_key(|f| key(f.1, f.2)));
    all.sort_unstable();
    all.dedup();
    all
}

/// Tables to try. With one or two fragments: of one to four cells, with all sequences of three offsets, and some of
/// eight cells with seven ages; with three, every fifth of those; with more, one of one, two, four and eight cells
/// each.
fn tables(contract: &Contract, n: u32, pixels: u32) -> Vec<TableSettings> {
    let table = |size, ages, seed| TableSettings {
        size,
        ages,
        offsets: Offsets::Digits,
        seed,
        ..TableSettings::default()
    };
    // Ages one after another along a row of cells.
    let straight = |cells: u32, ages: u32| {
        let base = u64::from(cells);
        let seed = (0..ages).rev().fold(0, |seed, age| seed * base + u64::from(age) % base);
        table([cells, 1], ages, seed)
    };
    let mut all = Vec::new();
    if n > 3 || contract.keeps == Keeps::Visible {
        // The walks of early culling concern one pixel: no table needs to wrap.
        all.push(straight(8, n + 2));
    }
    if contract.keeps == Keeps::Visible {
        all.extend((n <= 3).then(|| straight(3, 3)));
    } else if n > 3 {
        all.extend([1, 2, 4].map(|cells| straight(cells, 3)));
    } else {
        for (size, ages) in [([1, 1], 3), ([2, 1], 3), ([3, 1], 3), ([2, 2], 3), ([4, 2], 7)] {
            let cells = u64::from(size[0] * size[1]);
            let stride = if cells == 8 { 300_007 } else { 1 } * if n == 3 { 5 } else { 1 };
            let seeds = (0..cells.pow(ages)).step_by(stride);
            all.extend(seeds.map(|seed| table(size, ages, seed)));
        }
    }
    all.retain(|table| table.size[0] >= pixels);
    all
}

/// The thicknesses to try, for a method with slabs. A slab may be a surface (0), touch the next nearer depth (1), reach
/// just beyond it (2), or beyond the one after that (3): by the digits of a choice, one for each fragment in turn. Where
/// other things are varied (`few`), all reach beyond the next; few choices are tried of a method that merges in resolve.
fn thicknesses(sorted: &[Entry], contract: &Contract, few: bool) -> Vec<Vec<Entry>> {
    const CHOICES: [[usize; 4]; 9] = [
        [2, 2, 2, 2],
        [3, 1, 3, 2],
        [1, 1, 1, 1],
        [0, 0, 0, 0],
        [3, 3, 3, 3],
        [2, 0, 2, 0],
        [0, 2, 0, 2],
        [0, 0, 3, 3],
        [0, 3, 0, 0],
    ];
    if !contract.has_slabs() {
        return vec![sorted.to_vec()];
    }
    let mut depths: Vec<u32> = sorted.iter().map(|f| f.1).collect();
    depths.dedup();
    let reach = |f: &Entry, choice: usize| {
        let level = depths.partition_point(|&depth| depth < f.1);
        let to = |before: usize| f.1 - level.checked_sub(before).map_or(0, |at| depths[at]);
        match (choice, level) {
            (0, _) => 0,
            // There is nothing nearer.
            (1 | 2, 0) => choice as u32,
            (1, _) => to(1),
            (2, _) => to(1) + 1,
            _ => to(2).saturating_add(1).min(f.1),
        }
    };
    let of = |choice: &[usize; 4]| {
        let thick = |(f, &choice): (&Entry, &usize)| {
            let Entry(pixel, depth, data, _) = *f;
            Entry(pixel, depth, data, reach(f, choice))
        };
        sorted.iter().zip(choice.iter().cycle()).map(thick).collect()
    };
    // Where all fragments are stored first, interleavings do not depend on them.
    let choices = match (few, contract.is_pooled()) {
        (true, _) => &CHOICES[..1],
        (false, true) => &CHOICES[..2],
        (false, false) => &CHOICES[..],
    };
    let mut all: Vec<Vec<Entry>> = choices.iter().map(of).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The orders of arrival to try. It matters only where the interlock makes it the order of execution. Then all orders
/// of up to four fragments; of more, forwards and backwards.
fn arrivals(sorted: Vec<Entry>, contract: &Contract) -> Vec<Vec<Entry>> {
    if !contract.is_interlocked() {
        return vec![sorted];
    }
    if sorted.len() > 4 {
        let back = sorted.iter().rev().copied().collect();
        return vec![sorted, back];
    }
    let mut all = vec![Vec::new()];
    for fragment in sorted {
        let longer = |order: &Vec<Entry>| {
            let order = order.clone();
            (0..=order.len()).map(move |place| {
                let mut order = order.clone();
                order.insert(place, fragment);
                order
            })
        };
        all = all.iter().flat_map(longer).collect();
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// The relations of n sorted fragments, all of them for up to [`ALL_PATTERNS`] fragments of one pixel.
fn patterns(n: u32, pixels: u32) -> Vec<Vec<Relation>> {
    if n > ALL_PATTERNS || pixels > 1 {
        return vec![vec![Relation::Farther; n.saturating_sub(1) as usize]];
    }
    let mut all = vec![Vec::new()];
    for _ in 1..n {
        let longer = |head: &Vec<Relation>| {
            [Relation::Farther, Relation::OtherData, Relation::Same].map(|r| {
                let mut next = head.clone();
                next.push(r);
                next
            })
        };
        all = all.iter().flat_map(longer).collect();
    }
    all
}

fn fragments(relations: &[Relation], places: &[u32], contract: &Contract) -> Vec<Entry> {
    let format = contract.depth_format.unwrap_or(Format::D32);
    let levels = 1 + relations.iter().filter(|&&r| r == Relation::Farther).count() as u32;
    // Data words decrease as depth grows, so that nothing sorted by one is sorted by the other.
    let first_data = |level: u32| (levels - level) * 0x10;
    let (mut level, mut data) = (0, first_data(0));
    let mut all = Vec::new();
    for (i, &pixel) in places.iter().enumerate() {
        match i.checked_sub(1).map(|before| relations[before]) {
            Some(Relation::Farther) => {
                level += 1;
                data = first_data(level);
            }
            Some(Relation::OtherData) => data += 1,
            _ => {}
        }
        // A slab at depth 0 could not be thick.
        let before = if contract.has_slabs() { level + 1 } else { level };
        let code = if level + 1 == levels { FARTHEST } else { before * 0x1000_0000 };
        let data = match contract.data {
            Some(Data::Nothing) => 0,
            // Colours that can be seen.
            _ if contract.has_slabs() => {
                data | (0x40 + 0x3F * ((data / 16 + data) % 4)) << 24 | 0x20_4080
            }
            Some(Data::Color) if contract.keeps.is_approximate() => {
                data | opacity(data) << 24 | 0x20_4080
            }
            _ => data,
        };
        let third = if contract.extra == Extra::Primitive { i as u32 } else { 0 };
        all.push(Entry(pixel, format.encode(code), data, third));
    }
    all.sort_by_key(|f| key(f.1, f.2));
    all
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::catalogue;

    fn sized(method: &str, n: u32) -> Vec<Litmus> {
        let family = Family { fragments: n, ks: vec![1, 2, 3], helpers: 0 };
        let subject = Subject::new(catalogue::method(method).expect("known")).expect("a scheme");
        of_size(&subject, &family, n)
    }

    #[test]
    fn patterns_are_all_and_distinct() {
        for n in 1..=5u32 {
            let one_pixel = sized("kplus-array", n).into_iter().filter(|l| l.pixels == 1);
            let distinct: BTreeSet<Litmus> = one_pixel.collect();
            assert_eq!(distinct.len(), 3 * 3usize.pow(n - 1), "three k, n = {n}");
        }
        assert_eq!(sized("kplus-array", 6).len(), 3, "beyond, distinct depths only");
    }

    #[test]
    fn the_ends_of_the_range_are_among_them() {
        for litmus in sized("kplus-array", 3) {
            let keys: Vec<u32> = litmus.fragments.iter().map(|f| f.1).collect();
            assert!(keys.contains(&FARTHEST));
            assert!(keys.is_sorted());
            let levels: BTreeSet<u32> = keys.iter().copied().collect();
            assert!(levels.len() == 1 || keys.contains(&0));
        }
    }

    #[test]
    fn pools_and_slots_are_also_tried_too_small() {
        for method in ["ab-ll", "ab-array"] {
            let rooms: BTreeSet<u32> = sized(method, 3).iter().map(|l| l.room).collect();
            assert_eq!(rooms, BTreeSet::from([2, 3]), "{method}");
        }
    }
}
