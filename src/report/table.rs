//! The accounting of a frame for people: where every fragment came from and where it went, side by side, so that
//! the balance can be read off.

use std::fmt::Write as _;

use super::text::{Align, columns, percent, thousands};
use crate::render::{Budget, CullingReport, ImportanceReport, Report, ShadowReport, TableReport};

/// The whole table. Fields that the schedule may change carry a `*`.
#[must_use]
pub fn accounting(report: &Report) -> String {
    let mut text = title(report);
    text.push('\n');
    text += &ledger(report);
    text.push('\n');
    text += &facts(report);
    for (heading, rows) in [("counters", counters(report)), ("seconds", seconds(report))] {
        if !rows.is_empty() {
            let _ = write!(text, "\n{heading}\n{}", columns(&[Align::Left, Align::Right], &rows));
        }
    }
    if text.contains('*') {
        text += "\n* may depend on the schedule\n";
    }
    text
}

/// Fragments that came in: generated, duplicated or torn.
#[must_use]
pub fn incoming(report: &Report) -> u64 {
    report.generated + report.duplicated + report.torn
}

/// Fragments that went somewhere: kept, merged, culled, evicted or dropped.
#[must_use]
pub fn outgoing(report: &Report) -> u64 {
    let dropped: u64 = report.dropped.values().sum();
    report.kept + report.merged + report.culled + report.evicted + dropped
}

fn title(report: &Report) -> String {
    let k = report.k.map_or_else(|| "all fragments".to_owned(), |k| format!("k = {k}"));
    let threads = match report.threads {
        1 => "1 thread".to_owned(),
        n => format!("{n} threads"),
    };
    let size = format!("{}x{}", report.width, report.height);
    format!("{}, {k}: {} at {size}, {}, {threads}\n", report.method, report.scene, report.exec)
}

/// Two accounts side by side, with their sums and whether they agree.
fn ledger(report: &Report) -> String {
    let starred = |name: &str| {
        let fixed = report.deterministic.iter().any(|field| field == name);
        if fixed { name.to_owned() } else { format!("{name} *") }
    };
    let entry = |name: &str, count: u64| [starred(name), thousands(count)];
    let sources = [
        entry("generated", report.generated),
        entry("duplicated", report.duplicated),
        entry("torn", report.torn),
    ];
    let mut sinks = vec![
        entry("kept", report.kept),
        entry("merged", report.merged),
        entry("culled", report.culled),
        entry("evicted", report.evicted),
        entry("dropped", report.dropped.values().sum()),
    ];
    let reasons = report.dropped.iter();
    sinks.extend(reasons.map(|(reason, &count)| [format!("  {reason}"), thousands(count)]));
    let mut rows = vec![vec!["fragments in".to_owned(), String::new(), "fragments out".to_owned()]];
    for (i, sink) in sinks.into_iter().enumerate() {
        let source = sources.get(i).cloned().unwrap_or_default();
        rows.push(source.into_iter().chain(sink).collect());
    }
    let [sum_in, sum_out] = [incoming(report), outgoing(report)];
    let sums = ["sum".to_owned(), thousands(sum_in), "sum".to_owned(), thousands(sum_out)];
    rows.push(sums.to_vec());
    let verdict = match sum_in == sum_out {
        true => "balanced".to_owned(),
        false => format!("NOT BALANCED: {} apart", thousands(sum_in.abs_diff(sum_out))),
    };
    let aligned = [Align::Left, Align::Right, Align::Left, Align::Right];
    format!("{}{verdict}\n", columns(&aligned, &rows))
}

fn facts(report: &Report) -> String {
    let pixels = u64::from(report.width) * u64::from(report.height);
    let triangles =
        format!("{} ({} degenerate)", thousands(report.triangles), thousands(report.degenerate));
    let depth = format!(
        "{} at most, {} on average",
        thousands(u64::from(report.max_depth_complexity)),
        ratio(report.generated, pixels)
    );
    let kept = percent(report.kept, report.generated);
    let each = ratio(report.bytes, pixels);
    let memory = format!("{} bytes, {each} per pixel", thousands(report.bytes));
    let mut rows = vec![
        ["triangles".to_owned(), triangles],
        ["depth complexity".to_owned(), depth],
        ["kept of generated".to_owned(), kept],
        ["memory".to_owned(), memory],
        ["geometry passes".to_owned(), passes(report)],
    ];
    let nan = report.nan_pixels.filter(|&nan| nan > 0);
    rows.extend(nan.map(|nan| ["no number".to_owned(), format!("{} pixels", thousands(nan))]));
    rows.extend(report.budget.as_ref().map(budget));
    rows.extend(report.importance.as_ref().map(importance));
    rows.extend(report.culling.as_ref().map(culling));
    rows.extend(report.table.as_ref().map(table));
    rows.extend(effect(report));
    rows.extend(report.shadows.as_ref().map(shadows));
    for (name, hash) in [
        ("image_hash", Some(&report.image_hash)),
        ("fragments_hash", report.fragments_hash.as_ref()),
    ] {
        let Some(hash) = hash else { continue };
        let fixed = report.deterministic.iter().any(|field| field == name);
        let name = if fixed { name.to_owned() } else { format!("{name} *") };
        rows.push([name, hash.clone()]);
    }
    let rows: Vec<Vec<String>> = rows.into_iter().map(Vec::from).collect();
    columns(&[Align::Left, Align::Left], &rows)
}

