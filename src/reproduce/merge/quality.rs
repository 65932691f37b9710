//! Figures 10 and 11: how near pictures with 8 records a pixel come to the one with all fragments.

use super::coplanar::blended;
use super::{DFB, How, MARKS, MBT, Measured, SKB, apart, columns, load, percent, viewer};
use crate::error::Result;
use crate::image::heat::Map;
use crate::image::{Image, row};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scene::{self, Overrides, Scene, Thickness};

/// A scene of the paper with its largest and mean depth, and ours of the same kind.
pub(super) struct Setting {
    pub(super) name: &'static str,
    ours: &'static str,
    alpha: f32,
    printed: [u32; 2],
}

pub(super) const SETTINGS: [Setting; 3] = [
    Setting { name: "greenhouse (sports car)", ours: "greenhouse", alpha: 0.1, printed: [131, 10] },
    Setting {
        name: "hairball",
        ours: "hairball:strands=1500,radius=0.008",
        alpha: 0.1,
        printed: [52, 42],
    },
    Setting {
        name: "surfels (floor points)",
        ours: "surfels:shape=sheets,sheets=8,count=120,radius=0.25,jitter=0.012",
        alpha: 0.1,
        printed: [73, 14],
    },
];

impl Setting {
    pub(super) fn scene(&self, edge: u32) -> Result<Scene> {
        let overrides =
            Overrides { size: Some([edge; 2]), alpha: Some(self.alpha), ..Overrides::default() };
        Ok(viewer(scene::load(self.ours, &overrides)?))
    }
}

/// The paper's thickness for large differences.
pub(super) const HUNDREDFOLD: Thickness = Thickness::Precision(100.0);

/// Figure 10: error maps.
pub(in crate::reproduce) fn errors(scale: &Scale) -> Result<Outcome> {
    let (mut rows, mut pictures, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    let hows = [
        SKB,
        // No slab overlaps: what a tail alone is good for.
        How::merging("skb+ofm", Thickness::World(0.0)),
        How::merging("skb+ofm", HUNDREDFOLD),
        How::merging("dfb+sfm", HUNDREDFOLD),
        MBT,
    ];
    let mut moments = Vec::new();
    for setting in &SETTINGS {
        let scene = setting.scene(scale.edge)?;
        let exact = DFB.measure(&scene, scale)?;
        let report = &exact.drawn.report;
        let [deepest, mean] = setting.printed;
        let depth = format!("{} ({deepest})", report.max_depth_complexity);
        let covered = exact.drawn.lists()?.offsets.windows(2).filter(|o| o[0] < o[1]).count();
        let layers = format!("{:.1} ({mean})", report.generated as f64 / covered.max(1) as f64);
        let mut all = Vec::new();
        for how in hows {
            all.push(how.measure(&scene, scale)?);
        }
        for measured in std::iter::once(&exact).chain(&all) {
            let mut cells = vec![setting.name.to_owned(), depth.clone(), layers.clone()];
            cells.extend(measured.cells(exact.image())?);
            rows.push(cells);
        }
        let [plain, tail, merged, smooth] = [0, 1, 2, 3].map(|i: usize| all[i].psnr(exact.image()));
        let (plain, tail, merged, smooth) = (plain?, tail?, merged?, smooth?);
        if !(smooth > merged && merged > plain) {
            wrong.push(format!(
                "{}: {plain:.2} dB with kplus-array, {merged:.2} with skb+ofm ({tail:.2} by its tail alone), {smooth:.2} \
                 with dfb+sfm",
                setting.name
            ));
        }
        let name = setting.name;
        moments.push(format!("{name} {:.2} dB", all[4].psnr(exact.image())?));
        let short = setting.name.split(' ').next().unwrap_or(setting.name);
        let chosen = [&all[0], &all[2], &all[3], &all[4]];
        let mut images = vec![("all fragments".to_owned(), exact.image().clone())];
        images.extend(chosen.map(|m| (m.how.caption(), m.image().clone())));
        let images: Vec<_> = images.iter().map(|(name, image)| (name.as_str(), image)).collect();
        pictures.push((short.to_owned(), row::compose(setting.name, &images)));
        for (i, map) in maps(&exact, &chosen).into_iter().enumerate() {
            pictures.push((format!("{short}-error-{}", chosen[i].how.method), map));
        }
    }
    let summary = format!(
        "distance to the picture with all fragments, with 8 records a pixel, at {0}x{0}; depths are the largest and the \
         mean of covered pixels, the paper's in brackets; moments: {1}",
        scale.edge,
        moments.join(", ")
    );
    let columns = columns(&["scene", "depth (paper)", "mean depth (paper)"], &[]);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, pictures, verdict, ..Outcome::new("merge-fig10", summary) })
}

