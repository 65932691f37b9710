//! The slabs of a pixel, and the records that a method makes of them in every order of arrival.

use std::collections::{BTreeMap, BTreeSet};

use super::words::label;
use crate::exec::one_pixel::OnePixel;
use crate::explore::program::litmus::Litmus;
use crate::explore::program::subject::Subject;
use crate::fragment::Fragment;
use crate::image::plot::{Curve, GAP, Plot};
use crate::num::depth::code;
use crate::num::orders::orders;
use crate::num::planes::Distances;
use crate::scheme::{Held, Record};

/// More fragments than this are stored in the order in which they are given only.
const MOST: usize = 6;

/// Draw the slabs of the first pixel's fragments, each in a lane of its own, named by its letter; and below them, the
/// records for every result that their orders of arrival give, with the first order that gives it. Boxes are as high as
/// slabs are opaque. Ends lie one step apart, however far they are: what matters is which slabs overlap. `None` if the
/// method holds no merged records.
///
/// # Panics
/// If the method's code does.
#[must_use]
pub fn slabs(subject: &Subject, litmus: &Litmus) -> Option<Plot> {
    let (method, config) = (subject.method, litmus.config(subject.contract));
    let fragments: Vec<Fragment> =
        litmus.fragments(subject.contract).filter(|f| f.pixel == 0).collect();
    let pixel = OnePixel::new(method, &config)?;
    let mut results: BTreeMap<Held, Vec<usize>> = BTreeMap::new();
    let all = if fragments.len() > MOST {
        vec![(0..fragments.len()).collect()]
    } else {
        orders(fragments.len())
    };
    for order in all {
        let arriving: Vec<Fragment> = order.iter().map(|&i| fragments[i]).collect();
        results.entry(pixel.store(&arriving).held).or_insert(order);
    }
    let mut results: Vec<(Vec<usize>, Held)> =
        results.into_iter().map(|(held, order)| (order, held)).collect();
    results.sort();
    let ends: BTreeSet<u32> = fragments.iter().flat_map(|f| [near_end(f), f.depth]).collect();
    let ends: Vec<u32> = ends.into_iter().collect();
    let place = |depth: u32| ends.partition_point(|end| *end < depth) as f64;
    // The first lane is the uppermost.
    let mut lane = (fragments.len() + results.len()) as f64;
    let mut curves = Vec::new();
    for (i, fragment) in fragments.iter().enumerate() {
        let mut curve = Curve::new(&format!("{}: slab", label(i)));
        // A line of one point is not seen: it makes room for the names.
        let room = (i == 0).then_some([[0.0, lane * ROOM], GAP]);
        curve.points.extend(room.into_iter().flatten());
        lane -= 1.0;
        let opacity = Record::surface(fragment.depth, fragment.data).rgba[3];
        let ends = [near_end(fragment), fragment.depth].map(place);
        curve.rectangle(ends, [lane, lane + HIGH * opacity]);
        curves.push(curve);
    }
    for (order, held) in &results {
        let Held::Records(records) = held else { return None };
        lane -= 1.0;
        let arrival: Vec<String> = order.iter().map(|&i| label(i).to_string()).collect();
        let mut curve = Curve::new(&format!("records, arrival {}", arrival.join(" ")));
        for record in &records.list {
            let near = nearest(&ends, record_near(record, &config.distances));
            curve.rectangle([near, record.depth].map(place), [lane, lane + HIGH * record.rgba[3]]);
        }
        curves.push(curve);
    }
    Some(Plot {
        title: format!("{} with k = {}: slabs and records", method.name(), config.k.unwrap_or(1)),
        x: "ends of slabs by depth, one after another (not to scale)",
        y: "slabs, and what they become",
        curves,
    })
}

/// The height of an opaque slab in its lane.
const HIGH: f64 = 0.9;

/// The height of all lanes with the room for their names.
const ROOM: f64 = 1.5;

/// A slab of no thickness has both ends in one place.
fn near_end(fragment: &Fragment) -> u32 {
    fragment.extra.min(fragment.depth)
}

/// The depth word of a record's near end, but for rounding: it knows its thickness in world units.
fn record_near(record: &Record, distances: &Distances) -> u32 {
    code(distances.planes.depth(distances.along(record.depth) - record.thickness))
}

/// The end that lies nearest.
fn nearest(ends: &[u32], depth: u32) -> u32 {
    ends.iter().copied().min_by_key(|end| end.abs_diff(depth)).unwrap_or(depth)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::catalogue;
    use crate::explore::program::litmus::Entry;

    fn names(method: &str, k: u32) -> Option<Vec<String>> {
        let subject = Subject::new(catalogue::method(method).unwrap()).unwrap();
        let slabs = [(200, 0x80FF_0000, 100), (300, 0x8000_FF00, 150), (400, 0x8000_00FF, 150)];
        let fragments = slabs.map(|(depth, data, thick)| Entry(0, depth, data, thick)).to_vec();
        let litmus = Litmus { k: Some(k), room: 3, fragments, ..Litmus::of_one(subject.contract) };
        let plot = super::slabs(&subject, &litmus)?;
        Some(plot.curves.into_iter().map(|curve| curve.name).collect())
    }

    /// With one record and a tail, the bridge may come too late; with room, or if all are kept, it cannot.
    #[test]
    fn every_result_is_drawn_once() {
        let slabs = ["A: slab", "B: slab", "C: slab"].map(str::to_owned);
        let one = [&slabs[..], &["records, arrival A B C".to_owned()]].concat();
        let two = [&one[..], &["records, arrival A C B".to_owned()]].concat();
        assert_eq!(names("skb+ofm", 2), Some(two));
        assert_eq!(names("skb+ofm", 3), Some(one.clone()));
        assert_eq!(names("dfb+ofm", 2), Some(one));
    }

    #[test]
    fn only_records_are_drawn() {
        assert_eq!(names("kplus-array", 2), None);
    }
}
