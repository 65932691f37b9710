//! The same bytes over {1, 2, 5 threads} x {tile 16, 64} x {tile, threads, sim with 6 policies}, wherever the contract
//! says that no schedule shows. Debug and release are compared by running this suite in both: the golden
//! hashes (`tests/golden.rs`) are the same for both.

mod support;

use std::collections::BTreeMap;

use fragloom::catalogue::Catalogue;
use fragloom::exec::{Kit, Method};
use fragloom::fragment::Data;
use fragloom::num::depth::Format;
use fragloom::render::Report;
use fragloom::render::{Effect, Exec, Options, Wanted, render_with};
use fragloom::resolve::Kept;
use fragloom::scene::Thickness;
use fragloom::scheme::HeldKind;
use fragloom::scheme::contract::{Contract, Form};
use support::{draw, options, policies, scene, sim, small_scenes};

/// All ways to run.
fn configurations() -> Vec<(usize, u32, Exec)> {
    let mut all = Vec::new();
    for tile in [16, 64] {
        for threads in [1, 2, 5] {
            all.push((threads, tile, Exec::Tile));
            all.push((threads, tile, Exec::Threads));
        }
        all.extend(policies().map(|policy| (2, tile, sim(policy, 5))));
    }
    all
}

#[test]
fn whatever_runs_it() {
    let catalogue = Catalogue::built_in();
    let methods = catalogue.contracts();
    let methods = methods.filter(|c| c.order_independent() && c.form == Form::Correct);
    let mut runs = 0;
    for contract in methods {
        for scene in small_scenes() {
            let base = options(contract.name, contract.default_k.map(|_| 3));
            let expected = draw(&scene, &base);
            for (threads, tile, exec) in configurations() {
                let drawn =
                    draw(&scene, &Options { threads, tile, exec: exec.clone(), ..base.clone() });
                let what = format!("{} {} {threads} {tile} {exec:?}", contract.name, scene.name);
                assert_eq!(drawn.report.image_hash, expected.report.image_hash, "{what}");
                assert_eq!(drawn.report.fragments_hash, expected.report.fragments_hash, "{what}");
                runs += 1;
            }
        }
    }
    println!("{runs} runs, one result per method and scene");
    assert!(runs >= 4 * 5 * 24, "{runs}");
}

#[test]
fn other_depth_formats_and_data_words() {
    let scene = scene("cubes", [40, 40]);
    for depth_format in Format::ALL {
        for data in [Data::Color, Data::Primitive] {
            let base = Options {
                depth_format: Some(depth_format),
                data,
                ..options("kplus-array", Some(4))
            };
            let exact = draw(&scene, &Options { method: Method::EXACT, ..base.clone() });
            for exec in [Exec::Tile, Exec::Threads, sim(fragloom::render::Policy::Random, 3)] {
                let drawn = draw(&scene, &Options { exec, ..base.clone() });
                assert_eq!(
                    *drawn.lists().expect("lists"),
                    *exact.lists().expect("lists"),
                    "{depth_format:?} {data:?}"
                );
                assert_eq!(drawn.image, exact.image, "{depth_format:?} {data:?}");
            }
        }
    }
}

/// Colour looked up at resolve is the colour that would have been stored.
#[test]
fn primitive_words_give_the_same_picture() {
    let scene = scene("bottles:columns=2,rows=2,levels=1,sides=12", [64, 64]);
    let color = draw(&scene, &options("ab-ll", None));
    let primitive = Options { data: Data::Primitive, ..options("ab-ll", None) };
    let primitive = draw(&scene, &primitive);
    assert!(color.report.kept > 1_000);
    // Fragments of equal depth stand in the order of their data words, which differ; everything else is the same.
    let differing = color.image.pixels.iter().zip(&primitive.image.pixels).filter(|(a, b)| a != b);
    let ties = color
        .lists()
        .expect("lists")
        .entries
        .windows(2)
        .filter(|w| w[0] >> 32 == w[1] >> 32)
        .count();
    assert!(differing.count() <= ties, "only ties may differ");
}