/// Their errors with one scale.
fn maps(exact: &Measured, all: &[&Measured]) -> Vec<Image> {
    let errors = |m: &Measured| -> Vec<f64> {
        let pairs = exact.image().pixels.iter().zip(&m.image().pixels);
        pairs.map(|(p, q)| f64::from(apart(*p, *q))).collect()
    };
    let values: Vec<Vec<f64>> = all.iter().map(|m| errors(m)).collect();
    let most = values.iter().flatten().copied().fold(1.0, f64::max);
    let size = [exact.image().width, exact.image().height];
    let meaning = "largest difference of a channel to all fragments, of 255";
    let draw = |(m, values): (&&Measured, &Vec<f64>)| {
        Map { title: &m.how.caption(), meaning, size, values, most }.draw()
    };
    all.iter().zip(&values).map(draw).collect()
}

/// What is seen as another colour, of 255.
const BOUND: u8 = 16;

/// Figure 11: plates with marks in a ball of surfels.
pub(in crate::reproduce) fn marks(scale: &Scale) -> Result<Outcome> {
    let scene = viewer(load(MARKS, scale.edge)?);
    let right = blended(&scene)?;
    // Records do not say what they came from, so colours decide, where a plate or a mark should show through.
    let seen: Vec<bool> =
        right.stacks.iter().map(|stack| stack.iter().any(|face| face.0 < 3)).collect();
    let twice = Thickness::Precision(2.0);
    let hows = [
        DFB,
        SKB,
        How::merging("skb+ofm", Thickness::World(0.0)),
        How::merging("skb+ofm", twice),
        How::merging("skb+ofm", HUNDREDFOLD),
        How::merging("dfb+sfm", twice),
        MBT,
    ];
    let (mut rows, mut all, mut shares) = (Vec::new(), Vec::new(), Vec::new());
    for how in hows {
        let measured = how.measure(&scene, scale)?;
        let share = |only_coplanar: bool| {
            let pixels = right.image.pixels.iter().zip(&measured.image().pixels).enumerate();
            let chosen = pixels.filter(|(i, _)| seen[*i] && (!only_coplanar || right.coplanar[*i]));
            let (mut some, mut all) = (0, 0);
            for (_, (p, q)) in chosen {
                all += 1;
                some += usize::from(apart(*p, *q) > BOUND);
            }
            percent(some, all)
        };
        let mut cells = measured.cells(&right.image)?;
        cells.extend([share(false), share(true)].map(|share| format!("{share:.2}")));
        rows.push(cells);
        shares.push(share(false));
        all.push(measured);
    }
    let mut wrong = Vec::new();
    if shares[3] >= shares[1] || shares[3] >= shares[6] {
        wrong.push(format!(
            "{:.2} % of the pixels are wrong with skb+ofm at 2x ({:.2} % by its tail alone, {:.2} % at 100x), {:.2} % with \
             kplus-array, {:.2} % with mbt",
            shares[3], shares[2], shares[4], shares[1], shares[6]
        ));
    }
    let captions: Vec<String> = all.iter().map(|m| m.how.caption()).collect();
    let mut images: Vec<(&str, &Image)> =
        captions.iter().map(String::as_str).zip(all.iter().map(Measured::image)).collect();
    images.remove(2);
    images.push(("planes mixed", &right.image));
    let picture = row::compose("plates and marks in a ball of surfels", &images);
    let summary = format!(
        "of the pixels where plates or marks lie, those that differ by more than {BOUND} of 255 from all fragments with \
         coplanar faces mixed; records do not say which object they came from"
    );
    let columns = columns(&[], &["wrong (%)", "wrong on marks (%)"]);
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome {
        columns,
        rows,
        pictures: vec![("methods".to_owned(), picture)],
        verdict,
        ..Outcome::new("merge-fig11", summary)
    })
}
