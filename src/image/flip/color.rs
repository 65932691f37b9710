//! The colour spaces that FLIP goes through, all from linear sRGB.

/// From linear sRGB to XYZ, with the paper's white.
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// Its inverse.
const TO_RGB: [[f64; 3]; 3] = [
    [3.241_003_275, -1.537_398_934, -0.498_615_861],
    [-0.969_224_334, 1.875_930_071, 0.041_554_224],
    [0.055_639_423, -0.204_011_202, 1.057_148_933],
];

/// XYZ of white, RGB (1, 1, 1).
const WHITE: [f64; 3] = [
    (10_135_552.0 + 8_788_810.0 + 4_435_075.0) / 24_577_794.0,
    1.0,
    (1_425_312.0 + 8_788_810.0 + 70_074_185.0) / 73_733_382.0,
];

fn times(matrix: &[[f64; 3]; 3], [x, y, z]: [f64; 3]) -> [f64; 3] {
    matrix.map(|[a, b, c]| (a * x + b * y) + c * z)
}

/// XYZ of linear RGB, each channel as a part of white.
pub(super) fn xyz(rgb: [f64; 3]) -> [f64; 3] {
    let xyz = times(&TO_XYZ, rgb);
    std::array::from_fn(|c| xyz[c] / WHITE[c])
}

/// `YCxCz`.
pub(super) fn opponent([x, y, z]: [f64; 3]) -> [f64; 3] {
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Linear RGB of `YCxCz`.
pub(super) fn rgb([y, cx, cz]: [f64; 3]) -> [f64; 3] {
    let y = (y + 16.0) / 116.0;
    let parts = [y + cx / 500.0, y, y - cz / 200.0];
    times(&TO_RGB, std::array::from_fn(|c| parts[c] * WHITE[c]))
}

/// L\*a\*b\*.
pub(super) fn lab(xyz: [f64; 3]) -> [f64; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let root = |part: f64| {
        if part > DELTA * DELTA * DELTA {
            libm::cbrt(part)
        } else {
            part / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    };
    let [x, y, z] = xyz.map(root);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// Chroma as strong as it looks at that lightness.
pub(super) fn hunt([lightness, a, b]: [f64; 3]) -> [f64; 3] {
    [lightness, 0.01 * lightness * a, 0.01 * lightness * b]
}

pub(super) fn hyab(p: [f64; 3], q: [f64; 3]) -> f64 {
    let [l, a, b]: [f64; 3] = std::array::from_fn(|c| p[c] - q[c]);
    l.abs() + (a * a + b * b).sqrt()
}
