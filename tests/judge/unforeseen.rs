//! Faults that no hypothesis was made for: they are called unexplained, or something near, and never right.

use fragloom::image::Image;
use fragloom::judge::{Answer, Class, Verdict};
use fragloom::num::random::Random;
use fragloom::render::render;

use super::confusion::{cases, exact, main_class, verdict};
use super::wrong::{changed, painted};

/// How many pixels have a class.
fn pixels(verdict: &Verdict, class: Class) -> u64 {
    verdict.classes.iter().find(|count| count.class == class).map_or(0, |count| count.pixels)
}

/// A block is painted over.
#[test]
fn what_is_painted_over_is_unexplained() {
    for case in cases() {
        let answer = Answer::new(&case.scene, &exact()).expect("an answer");
        let mut image = answer.picture().clone();
        let mut inside = Vec::new();
        for y in 10..30 {
            for x in 12..40 {
                let place = (y * image.width + x) as usize;
                image.pixels[place] = [255, 0, 200 + (x % 8) as u8, 255];
                inside.push(place);
            }
        }
        let found = verdict(&answer, &image);
        assert!(!found.right && found.hypothesis.is_none(), "{}", case.name);
        let told = inside.iter().filter(|&&p| found.map[p] == Class::Unexplained).count();
        assert!(10 * told >= 9 * inside.len(), "{}: {told} of {}", case.name, inside.len());
        let others = (0..found.map.len()).filter(|p| !inside.contains(p));
        assert!(others.map(|p| found.map[p]).all(Class::is_right), "{}", case.name);
    }
}

/// Green and blue exchanged: red and blue is what is tried.
#[test]
fn exchanged_channels_are_not_right() {
    for case in cases() {
        let answer = Answer::new(&case.scene, &exact()).expect("an answer");
        let mut image = answer.picture().clone();
        image.pixels.iter_mut().for_each(|pixel| pixel.swap(1, 2));
        let found = verdict(&answer, &image);
        if found.metrics.pixels_beyond == 0 {
            continue;
        }
        assert!(!found.right, "{}", case.name);
        assert!(found.hypothesis.is_none(), "{}: {:?}", case.name, found.hypothesis);
        // Hairs are thinner than a pixel: edges pass through all of theirs.
        let classes = [Class::Unexplained, Class::Partial, Class::Faint];
        let told: u64 = classes.into_iter().map(|class| pixels(&found, class)).sum();
        assert!(2 * told > found.metrics.pixels_beyond, "{}: {:?}", case.name, found.classes);
    }
}

/// Seen from elsewhere.
#[test]
fn another_camera_is_not_right() {
    for name in ["cubes", "hairball"] {
        let case = cases().into_iter().find(|case| case.name == name).expect("a scene");
        let answer = Answer::new(&case.scene, &exact()).expect("an answer");
        let mut scene = case.scene.clone();
        scene.camera.eye += glam::DVec3::new(0.3, 0.2, 0.0) * scene.camera.near;
        let image = render(&scene, &exact()).expect("a picture").image;
        let found = verdict(&answer, &image);
        assert!(!found.right && found.hypothesis.is_none(), "{name}: {:?}", found.hypothesis);
        println!("{name}: {:?}", found.classes);
    }
}

/// Single pixels of another colour.
#[test]
fn sparse_noise_is_unexplained() {
    let mut random = Random::new(1, 2);
    for case in cases() {
        let answer = Answer::new(&case.scene, &exact()).expect("an answer");
        let mut image = answer.picture().clone();
        let mut places = Vec::new();
        for place in 0..image.pixels.len() {
            if random.below(40) == 0 {
                let pixel = &mut image.pixels[place];
                for (c, by) in [(0, 23), (1, 31), (2, 27)] {
                    let up = (random.below(2) == 0 && pixel[c] < 220) || pixel[c] < 40;
                    pixel[c] = if up { pixel[c] + by } else { pixel[c] - by };
                }
                places.push(place);
            }
        }
        let found = verdict(&answer, &image);
        assert!(!found.right && found.hypothesis.is_none(), "{}", case.name);
        let told = places.iter().filter(|&&p| found.map[p] == Class::Unexplained).count();
        assert!(10 * told >= 8 * places.len(), "{}: {:?}", case.name, found.classes);
    }
}

/// A blurred picture has edges that lie between both sides, and more.
#[test]
fn a_blurred_picture_is_not_right() {
    for case in cases() {
        let answer = Answer::new(&case.scene, &exact()).expect("an answer");
        let exact = answer.picture();
        let (w, h) = (exact.width, exact.height);
        let mut image = Image::filled(w, h, [0, 0, 0, 255]);
        for y in 0..h {
            for x in 0..w {
                for c in 0..3 {
                    let mut sum = 0;
                    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
                        let [nx, ny] = [(x + dx).min(w - 1), (y + dy).min(h - 1)];
                        sum += u32::from(exact.pixel(nx, ny)[c]);
                    }
                    image.pixels[(y * w + x) as usize][c] = (sum / 4) as u8;
                }
            }
        }
        let found = verdict(&answer, &image);
        assert!(!found.right, "{}", case.name);
    }
}

/// An explanation that is made to break everywhere is not given: the same kinds of pictures with a channel off by more.
#[test]
fn broken_explanations_are_not_given() {
    let case = cases().into_iter().find(|case| case.name == "shuffled").expect("a scene");
    let answer = Answer::new(&case.scene, &exact()).expect("an answer");
    let broken: Vec<(&str, Image)> = vec![
        ("nearest 2", changed(&answer, &case.scene, &|list| list.truncate(2))),
        ("reversed", changed(&answer, &case.scene, &|list| list.reverse())),
        (
            "black",
            painted(&answer, &case.scene, &|list, _| {
                super::wrong::seen(super::wrong::over(list, [0.0; 3]))
            }),
        ),
        (
            "sRGB",
            painted(&answer, &case.scene, &|list, background| {
                let mut out = background.map(super::wrong::encode);
                for entry in list.iter().rev() {
                    let (c, a) = super::wrong::color(entry);
                    for i in 0..3 {
                        out[i] = super::wrong::encode(c[i]) * a + out[i] * (1.0 - a);
                    }
                }
                out.map(super::wrong::byte)
            }),
        ),
    ];
    for (name, image) in broken {
        let whole = verdict(&answer, &image);
        assert!(whole.hypothesis.is_some(), "{name} as it is");
        let class = main_class(&whole);
        let mut image = image;
        for (place, pixel) in image.pixels.iter_mut().enumerate() {
            if !whole.map[place].is_right() {
                let c = place % 3;
                pixel[c] = if pixel[c] < 128 { pixel[c] + 40 } else { pixel[c] - 40 };
            }
        }
        let found = verdict(&answer, &image);
        assert!(found.hypothesis.is_none() && !found.right, "{name}: {:?}", found.hypothesis);
        assert_ne!(main_class(&found), class, "{name}");
    }
}
