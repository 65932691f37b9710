//! What was found, for people.

use super::Document;
use crate::judge::dump::{DumpVerdict, Odd};
use crate::judge::{Counted, Culprit, Held, Runs, Verdict};
use crate::report::text::{Align, columns, percent, thousands};

/// All of it.
pub(super) fn table(document: &Document) -> String {
    let Document { scene, width, height, k, .. } = document;
    let kept = k.map_or("all of them".to_owned(), |k| format!("the nearest {k} of a pixel"));
    let mut text = format!(
        "{scene} at {width}x{height}, {} fragments, {kept}; tolerance {}\n",
        thousands(document.fragments),
        document.tolerance
    );
    document.pictures.iter().for_each(|verdict| text += &picture(verdict));
    document.dumps.iter().for_each(|verdict| text += &dump(verdict));
    document.runs.iter().for_each(|found| text += &runs(found));
    text.push('\n');
    text += &last(document);
    text
}

/// The last line.
pub(super) fn last(document: &Document) -> String {
    let exceeded: Vec<String> = document
        .exceeded
        .iter()
        .map(|own| {
            let (pixels, allowed) = (thousands(own.pixels), thousands(own.allowed));
            format!("{}: {pixels} pixels {}, {allowed} allowed", own.of, own.class.name())
        })
        .collect();
    let right =
        document.pictures.iter().all(|own| own.right) && document.dumps.iter().all(|own| own.right);
    match (exceeded.is_empty(), right) {
        (true, true) => "right\n".to_owned(),
        (true, false) => "not right, but no more than is allowed\n".to_owned(),
        (false, _) => format!("not right: {}\n", exceeded.join("; ")),
    }
}

fn picture(verdict: &Verdict) -> String {
    let metrics = &verdict.metrics;
    let psnr = metrics.psnr.map_or("-".to_owned(), |psnr| format!("{psnr:.2} dB"));
    let mut text = format!(
        "\n{}: PSNR {psnr}, SSIM {:.6}, FLIP {:.6}, largest difference {}\n\n{}",
        verdict.picture,
        metrics.ssim,
        metrics.flip,
        metrics.max_difference,
        counts(&verdict.classes, true),
    );
    if let Some(held) = &verdict.hypothesis {
        text += &format!("\nas if {}\n  {}\n", held.as_if, extent(held));
        for other in &held.or_as_if {
            text += &format!("  or as if {other}: this cannot be told apart\n");
        }
    } else if let Some(best) = verdict.tested.first() {
        text += "\nno hypothesis about the whole picture holds; the best:\n";
        text += &format!("  as if {}\n    {}\n", best.as_if, extent(best));
    }
    if !verdict.culprits.is_empty() {
        text += "\nfragments\n";
        verdict.culprits.iter().for_each(|own| text += &format!("  {}\n", culprit(own)));
    }
    text
}

/// How far a hypothesis holds.
pub(super) fn extent(held: &Held) -> String {
    let of = percent(held.explains, held.of);
    let explains = thousands(held.explains);
    let against = match held.contradicts {
        0 => "contradicts none".to_owned(),
        n => format!("contradicts {}", thousands(n)),
    };
    format!("explains {explains} of {} pixels ({of}), {against}", thousands(held.of))
}

pub(super) fn culprit(own: &Culprit) -> String {
    let object = own.object.as_ref().map(|name| format!(" ({name})")).unwrap_or_default();
    let of = own.of.map(|of| format!(" of its {}", thousands(of))).unwrap_or_default();
    let [x, y] = own.first;
    let place = match (own.index, own.distance) {
        (Some(index), Some(distance)) => {
            format!(", there number {index} of the list, {distance:.6} from the eye")
        }
        _ => String::new(),
    };
    format!("{}{object}: {}{of} pixels, first {x},{y}{place}", own.what, thousands(own.pixels))
}

fn counts(classes: &[Counted], with_steps: bool) -> String {
    let all: u64 = classes.iter().map(|count| count.pixels).sum();
    let mut head =
        ["class", "pixels", "share", "largest", "first", "meaning"].map(str::to_owned).to_vec();
    let mut aligns =
        vec![Align::Left, Align::Right, Align::Right, Align::Right, Align::Right, Align::Left];
    let row = |count: &Counted| {
        let [x, y] = count.first;
        vec![
            count.class.name().to_owned(),
            thousands(count.pixels),
            percent(count.pixels, all),
            count.max_difference.to_string(),
            format!("{x},{y}"),
            count.meaning.to_owned(),
        ]
    };
    let mut rows: Vec<Vec<String>> = classes.iter().map(row).collect();
    if !with_steps {
        head.remove(3);
        aligns.remove(3);
        rows.iter_mut().for_each(|row| drop(row.remove(3)));
    }
    rows.insert(0, head);
    columns(&aligns, &rows)
}

fn dump(verdict: &DumpVerdict) -> String {
    let mut rows = vec![["class", "fragments", "codes", "meaning"].map(str::to_owned).to_vec()];
    rows.extend(verdict.fragments.iter().map(|count| {
        let codes = match count.max_codes {
            0 => "-".to_owned(),
            codes => thousands(codes),
        };
        let class = count.class.name().to_owned();
        vec![class, thousands(count.fragments), codes, count.meaning.to_owned()]
    }));
    let mut text = format!(
        "\n{}: {} fragments instead of {}\n\n{}\n{}",
        verdict.dump,
        thousands(verdict.dumped),
        thousands(verdict.exact),
        columns(&[Align::Left, Align::Right, Align::Right, Align::Left], &rows),
        counts(&verdict.classes, false),
    );
    if !verdict.first.is_empty() {
        text += "\nthe first fragments that are not right\n";
        verdict.first.iter().for_each(|own| text += &format!("  {}\n", odd(own)));
    }
    text
}

pub(super) fn odd(own: &Odd) -> String {
    let [x, y] = own.pixel;
    let triangle = match (own.triangle, &own.object) {
        (Some(triangle), Some(object)) => format!(", triangle {triangle} ({object})"),
        (Some(triangle), None) => format!(", triangle {triangle}"),
        _ => String::new(),
    };
    format!(
        "{}: pixel {x},{y}, number {}, depth {:08x}, data {:08x}{triangle}",
        own.class.name(),
        own.index,
        own.depth,
        own.data
    )
}

fn runs(found: &Runs) -> String {
    let places = found.places;
    let mut text = format!(
        "\nbetween the {} runs: {} pixels differ, {} beyond the tolerance, by at most {}\n\n{}",
        found.runs,
        thousands(found.pixels_different),
        thousands(found.pixels_beyond),
        found.max_difference,
        counts(&found.classes, true),
    );
    if found.pixels_beyond > 0 {
        let deeper = places.deeper_than_k.map_or(String::new(), |pixels| {
            format!("{} have more than k fragments, ", thousands(pixels))
        });
        text += &format!(
            "\nof those beyond: {deeper}{} have nearly equal depths, {} lie at an edge, {} elsewhere\n",
            thousands(places.tied),
            thousands(places.near_edge),
            thousands(places.elsewhere),
        );
    }
    text
}
