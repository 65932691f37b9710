//! The made-up pictures of `tests/metrics/ledger.txt`, with what other people's implementations say of them.
//! (`tests/metrics.rs` reads the cases that are drawn.)

use super::Image;

/// A case of the ledger.
pub(super) struct Case {
    pub(super) psnr: f64,
    pub(super) psnr_linear: f64,
    pub(super) ssim: f64,
    pub(super) flip: f64,
    pub(super) pictures: [Image; 2],
}

/// The cases that are made up.
pub(super) fn cases() -> Vec<Case> {
    let text = include_str!("../../tests/metrics/ledger.txt");
    let cases: Vec<Case> = text.lines().filter_map(case).collect();
    assert!(cases.len() >= 2, "the ledger has made-up pictures");
    cases
}

fn case(line: &str) -> Option<Case> {
    let [numbers, reference, picture] = line.split(" | ").collect::<Vec<_>>().try_into().ok()?;
    let pictures = [pattern(reference)?, pattern(picture)?];
    let mut numbers = numbers.split(' ').skip(1).map(|number| number.parse().unwrap());
    let mut next = || numbers.next().unwrap();
    let [psnr, psnr_linear, ssim, flip] = [next(), next(), next(), next()];
    Some(Case { psnr, psnr_linear, ssim, flip, pictures })
}

/// A slope, blocks, and something like noise: as `tests/metrics/check.py` has it.
fn pattern(text: &str) -> Option<Image> {
    let numbers = text.strip_prefix("pattern ")?.split(' ').map(|number| number.parse().unwrap());
    let [width, height, seed] = numbers.collect::<Vec<u32>>().try_into().unwrap();
    let pixel = |x: u32, y: u32| {
        let red = 5 * x + 40 * seed;
        let green = (x / (3 + seed) + y / 4) % 2 * (170 + seed);
        let blue = x * x + 3 * y * y + 7 * seed * x;
        [red as u8, green as u8, blue as u8, 255]
    };
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| pixel(x, y))).collect();
    Some(Image { width, height, pixels })
}