/// Of all rounds, and of each.
fn passes(report: &Report) -> String {
    match report.rounds {
        0 | 1 => report.passes.to_string(),
        rounds => format!("{} ({rounds} rounds of {})", rounds * report.passes, report.passes),
    }
}

fn table(table: &TableReport) -> [String; 2] {
    let TableReport { width, height, stored, load, max_age, .. } = table;
    let text = format!(
        "{width}x{height} cells, {} filled ({load:.1} %), largest age {max_age}",
        thousands(*stored)
    );
    ["hash table".to_owned(), text]
}

/// How records were divided by importance.
fn importance(importance: &ImportanceReport) -> [String; 2] {
    let fresnel = match (importance.factors.contains(&"fresnel"), importance.fresnel_known) {
        (true, false) => " (fresnel: 1, there is no frame before)",
        _ => "",
    };
    let text = format!(
        "k {} to {}, {} of {} records given, by {}{fresnel}",
        importance.smallest_k,
        importance.largest_k,
        thousands(importance.shared),
        thousands(importance.records),
        importance.factors.join(", ")
    );
    ["importance".to_owned(), text]
}

/// How many fragments were rejected where.
fn culling(culling: &CullingReport) -> [String; 2] {
    let reusing = culling
        .words_reusing
        .map_or_else(String::new, |words| format!("; {words} if the mask takes the k-buffer's"));
    let text = format!(
        "{}, {} intervals: {} rejected before the method, {} by it; {} words a pixel{reusing}",
        culling.method,
        culling.intervals,
        thousands(culling.rejected_before),
        thousands(culling.rejected_inside),
        culling.words
    );
    ["culling".to_owned(), text]
}

fn budget(budget: &Budget) -> [String; 2] {
    let chosen = match (budget.k, budget.room) {
        (Some(k), _) => format!("k = {k}"),
        (_, Some(room)) => format!("room for {}", thousands(room)),
        _ => "nothing to choose".to_owned(),
    };
    let text = format!(
        "{} bytes: {chosen}, {} fragments beyond it",
        thousands(budget.bytes),
        thousands(budget.beyond)
    );
    ["memory budget".to_owned(), text]
}

/// What was made of the lists, unless it is transparency.
fn effect(report: &Report) -> Vec<[String; 2]> {
    let mut rows = Vec::new();
    if report.effect != "oit" && !report.effect.is_empty() {
        rows.push(["effect".to_owned(), report.effect.clone()]);
    }
    let open = report.open_pixels.iter();
    rows.extend(open.map(|(name, &n)| [format!("open pixels of {name}"), thousands(n)]));
    rows.extend(report.solid_voxels.map(|n| ["solid voxels".to_owned(), thousands(n)]));
    rows
}

fn shadows(shadows: &ShadowReport) -> [String; 2] {
    let ShadowReport { size, bias, generated, kept, .. } = shadows;
    let text = format!(
        "{size}x{size} pixels, bias {bias}, {} of {} fragments kept",
        thousands(*kept),
        thousands(*generated)
    );
    ["shadow map".to_owned(), text]
}

fn counters(report: &Report) -> Vec<Vec<String>> {
    let row = |(name, &count): (&String, &u64)| vec![format!("  {name}"), thousands(count)];
    report.counters.iter().map(row).collect()
}

fn seconds(report: &Report) -> Vec<Vec<String>> {
    let row = |(pass, time): (&String, &f64)| vec![format!("  {pass}"), format!("{time:.3}")];
    report.seconds.iter().map(row).collect()
}

/// A quotient with two decimals, rounded down.
fn ratio(part: u64, whole: u64) -> String {
    let hundredths = u128::from(part) * 100 / u128::from(whole.max(1));
    format!("{}.{:02}", hundredths / 100, hundredths % 100)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn report() -> Report {
        Report {
            method: "kb".into(),
            scene: "cubes".into(),
            exec: "tile".into(),
            threads: 2,
            k: Some(8),
            width: 100,
            height: 10,
            generated: 1_234_567,
            kept: 1_000_000,
            evicted: 234_000,
            dropped: [("lost".into(), 567)].into(),
            deterministic: vec!["generated".into(), "image_hash".into()],
            counters: [("add".into(), 7_000)].into(),
            seconds: [("store".into(), 0.012_34)].into(),
            image_hash: "ab".into(),
            fragments_hash: Some("cd".into()),
            ..Report::default()
        }
    }

    #[test]
    fn the_table_is_laid_out() {
        let text = accounting(&report());
        assert!(text.starts_with("kb, k = 8: cubes at 100x10, tile, 2 threads\n"));
        let line = |start: &str| text.lines().find(|line| line.starts_with(start)).unwrap();
        assert_eq!(line("generated"), "generated     1,234,567  kept *         1,000,000");
        assert_eq!(line("sum"), "sum           1,234,567  sum            1,234,567");
        assert!(text.contains("\nbalanced\n") && text.contains("\n* may depend"));
        assert!(text.contains("  lost               567\n"), "the reasons of dropped fragments");
        assert!(text.contains("image_hash         ab\nfragments_hash *   cd\n"));
        assert!(text.contains("  add  7,000\n") && text.contains("  store  0.012\n"));
    }

    #[test]
    fn one_fragment_too_few_is_seen() {
        let wrong = Report { kept: 999_999, ..report() };
        assert!(accounting(&wrong).contains("NOT BALANCED: 1 apart"));
    }
}
