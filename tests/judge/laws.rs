//! What holds for any picture.

use fragloom::image::Image;
use fragloom::judge::{Answer, Class, Settings, compare, map};
use fragloom::num::ray::Ray;
use fragloom::render::Data;
use fragloom::render::Options;
use proptest::prelude::*;

use super::confusion::{cases, exact, verdict};
use super::support::{draw, lists, options, scene};
use super::wrong::changed;

/// The lists are those of the exact method, whatever its word; and the picture is theirs.
#[test]
fn the_answer_is_the_exact_method() {
    for case in cases() {
        for k in [None, Some(2)] {
            let own = Options { k, ..exact() };
            let answer = Answer::new(&case.scene, &own).expect("an answer");
            let drawn = draw(&case.scene, &own);
            assert_eq!(*answer.picture(), drawn.image, "{}", case.name);
            let all = lists(&case.scene, &exact());
            let triangles = lists(&case.scene, &Options { data: Data::Primitive, ..exact() });
            assert_eq!(answer.lists().offsets, all.offsets);
            let keys = answer.lists().entries.iter();
            let colors = keys.clone().map(|e| u64::from(e.depth) << 32 | u64::from(e.color));
            assert!(colors.eq(all.entries.iter().copied()), "{}", case.name);
            for y in 0..case.scene.size[1] {
                for x in 0..case.scene.size[0] {
                    let mut own: Vec<u64> = answer
                        .lists()
                        .pixel(x, y)
                        .iter()
                        .map(|e| u64::from(e.depth) << 32 | u64::from(e.triangle))
                        .collect();
                    own.sort_unstable();
                    assert_eq!(own, triangles.pixel(x, y), "{}", case.name);
                }
            }
            let background = case.scene.background.map(fragloom::num::color::word16);
            let mut ray = Ray::default();
            let list = answer.lists().pixel(20, 20);
            list.iter().take(k.unwrap_or(999) as usize).for_each(|e| ray.over(e.color));
            assert_eq!(ray.finish(background), answer.picture().pixel(20, 20), "{}", case.name);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Any picture within the tolerance is right.
    #[test]
    fn within_the_tolerance_is_right(seed in any::<u64>(), tolerance in 0_u8..4) {
        let scene = scene("synthetic:n=6,tessellation=2", [24, 16]);
        let answer = Answer::new(&scene, &exact()).expect("an answer");
        let mut random = fragloom::num::random::Random::new(seed, 0);
        let mut image = answer.picture().clone();
        for c in image.pixels.iter_mut().flat_map(|pixel| &mut pixel[..3]) {
            let by = random.below(2 * u64::from(tolerance) + 1) as i16 - i16::from(tolerance);
            *c = (i16::from(*c) + by).clamp(0, 255) as u8;
        }
        let settings = Settings { tolerance, ..Settings::default() };
        let foreign = super::confusion::foreign(&image);
        let found = fragloom::judge::judge(&answer, &foreign, "a", &settings).expect("a verdict");
        prop_assert!(found.right);
        prop_assert_eq!(found.metrics.pixels_beyond, 0);
    }

    /// The order of runs does not show, and equal runs do not differ.
    #[test]
    fn any_order_of_runs_gives_the_same(seed in any::<u64>()) {
        let scene = scene("synthetic:n=6,tessellation=2", [24, 16]);
        let answer = Answer::new(&scene, &exact()).expect("an answer");
        let mut random = fragloom::num::random::Random::new(seed, 0);
        let mut images = vec![
            changed(&answer, &scene, &|list| list.truncate(1)),
            changed(&answer, &scene, &|list| list.reverse()),
            answer.picture().clone(),
        ];
        let mut noisy = answer.picture().clone();
        for pixel in &mut noisy.pixels {
            pixel[1] = pixel[1].wrapping_add(random.below(5) as u8);
        }
        images.push(noisy);
        let judged = |images: &[Image]| {
            let verdicts: Vec<_> = images.iter().map(|image| verdict(&answer, image)).collect();
            compare(&answer, &verdicts, &Settings::default())
        };
        let first = judged(&images);
        for i in (1..images.len()).rev() {
            images.swap(i, random.below(i as u64 + 1) as usize);
        }
        let second = judged(&images);
        prop_assert_eq!(&first.map, &second.map);
        prop_assert_eq!(&first.classes, &second.classes);
        prop_assert_eq!(first.places, second.places);
        let size = scene.size;
        prop_assert_eq!(map("a", size, &first.map), map("a", size, &second.map));
        let same = judged(&[images[0].clone(), images[0].clone()]);
        prop_assert_eq!(same.pixels_different, 0);
        prop_assert!(same.map.iter().all(|class| *class == Class::Equal));
    }
}

/// With k, what is farther does not count; a picture with all fragments is named.
#[test]
fn the_answer_may_keep_k() {
    let scene = scene("synthetic:n=14,tessellation=3", [48, 36]);
    let own = options("exact", Some(3));
    let answer = Answer::new(&scene, &own).expect("an answer");
    let right = changed(&answer, &scene, &|list| list.truncate(3));
    assert!(verdict(&answer, &right).right);
    let all = changed(&answer, &scene, &|_| ());
    let found = verdict(&answer, &all);
    let held = found.hypothesis.expect("a hypothesis");
    assert_eq!(held.class, Class::BeyondK, "{held:?}");
    // Two runs, of which one keeps more: all that differs lies where there are more than k.
    let runs =
        compare(&answer, &[verdict(&answer, &right), verdict(&answer, &all)], &Settings::default());
    assert!(runs.pixels_beyond > 0);
    assert_eq!(runs.places.deeper_than_k, Some(runs.pixels_beyond));
}

/// Any number of threads gives the same verdict.
#[test]
fn threads_do_not_show() {
    let case = &cases()[0];
    let answer = Answer::new(&case.scene, &exact()).expect("an answer");
    let gone = super::wrong::most_seen(&answer, &case.scene)[0];
    let image = changed(&answer, &case.scene, &|list| {
        list.retain(|e| e.triangle != gone);
        list.truncate(5);
    });
    let judged = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let found = verdict(&answer, &image);
            (serde_json::to_string(&found).expect("a document"), found.map)
        })
    };
    let first = judged(1);
    assert_eq!(judged(2), first);
    assert_eq!(judged(7), first);
}
