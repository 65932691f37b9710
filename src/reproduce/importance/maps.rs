//! Figures 2 and 4: importance, and what it gives each pixel, as maps.

use super::{SETTINGS, measure, options};
use crate::error::Result;
use crate::image::heat::Map;
use crate::render::{Factors, Importance, Options, fresnel, render};
use crate::reproduce::{Outcome, Scale, Verdict};
use crate::scheme::kplus_buffer::k_variable::ONE;

/// Figure 2: how many records each method has for each pixel, beside how many fragments there are.
pub(in crate::reproduce) fn allocation(scale: &Scale) -> Result<Outcome> {
    let setting = &SETTINGS[2];
    let scene = setting.scene(scale)?;
    let pixels = u64::from(scale.edge) * u64::from(scale.edge);
    let records = u64::from(setting.k) * pixels;
    let (_, all) = measure(&scene, records, 1)?;
    let [fixed, dynamic, variable] = [&all[0].drawn, &all[1].drawn, &all[2].drawn];
    let shares = variable.shares.clone().unwrap_or_default();
    let real = |words: &[u32]| words.iter().map(|&word| f64::from(word)).collect::<Vec<f64>>();
    let most = f64::from(fixed.report.max_depth_complexity.max(1));
    let (low, high) = (fixed.report.k.unwrap_or(1), dynamic.report.k.unwrap_or(1));
    let lengths: Vec<u32> = shares.fragments.iter().map(|&n| n.min(high)).collect();
    let chosen = [
        ("fragments", "fragments of a pixel", real(&shares.fragments), most),
        ("fixed", "records of a pixel, fixed k", vec![f64::from(low); pixels as usize], most),
        ("dynamic", "records of a pixel, k by histogram", real(&lengths), most),
        ("variable", "records of a pixel, k by importance", real(&shares.k), most),
        (
            "importance",
            "importance",
            shares.importance.iter().map(|&q| f64::from(q) / f64::from(ONE)).collect(),
            1.0,
        ),
    ];
    let (mut rows, mut pictures, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    for (name, meaning, values, most) in chosen {
        let sum: f64 = values.iter().sum();
        let largest = values.iter().copied().fold(0.0, f64::max);
        rows.push(vec![name.to_owned(), format!("{largest:.2}"), format!("{sum:.0}")]);
        let takes_records = ["fixed", "dynamic", "variable"].contains(&name);
        if takes_records && sum > records as f64 {
            wrong.push(format!("{name} k takes {sum} records of {records}"));
        }
        let title = format!("{name} \u{b7} {}", setting.name);
        let map = Map { title: &title, meaning, size: scene.size, values: &values, most }.draw();
        pictures.push((name.to_owned(), map));
    }
    let k =
        [u64::from(low), u64::from(high), u64::from(shares.k.iter().copied().max().unwrap_or(0))];
    if !(k[0] <= k[1] && k[1] < k[2]) {
        wrong.push(format!("the largest k is {} fixed, {} dynamic, {} variable", k[0], k[1], k[2]));
    }
    let summary = format!(
        "what three methods give each pixel of {records} records; a fixed k gives empty pixels as many"
    );
    let columns = vec!["map", "largest", "sum"];
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, pictures, verdict, ..Outcome::new("varik-fig2", summary) })
}

/// Figure 4: the three factors and their combination.
pub(in crate::reproduce) fn factors(scale: &Scale) -> Result<Outcome> {
    let setting = &SETTINGS[2];
    let scene = setting.scene(scale)?;
    let size = scene.size;
    let base = options("k-variable")?;
    let before = fresnel(&scene, &base);
    let all = Importance { fresnel: Some((size, before)), ..Importance::default() };
    let only = |factors: Factors| Importance { factors, ..all.clone() };
    let none = Factors { depth: false, periphery: false, fresnel: false, map: false, noise: false };
    let corner = f64::from(scale.edge) * 0.125;
    let gazing =
        Importance { gaze: Some([corner, corner]), ..only(Factors { periphery: true, ..none }) };
    let chosen = [
        ("depth", only(Factors { depth: true, ..none })),
        ("periphery", only(Factors { periphery: true, ..none })),
        ("periphery-gaze", gazing),
        ("fresnel", only(Factors { fresnel: true, ..none })),
        ("importance", all.clone()),
    ];
    let (mut rows, mut pictures, mut wrong) = (Vec::new(), Vec::new(), Vec::new());
    let mut peaks = Vec::new();
    for (factor, importance) in chosen {
        let noisy = importance.factors.noise;
        let drawn = render(&scene, &Options { importance, k: Some(setting.k), ..base.clone() })?;
        let shares = drawn.shares.unwrap_or_default();
        let values: Vec<f64> =
            shares.importance.iter().map(|&q| f64::from(q) / f64::from(ONE)).collect();
        let (mut most, mut sum, mut peak) = (0.0f64, 0.0, 0);
        for (i, &value) in values.iter().enumerate() {
            sum += value;
            if value > most {
                (most, peak) = (value, i);
            }
        }
        peaks.push([peak as u32 % size[0], peak as u32 / size[0]]);
        let least = values.iter().copied().filter(|&v| v > 0.0).fold(1.0, f64::min);
        rows.push(vec![
            factor.to_owned(),
            format!("{least:.3}"),
            format!("{most:.3}"),
            format!("{:.3}", sum / values.len().max(1) as f64),
            format!("{},{}", peak as u32 % size[0], peak as u32 / size[0]),
        ]);
        // Noise is added to the product.
        let limit = if noisy { 1.05 } else { 1.0 };
        if most > limit {
            wrong.push(format!("{factor} reaches {most:.3}"));
        }
        let title = format!("{factor} \u{b7} {}", setting.name);
        let meaning = "pixels without fragments have none";
        let map = Map { title: &title, meaning, size, values: &values, most: 1.0 }.draw();
        pictures.push((factor.to_owned(), map));
    }
    let middle = f64::from(scale.edge) * 0.5;
    let apart = |[x, y]: [u32; 2], at: f64| {
        let (dx, dy) = (f64::from(x) - at, f64::from(y) - at);
        dx * dx + dy * dy
    };
    if apart(peaks[2], corner) >= apart(peaks[1], corner)
        || apart(peaks[1], middle) > apart(peaks[2], middle)
    {
        wrong.push("a gaze does not move the peak".to_owned());
    }
    let first = render(&scene, &base)?.report.importance;
    if first.is_none_or(|i| i.fresnel_known) {
        wrong.push("the Fresnel term of a first frame is known".to_owned());
    }
    let summary =
        "each factor alone and all together; the Fresnel term is the frame before's".to_owned();
    let columns = vec!["factor", "smallest above 0", "largest", "mean", "peak (x,y)"];
    let verdict = Some(Verdict::of(&wrong));
    Ok(Outcome { columns, rows, pictures, verdict, ..Outcome::new("varik-fig4", summary) })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: Scale = Scale { edge: 64, repeats: 1 };

    #[test]
    fn a_gaze_and_a_first_frame_are_as_said() {
        let outcome = factors(&SMALL).unwrap();
        assert!(outcome.verdict.unwrap().as_in_the_paper, "{:?}", outcome.rows);
    }

    #[test]
    fn nobody_takes_more_than_there_is() {
        let outcome = allocation(&SMALL).unwrap();
        let verdict = outcome.verdict.unwrap();
        assert!(!verdict.how.contains("takes"), "{verdict}");
        assert_eq!(outcome.pictures.len(), outcome.rows.len());
    }
}