#[test]
fn a_recorded_schedule_runs_again_exactly() {
    use fragloom::render::{Policy, Sim};
    let scene = scene("synthetic:n=10", [20, 20]);
    for method in ["kb", "kplus-array", "kplus-array@published", "ab-ll", "ab-array@plain-counter"]
    {
        for policy in [Policy::Random, Policy::Warp(4), Policy::RoundRobin] {
            let recording =
                Sim { policy, seed: 9, resident: 64, record: true, watch: None, check: false };
            let base = options(method, Some(3));
            let first =
                draw(&scene, &Options { exec: Exec::Sim(recording.clone()), ..base.clone() });
            let schedule = first.schedule.clone().expect("it was recorded");
            let again = Sim { policy: Policy::Recorded(schedule.clone()), ..recording };
            let second = draw(&scene, &Options { exec: Exec::Sim(again), ..base });
            assert_eq!(second.schedule.as_ref(), Some(&schedule), "{method}");
            assert_eq!(*second.lists().expect("lists"), *first.lists().expect("lists"), "{method}");
            assert_eq!(second.image, first.image, "{method}");
            assert_eq!(second.report.counters, first.report.counters, "{method}");
        }
    }
}

#[test]
fn a_schedule_of_another_run_is_refused() {
    use fragloom::render::{Policy, Sim, render};
    let scene = scene("synthetic:n=4", [12, 12]);
    let recording = Exec::Sim(Sim { record: true, ..Sim::default() });
    let first = draw(&scene, &Options { exec: recording, ..options("kb", Some(3)) });
    let schedule = first.schedule.expect("it was recorded");
    let replay_on = |scene: &fragloom::scene::Scene, bytes: Vec<u8>, k| {
        let exec = Exec::Sim(Sim { policy: Policy::Recorded(bytes), ..Sim::default() });
        render(scene, &Options { exec, ..options("kb", Some(k)) })
    };
    let replay = |bytes: Vec<u8>, k| replay_on(&scene, bytes, k);
    for other in ["synthetic:n=4,seed=2", "synthetic:n=4,alpha=0.25"] {
        let other = support::scene(other, [12, 12]);
        assert!(replay_on(&other, schedule.clone(), 3).is_err(), "same name, size and triangles");
    }
    assert!(replay(schedule.clone(), 3).is_ok());
    assert!(replay(schedule.clone(), 4).is_err(), "another k");
    assert!(replay(schedule[..schedule.len() - 3].to_vec(), 3).is_err(), "cut off");
    assert!(replay([schedule.clone(), vec![0, 5]].concat(), 3).is_err(), "too long");
    assert!(replay(b"FLS1".to_vec(), 3).is_err(), "no head");
    for i in 12..schedule.len().min(400) {
        let mut damaged = schedule.clone();
        damaged[i] ^= 0x41;
        let _ = replay(damaged, 3); // an error or another run, but no panic
    }
}

/// Negative control: a method that does depend on schedules gives other bytes, and the comparison sees them.
#[test]
fn a_method_that_depends_on_schedules_is_seen() {
    let scene = scene("synthetic:n=24,density=100", [5, 5]);
    let hashes: std::collections::BTreeSet<Option<String>> = configurations()
        .into_iter()
        .map(|(threads, tile, exec)| Options { threads, tile, exec, ..options("kb", Some(3)) })
        .map(|options| draw(&scene, &options).report.fragments_hash)
        .collect();
    assert!(hashes.len() > 1);
}

/// What is not wanted changes nothing of the rest: picture, accounting, and the hash where it is wanted.
#[test]
fn less_may_be_wanted() {
    let catalogue = Catalogue::built_in();
    let contracts: Vec<_> = catalogue.contracts().filter(|c| c.form == Form::Correct).collect();
    let (mut gone, mut merged) = (BTreeMap::new(), 0);
    // As surfaces, and as slabs of which some are merged, where a method merges.
    let thicknesses = [Thickness::Precision(0.0), Thickness::World(0.05)];
    let slabs = |c: &Contract| if c.has_slabs() { &thicknesses[..] } else { &thicknesses[..1] };
    let runs =
        contracts.iter().flat_map(|&c| slabs(c).iter().map(move |&thickness| (c, thickness)));
    for (contract, thickness) in runs {
        // A picture whose edges cut tiles.
        let scene = scene("bottles:columns=2,rows=2,levels=1,sides=12", [75, 41]);
        let base = options(contract.name, contract.default_k.map(|_| 3));
        let base = Options { tile: 16, thickness, ..base };
        let [lists, hash, picture] = [Wanted::Lists, Wanted::Hash, Wanted::Picture]
            .map(|wanted| draw(&scene, &Options { wanted, ..base.clone() }));
        let name = contract.name;
        assert_eq!(lists.report.fragments_hash, hash.report.fragments_hash, "{name}");
        let kind = lists.kept.kind();
        if kind.is_list() {
            let none = Kept::Gone(kind);
            assert_eq!((&hash.kept, &picture.kept), (&none, &none), "{name}");
            assert_eq!(picture.report.fragments_hash, None, "{name}");
            assert!(hash.lists().is_err());
            *gone.entry(kind).or_insert(0) += 1;
            merged += lists.report.merged;
        }
        for less in [hash, picture] {
            assert_eq!(less.image, lists.image, "{name}");
            let kept = |r: &Report| (r.generated, r.kept, r.culled, r.evicted, r.merged);
            assert_eq!(kept(&less.report), kept(&lists.report), "{name}");
        }
    }
    let [fragments, records] = [HeldKind::Fragments, HeldKind::Records].map(|kind| gone[&kind]);
    assert!(fragments >= 20 && records >= 6, "{gone:?}");
    assert!(merged > 100, "{merged}");
}

