//! What all drawn pictures have in common: colours on light and on dark paper, letters, margins.
//!
//! Colours are named by what they are for. A PNG is drawn on light paper; an SVG says both, and its viewer chooses by
//! `prefers-color-scheme`.

/// The size of letters, in units: those of an SVG. A picture has two pixels for each.
pub(crate) const LETTER: [f64; 2] = [8.0, 13.0];

/// From one line of letters to the next.
pub(crate) const LINE: f64 = 18.0;

/// Around everything.
pub(crate) const MARGIN: f64 = 20.0;

/// The fonts of an SVG: letters of equal widths, since those of a picture are.
pub(super) const FONTS: &str = "ui-monospace, 'DejaVu Sans Mono', Menlo, Consolas, monospace";

/// Light paper, and what is on it.
pub(crate) const PAPER: [u8; 3] = [250, 250, 248];
pub(crate) const INK: [u8; 3] = [28, 28, 32];
pub(crate) const QUIET: [u8; 3] = [96, 96, 104];
pub(crate) const FRAME: [u8; 3] = [150, 150, 156];

/// What a colour is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Ink {
    /// The background of everything.
    Paper,
    /// Letters.
    Text,
    /// Letters that matter less, and frames.
    Quiet,
    /// Thin lines that help the eye.
    Rule,
    /// A wide curve beneath others.
    Beneath,
    /// The background of a box.
    Panel,
    /// What is wrong.
    Fault,
    /// The background of what is wrong.
    FaultPanel,
    /// One of the things that are told apart by colour, by its number.
    Series(usize),
    /// The background of a box that belongs to it.
    SeriesPanel(usize),
}

/// How many colours tell things apart.
pub(crate) const SERIES: usize = 7;

/// Colours that most eyes can distinguish (Okabe, Ito 2008), without the yellow; and the same hues for dark paper.
const COLORS: [[[u8; 3]; SERIES]; 2] = [
    [
        [0, 114, 178],
        [213, 94, 0],
        [0, 158, 115],
        [204, 121, 167],
        [0, 0, 0],
        [86, 180, 233],
        [230, 159, 0],
    ],
    [
        [60, 150, 214],
        [240, 120, 40],
        [30, 184, 140],
        [226, 156, 194],
        [240, 240, 240],
        [140, 208, 248],
        [244, 186, 70],
    ],
];

impl Ink {
    /// The colour on light paper, or on dark.
    pub(crate) fn color(self, dark: bool) -> [u8; 3] {
        let choose = |light, on_dark| if dark { on_dark } else { light };
        match self {
            Self::Paper => choose(PAPER, [24, 24, 27]),
            Self::Text => choose(INK, [236, 236, 232]),
            Self::Quiet => choose(QUIET, [168, 168, 174]),
            Self::Rule => choose([221; 3], [62, 62, 68]),
            Self::Beneath => choose([190; 3], [96, 96, 102]),
            Self::Panel => choose([239, 239, 236], [38, 38, 43]),
            Self::Fault => choose([176, 0, 32], [255, 128, 128]),
            Self::FaultPanel => choose([253, 228, 230], [74, 26, 32]),
            Self::Series(number) => COLORS[usize::from(dark)][number % SERIES],
            Self::SeriesPanel(number) => {
                let (color, paper) = (Self::Series(number).color(dark), Self::Paper.color(dark));
                let parts = if dark { 28 } else { 15 };
                let mix = |i: usize| {
                    (u32::from(color[i]) * parts + u32::from(paper[i]) * (100 - parts)) / 100
                };
                std::array::from_fn(|i| mix(i) as u8)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::num::color::linear_of;

    fn light([r, g, b]: [f64; 3]) -> f64 {
        0.2126 * r + 0.7152 * g + 0.0722 * b
    }

    fn decoded(ink: Ink, dark: bool) -> [f64; 3] {
        ink.color(dark).map(linear_of)
    }

    /// As the web's rules for accessible content define it.
    fn contrast(a: Ink, b: Ink, dark: bool) -> f64 {
        let [a, b] = [a, b].map(|ink| light(decoded(ink, dark)) + 0.05);
        a.max(b) / a.min(b)
    }

    #[test]
    fn letters_can_be_read_on_every_background_they_stand_on() {
        for dark in [false, true] {
            let panels = (0..SERIES).map(Ink::SeriesPanel);
            for paper in [Ink::Paper, Ink::Panel, Ink::FaultPanel].into_iter().chain(panels) {
                assert!(contrast(Ink::Text, paper, dark) >= 6.0, "{paper:?} {dark}");
            }
            for paper in [Ink::Paper, Ink::Panel, Ink::FaultPanel] {
                for ink in [Ink::Quiet, Ink::Fault] {
                    let found = contrast(ink, paper, dark);
                    assert!(found >= 4.5, "{ink:?} on {paper:?}, dark {dark}: {found}");
                }
            }
        }
    }

    /// How the colours look to eyes without one kind of cones (Machado, Oliveira, Fernandes 2009, severity 1), in linear
    /// light.
    const EYES: [[[f64; 3]; 3]; 4] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ],
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ],
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ],
    ];

    fn seen(color: [f64; 3], eye: &[[f64; 3]; 3]) -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|j| eye[i][j] * color[j]).sum())
    }

    fn nearest(colors: &[[f64; 3]]) -> f64 {
        let mut nearest = f64::MAX;
        for eye in &EYES {
            for (i, a) in colors.iter().enumerate() {
                for b in &colors[..i] {
                    let [a, b] = [seen(*a, eye), seen(*b, eye)];
                    let far = (0..3).map(|c| (a[c] - b[c]) * (a[c] - b[c])).sum::<f64>();
                    nearest = nearest.min(far.sqrt());
                }
            }
        }
        nearest
    }

    #[test]
    fn series_are_told_apart_by_most_eyes() {
        for dark in [false, true] {
            let colors: Vec<_> = (0..SERIES).map(|i| decoded(Ink::Series(i), dark)).collect();
            let found = nearest(&colors);
            assert!(found > 0.09, "dark {dark}: {found}");
        }
        // Negative control: red and green of equal lightness.
        let traffic = [[200, 60, 40], [110, 110, 30]].map(|color: [u8; 3]| color.map(linear_of));
        assert!(nearest(&traffic) < 0.09, "{}", nearest(&traffic));
    }
}