/// Whether operations are counted does not show. Where they are not, passes that only count fragments are run by whole
/// counts (`Scheme::counts`), on `tile` alone: `threads` runs them fragment by fragment in any case.
#[test]
fn counting_operations_does_not_show() {
    let catalogue = Catalogue::built_in();
    for contract in
        catalogue.contracts().filter(|c| c.order_independent() && c.form == Form::Correct)
    {
        let scene = scene("bottles:columns=2,rows=2,levels=1,sides=12", [75, 41]);
        let base = Options { tile: 16, ..options(contract.name, contract.default_k.map(|_| 3)) };
        let counted = draw(&scene, &base);
        for exec in [Exec::Tile, Exec::Threads] {
            let plain = draw(&scene, &Options { counters: false, exec, ..base.clone() });
            assert_eq!(plain.kept, counted.kept, "{}", contract.name);
            assert_eq!(plain.image, counted.image, "{}", contract.name);
            assert_eq!(plain.report.violations, counted.report.violations, "{}", contract.name);
            assert!(plain.report.counters.is_empty());
        }
    }
}

/// An effect gets the lists that it needs, whatever is wanted.
#[test]
fn effects_have_their_lists() {
    let scene = scene("cubes", [40, 40]);
    let base = Options {
        effect: Effect::Media { density: 1.0 },
        data: Data::Primitive,
        ..options("ab-ll", None)
    };
    let all = draw(&scene, &base);
    let less = draw(&scene, &Options { wanted: Wanted::Picture, ..base });
    assert_eq!((less.image, less.report.fragments_hash), (all.image, all.report.fragments_hash));
}

/// Frames that use again what others have left are those of fresh storage: other scenes, sizes and methods between
/// them do not show.
#[test]
fn storage_is_used_again_without_a_trace() {
    let kit = Kit::of_several();
    let scenes =
        [scene("cubes", [40, 40]), scene("layers:count=5", [75, 41]), scene("gears", [40, 40])];
    for method in ["ab-ll", "kplus-array", "s-buffer", "ha64", "dfb+ofm", "z-buffer", "wboit"] {
        for exec in [Exec::Tile, Exec::Threads] {
            for scene in scenes.iter().chain(scenes.iter().rev()) {
                let options = Options { exec: exec.clone(), ..options(method, None) };
                let again = render_with(scene, &options, &kit).expect("a frame");
                let fresh = draw(scene, &options);
                let what = format!("{method} {exec:?} {}", scene.name);
                assert_eq!(again.image, fresh.image, "{what}");
                assert_eq!(again.report.fragments_hash, fresh.report.fragments_hash, "{what}");
                assert_eq!(again.report.kept, fresh.report.kept, "{what}");
            }
        }
    }
}

/// The code that is compiled for the vectors of this machine gives the bits of that for every machine.
#[test]
fn vectors_do_not_show() {
    let hashes = |narrow: bool| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_fragloom"));
        command.args([
            "compare",
            "hairball:strands=60",
            "-m",
            "kplus-array,ab-ll,dfb,s-buffer,skb+ofm,mlab",
        ]);
        command.args(["--size", "150x110", "--json", "-q"]);
        if narrow {
            command.env(fragloom::num::lanes::VARIABLE, "narrow");
        }
        let output = command.output().expect("it starts");
        let text = String::from_utf8(output.stdout).expect("JSON");
        let lines = text.lines().filter(|line| line.contains("_hash"));
        lines.map(str::to_owned).collect::<Vec<_>>()
    };
    let wide = hashes(false);
    assert!(wide.len() >= 12, "{wide:?}");
    assert_eq!(wide, hashes(true));
}
