//! What checks find out about methods: the max-array under every interleaving, what a k-buffer can make of three
//! fragments, the papers' claims, the kill matrix; and that a bound, a cancellation or an operation that nothing
//! reaches is never a verdict.

#[path = "support/unreached.rs"]
mod unreached;
#[path = "../examples/user_scheme.rs"]
#[allow(dead_code, reason = "its main function")]
mod user_scheme;

#[path = "support/toys/mod.rs"]
mod toys;

use std::collections::BTreeSet;

use fragloom::catalogue::faults::MUTATIONS;
use fragloom::catalogue::{self, Catalogue};
use fragloom::explore::program::controls::CONTROLS;
use fragloom::explore::verdict::claims::claim_by_id;
use fragloom::explore::verdict::matrix::{Fate, Kill, Line, matrix};
use fragloom::explore::{
    Conditions, Entry, Family, Finding, Limits, Litmus, MemoryModel, Plan, Profile, Progress,
    Property, Subject, Survey, Token, Verdict, check, cut, explore, properties, replay,
};
use fragloom::fragment::{data_of, depth_of, key, pair_key};
use fragloom::num::depth::Format;
use fragloom::num::depth::{EMPTY, FARTHEST};
use fragloom::render::{Data, Options, reference};
use fragloom::scene::{self, Overrides};
use fragloom::scheme::kplus_buffer::kplus_array::faults::{Faulty, NoFault};
use fragloom::scheme::{Held, Keys};
use unreached::Unreached;
use user_scheme::CasList;

const LIMITS: Limits<'static> = Limits { states: 5_000_000, cancelled: &|| false };

const VULKAN: MemoryModel = MemoryModel::Relaxed(Profile::Vulkan);

/// The number of fragments, from an environment variable: set it for a longer run.
fn fragments(variable: &str, otherwise: u32) -> u32 {
    std::env::var(variable).ok().and_then(|n| n.parse().ok()).unwrap_or(otherwise)
}

fn subject(method: &str) -> Subject {
    Subject::new(catalogue::method(method).expect("a method")).expect("it has invocations")
}

fn survey(method: &str, memory: MemoryModel, fragments: u32) -> Survey {
    let family = Family { fragments, ks: vec![1, 2, 3], helpers: 0 };
    let conditions = Conditions { memory, warp: None };
    Survey::new(&subject(method), &family, conditions, &LIMITS)
}

/// Every property verified, and one outcome, which is the exact one.
#[track_caller]
fn keeps_its_promise(method: &str, memory: MemoryModel, fragments: u32) {
    let survey = survey(method, memory, fragments);
    assert_eq!((survey.size, survey.is_complete()), (fragments, true));
    for property in properties(&survey.subject, memory) {
        let row = survey.row(property);
        assert_eq!((row.verdict, row.exhaustive), (Verdict::Verified, true), "{row:?}");
    }
    for (litmus, explored) in &survey.explored {
        let k = litmus.k.map_or(usize::MAX, |k| k as usize);
        let exact = |pixel| litmus.generated(pixel).into_iter().take(k).collect::<Vec<_>>();
        let exact: Vec<Held> = (0..litmus.pixels).map(exact).map(Held::Keys).collect();
        assert!(explored.outcomes.keys().eq([&exact]), "{}", litmus.describe());
    }
    for n in 1..=fragments {
        let of_size = survey.explored.iter().filter(|(l, _)| l.fragments.len() == n as usize);
        let (mut instances, mut states) = (0, 0);
        for (_, explored) in of_size {
            (instances, states) = (instances + 1, states + explored.states);
        }
        println!("{method}, {memory}, n = {n}: {instances} instances, {states} states");
    }
    println!("{method}, {memory}: {:?} executions", survey.executions());
}

#[test]
fn the_max_array_keeps_the_nearest_under_every_interleaving() {
    keeps_its_promise(
        "kplus-array",
        MemoryModel::Sequential,
        fragments("FRAGLOOM_FRAGMENTS_SC", 4),
    );
    let relaxed = fragments("FRAGLOOM_FRAGMENTS_RELAXED", 3);
    keeps_its_promise("kplus-array", VULKAN, relaxed);
    keeps_its_promise("kplus-array", MemoryModel::Relaxed(Profile::Glsl), relaxed);
}

/// The faults' body without a fault is the correct form: the same states and results on every instance.
#[test]
fn the_body_with_faults_is_the_correct_form_but_for_them() {
    let (correct, none) = (subject("kplus-array"), Subject::of::<Faulty<NoFault>>());
    let family = Family { fragments: 3, ks: vec![1, 2, 3], helpers: 1 };
    let (mut states, mut compared) = (0, 0);
    for (memory, warp) in
        [(MemoryModel::Sequential, None), (VULKAN, None), (MemoryModel::Sequential, Some(2))]
    {
        let conditions = Conditions { memory, warp };
        for n in 1..=if memory == VULKAN { 2 } else { 3 } {
            for litmus in fragloom::explore::program::instances::of_size(&correct, &family, n) {
                let both = [&correct, &none].map(|s| explore(s, &litmus, conditions, &LIMITS));
                let [a, b] = both
                    .each_ref()
                    .map(|e| (e.states, e.complete, e.outcomes.keys().collect::<Vec<_>>()));
                assert_eq!(a, b, "{}", litmus.describe());
                states += both[0].states;
                compared += 1;
            }
        }
    }
    println!("{compared} instances, {states} states");
    assert!(compared > 60 && states > 10_000, "{compared} instances, {states} states");
}

/// A scene's pixel has the words that drawings of the method store: its contract's, whatever the options say.
#[test]
fn a_pixel_of_a_scene_has_the_words_of_its_method() {
    let sources = ["layers:count=3", "cubes", "synthetic:n=9"];
    let overrides = Overrides { size: Some([16, 16]), ..Overrides::default() };
    let catalogue = toys::catalogue();
    let (mut compared, mut cut_words) = (0, 0);
    for source in sources {
        let scene = scene::load(source, &overrides).expect("a scene");
        for &method in catalogue.methods().iter().filter(|m| !m.is_exact()) {
            let subject = Subject::new(method).expect("it has invocations");
            for data in [Data::Color, Data::Primitive, Data::Nothing] {
                for depth_format in [None, Some(Format::D24), Some(Format::F32)] {
                    let contract = method.contract();
                    if depth_format
                        .is_some_and(|f| contract.depth_format.is_some_and(|own| own != f))
                    {
                        continue;
                    }
                    let options = Options { method, data, depth_format, ..Options::default() };
                    // What drawings are held to.
                    let Ok(right) = reference(&scene, &options) else { continue };
                    let Ok(litmus) = cut(&subject, &scene, &options, [9, 8]) else { continue };
                    assert_eq!(
                        litmus.generated(0),
                        right.all.pixel(9, 8),
                        "{method} {data:?} {source}"
                    );
                    let all_zero = litmus.fragments.iter().all(|fragment| fragment.2 == 0);
                    let stored = contract.data.unwrap_or(data);
                    assert!(stored != Data::Nothing || all_zero, "{method} {data:?} {source}");
                    compared += 1;
                    cut_words += u32::from(contract.data.is_some_and(|own| own != data));
                }
            }
        }
    }
    println!("{compared} pixels, {cut_words} with other words than were asked for");
    assert!(compared > 900 && cut_words > 50, "{compared} pixels, {cut_words} cut");
}

/// As it was found: two fragments of ha32, which has no room for data.
#[test]
fn ha32_keeps_two_layers() {
    let overrides = Overrides { size: Some([16, 16]), ..Overrides::default() };
    let scene = scene::load("layers:count=2", &overrides).expect("a scene");
    let subject = subject("ha32");
    let options = Options { method: subject.method, ..Options::default() };
    let litmus = cut(&subject, &scene, &options, [4, 4]).expect("two fragments");
    assert!(litmus.fragments.iter().all(|fragment| fragment.2 == 0), "{litmus:?}");
    let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
    let survey = Survey::given(&subject, &litmus, conditions, &LIMITS);
    for property in properties(&subject, MemoryModel::Sequential) {
        let row = survey.row(property);
        assert_ne!(row.verdict, Verdict::Violated, "{row:?}");
    }
}

/// Three fragments of distinct depths.
fn three(k: Option<u32>) -> Litmus {
    let fragments =
        vec![Entry(0, 0, 0x30, 0), Entry(0, 0x1000_0000, 0x20, 0), Entry(0, FARTHEST, 0x10, 0)];
    Litmus { pixels: 1, k, room: 3, fragments, helpers: 0, table: None, inputs: Vec::new() }
}

fn explored(method: &str, litmus: &Litmus) -> fragloom::explore::Explored {
    let conditions = Conditions { memory: MemoryModel::Sequential, warp: None };
    explore(&subject(method), litmus, conditions, &LIMITS)
}

/// The list that a pixel holds.
fn keys(held: &Held) -> &Keys {
    let Held::Keys(keys) = held else { panic!("it keeps lists of fragments") };
    keys
}

/// Everything that a k-buffer with k = 2 can make of three fragments, found by a search of its own: each invocation
/// reads four words (depth 0, data 0, depth 1, data 1), inserts, and writes them; all orders of these steps.
fn by_hand(litmus: &Litmus) -> BTreeSet<Vec<u64>> {
    /// The pixel's words; each invocation's progress, 0 to 8, and its four words.
    type State = ([u32; 4], [(usize, [u32; 4]); 3]);
    let garbage = [0, litmus.fragments[1].2, u32::MAX];
    let start = |a, b| -> State { ([EMPTY, garbage[a], EMPTY, garbage[b]], [(0, [0; 4]); 3]) };
    let mut open: Vec<State> = (0..9).map(|i| start(i / 3, i % 3)).collect();
    let mut known: BTreeSet<State> = open.iter().copied().collect();
    let mut results = BTreeSet::new();
    while let Some((words, invocations)) = open.pop() {
        let entries = words.chunks(2).map(|pair| pair_key((pair[0], pair[1])));
        if invocations.iter().all(|&(steps, _)| steps == 8) {
            let mut list: Vec<u64> = entries.filter(|&e| depth_of(e) != EMPTY).collect();
            list.sort_unstable();
            results.insert(list);
        }
        for (i, &Entry(_, depth, data, _)) in litmus.fragments.iter().enumerate() {
            let (mut words, mut invocations) = (words, invocations);
            let (steps, own) = &mut invocations[i];
            match *steps {
                0..4 => own[*steps] = words[*steps],
                4..8 => words[*steps - 4] = own[*steps - 4],
                _ => continue,
            }
            *steps += 1;
            if *steps == 4 {
                let mut all = [key(own[0], own[1]), key(own[2], own[3]), key(depth, data)];
                all.sort_unstable();
                *own = [depth_of(all[0]), data_of(all[0]), depth_of(all[1]), data_of(all[1])];
            }
            if known.insert((words, invocations)) {
                open.push((words, invocations));
            }
        }
    }
    results
}

/// At the granularity of 32-bit words, depth and data apart: fragments are lost, doubled and torn, and words that were
/// never written show through.
#[test]
fn what_a_k_buffer_makes_of_three_fragments() {
    let litmus = three(Some(2));
    let explored = explored("kb", &litmus);
    let found: BTreeSet<Vec<u64>> =
        explored.outcomes.keys().map(|pixels| keys(&pixels[0]).clone()).collect();
    let text = |list: &Vec<u64>| {
        list.iter().map(|e| format!("{:x}/{:x} ", depth_of(*e), data_of(*e))).collect::<String>()
    };
    found.iter().for_each(|list| println!("{}", text(list)));
    println!("{} outcomes, {} states", found.len(), explored.states);
    println!("{:?} executions", explored.executions);
    assert!(explored.complete);
    assert_eq!(found, by_hand(&litmus), "32-bit plain words, depth and data apart");
    let generated = litmus.generated(0);
    let nearest = generated[..2].to_vec();
    assert!(found.contains(&nearest), "what one after another gives");
    let lost: Vec<_> = generated.iter().map(|&only| vec![only]).collect();
    assert!(lost.iter().any(|one| found.contains(one)), "a fragment is lost");
    let torn = |list: &Vec<u64>| list.iter().any(|e| !generated.contains(e));
    assert!(found.iter().any(torn), "a fragment is torn");
    let (all, first) = (&explored.violations, &explored.outcomes[&vec![Held::Keys(nearest)]]);
    for property in [Property::Keeps, Property::Intact, Property::OneOutcome] {
        assert!(all.contains_key(&property), "{property:?}");
    }
    assert_eq!(first.len(), 3 * 8, "every invocation takes eight steps");
}

/// All memory models; 4 fragments under sequential consistency and 3 otherwise, unless fewer are asked for.
fn plan(fragments: Option<u32>) -> Plan {
    let memory =
        [MemoryModel::Sequential].into_iter().chain(Profile::ALL.map(MemoryModel::Relaxed));
    Plan { fragments, ks: vec![1, 2], memory: memory.collect(), runs: 60, ..Plan::default() }
}

/// A violated row's token runs again and shows the same.
#[track_caller]
fn shows_it_again(row: &Finding) {
    let token = row.token.as_ref().expect("a token").parse().expect("a token of ours");
    let Token::Litmus(token) = token else { panic!("a token of a litmus pixel") };
    assert!(token.litmus.fragments.len() <= 4, "{row:?}");
    assert_eq!((&token.method, Some(&token.property)), (&row.method, row.property.as_ref()));
    let shown = replay::replay(&Catalogue::built_in(), &token).expect("the same operations");
    if token.property == Property::ArrivalFree.name() {
        // It is about all results; this is one of them.
        let end = shown.run.end.expect("all have ended");
        assert!(row.message.contains(&end.pixels[0].to_string()), "{row:?}");
        return;
    }
    if token.property == Property::OneOutcome.name() {
        let end = shown.run.end.expect("all have ended");
        let list = end.pixels.iter().flat_map(keys);
        let list = list.map(|e| format!("{:x}/{:x}", depth_of(*e), data_of(*e)));
        let list = format!("[{}]", list.collect::<Vec<_>>().join(" "));
        assert!(row.message.contains(&list), "{list}: {row:?}");
        return;
    }
    let of_property = |(p, _): &&(Property, String)| p.name() == token.property;
    let told = shown.run.violations().find(of_property).map(|(_, told)| told.as_str());
    let told = told.unwrap_or_else(|| panic!("nothing is wrong: {row:?}"));
    let message = row.message.strip_prefix("as under sc: ").unwrap_or(&row.message);
    assert!(message.starts_with(told), "{told}: {row:?}");
}

/// The verdict of a method under a memory model.
fn verdict(rows: &[Finding], method: &str, memory: &str, profile: Option<&str>) -> Verdict {
    let is_it = |row: &&Finding| {
        row.method == method && row.memory == memory && row.profile.as_deref() == profile
    };
    rows.iter().find(is_it).unwrap_or_else(|| panic!("{method} {memory} {profile:?}")).verdict
}

/// Verdicts are computed, so only decisive ones are expected here: the correct form keeps every claim wherever a lock
/// can work, and the published forms do not keep the first one.
#[test]
fn the_claims_have_verdicts_and_violations_have_tokens() {
    let mut violated = 0;
    for id in ["C1", "C2", "C3", "C4"] {
        let rows = claim_by_id(id)
            .expect("a claim")
            .check(&Catalogue::built_in(), &[], &plan(None), &LIMITS)
            .expect("rows");
        for row in &rows {
            let memory = row.profile.as_deref().unwrap_or(&row.memory);
            let property = row.property.as_deref().unwrap_or_default();
            let (verdict, states) = (row.verdict.name(), row.states);
            println!("{id} {} {memory}: {verdict} {property} {states} states", row.method);
            assert_eq!(row.claim.as_deref(), Some(id));
            assert_eq!(row.token.is_some(), row.verdict == Verdict::Violated, "{row:?}");
            if row.verdict == Verdict::Violated {
                println!("    {}: {}", row.instance, row.message);
                shows_it_again(row);
                violated += 1;
            }
        }
        for (memory, profile, expected) in [
            ("sc", None, Verdict::Verified),
            ("relaxed", Some("vulkan"), Verdict::Verified),
            ("relaxed", Some("glsl"), Verdict::Verified),
            ("relaxed", Some("wgsl"), Verdict::Violated),
        ] {
            let found = verdict(&rows, "kplus-array", memory, profile);
            assert_eq!(found, expected, "{id} {memory} {profile:?}");
        }
        if id == "C1" {
            for published in ["kplus-array@published", "kplus-array@root-first"] {
                let found = verdict(&rows, published, "sc", None);
                assert_eq!(found, Verdict::Violated, "{published}");
            }
        }
    }
    assert!(violated >= 12, "{violated}");
}

/// The claims of the HA-buffer, importance and culling papers: what holds, and what is shown to be wrong with a few
/// fragments.
#[test]
fn later_papers_keep_their_promises_but_for_what_was_published() {
    let sequential = Plan { memory: vec![MemoryModel::Sequential], ..plan(Some(3)) };
    let expected = [
        (
            "C8",
            &["ha64", "ha32", "ha64-multiset", "ha64-cull"][..],
            &["ha64@no-depth", "ha64@load-store"][..],
        ),
        ("C9", &["ha64", "ha32"], &["ha64@area", "ha64@offset"]),
        (
            "C10",
            &["ha64", "ha32", "ha64-multiset", "hash-coherent"],
            &["hash-coherent@published", "ha64@no-reinsert"],
        ),
        ("C11", &["ha64-cull"], &["ha64-cull@published"]),
        ("C12", &["ha64"], &["ha64@published", "ha64@max-age"]),
        (
            "C7",
            &["k-variable"],
            &["k-variable@rounded", "k-variable@float-quotient", "k-variable@M17"],
        ),
        (
            "C13",
            &["occupancy"],
            &["occupancy@near-end", "occupancy@one-too-near", "occupancy@ends-early"],
        ),
    ];
    for (id, hold, fail) in expected {
        let rows = claim_by_id(id)
            .expect("a claim")
            .check(&Catalogue::built_in(), &[], &sequential, &LIMITS)
            .expect("rows");
        for row in &rows {
            println!(
                "{id} {}: {} in {} states; {}",
                row.method,
                row.verdict.name(),
                row.states,
                row.instance
            );
            if row.verdict == Verdict::Violated {
                shows_it_again(row);
            }
        }
        for (methods, expected) in [(hold, Verdict::Verified), (fail, Verdict::Violated)] {
            for method in methods {
                assert_eq!(verdict(&rows, method, "sc", None), expected, "{id} {method}");
            }
        }
        assert_eq!(rows.len(), hold.len() + fail.len(), "{id}");
    }
}

/// Sums in integers do not depend on arrival; sums of floats, nodes and blended tails do: the smallest examples.
#[test]
fn approximate_sums_are_free_of_arrival_and_nodes_are_not() {
    let sequential = Plan { memory: vec![MemoryModel::Sequential], ..plan(None) };
    let claim = claim_by_id("C17").expect("a claim");
    let rows = claim.check(&Catalogue::built_in(), &[], &sequential, &LIMITS).expect("rows");
    let refuted = [
        ("wboit@published-f32", "n=3"),
        ("mbt@published-f32", "n=3"),
        ("mlab", "n=3 k=1"),
        // By rounding; by which node goes, with k = 2 and 4 fragments.
        ("adaptive", "n=3 k=1"),
        ("kplus-array+tail", "n=3 k=1"),
    ];
    for row in &rows {
        println!(
            "{}: {} in {} states; {}",
            row.method,
            row.verdict.name(),
            row.states,
            row.instance
        );
        match refuted.iter().find(|(method, _)| *method == row.method) {
            Some((_, smallest)) => {
                assert_eq!(row.verdict, Verdict::Violated, "{row:?}");
                assert!(row.instance.starts_with(smallest), "{row:?}");
                shows_it_again(row);
            }
            None => assert_eq!(row.verdict, Verdict::Verified, "{row:?}"),
        }
    }
    assert_eq!(rows.len(), 12);
}

/// Claims about methods that are not here have no verdict, and say so.
#[test]
fn a_law_needs_no_interleavings_and_an_unknown_claim_is_named() {
    let check = |claim: &str| {
        let claim = claim_by_id(claim).expect("a claim");
        claim.check(&Catalogue::built_in(), &[], &plan(Some(1)), &LIMITS).expect("rows")
    };
    let verdicts = |claim: &str| -> Vec<(String, Verdict)> {
        check(claim).into_iter().map(|row| (row.method, row.verdict)).collect()
    };
    let of = |holds: &[&str], fails: &[&str]| -> Vec<(String, Verdict)> {
        let holds = holds.iter().map(|m| ((*m).to_owned(), Verdict::Verified));
        holds.chain(fails.iter().map(|m| ((*m).to_owned(), Verdict::Violated))).collect()
    };
    let faults = ["dfb+sfm@released", "dfb+sfm@front-beta", "dfb+sfm@M15"];
    assert_eq!(verdicts("c15"), of(&["dfb+sfm"], &faults));
    let merging = ["dfb+sfm", "dfb+ofm", "skb+ofm", "skb+ofm@released"];
    assert_eq!(verdicts("C16"), of(&merging, &["dfb", "kplus-array"]));
    assert!(check("C15").iter().all(|row| row.executions == Some(13_824)));
    let message = claim_by_id("C99").expect_err("no such claim").to_string();
    assert!(message.contains("C1, C2") && message.contains("C17"), "{message}");
}

#[test]
fn every_fault_is_killed_and_every_control_is_green() {
    let lines = matrix(&Catalogue::built_in(), None, &plan(None), &LIMITS);
    let lines = lines.expect("the matrix");
    for line in &lines {
        let kills = line.kills.iter().map(|k| format!("{}/{} in {}", k.check, k.property, k.steps));
        let kills = kills.collect::<Vec<_>>().join(", ");
        println!("{:22} {:36} {:10} {kills}", line.mutation, line.method, line.fate.name());
    }
    let wrong: Vec<&Line> = lines.iter().filter(|line| !line.fate.is_right()).collect();
    assert!(wrong.is_empty(), "{wrong:?}");
    let of = |mutation: &str| lines.iter().filter(|l| l.mutation == mutation).collect::<Vec<_>>();
    assert!(of("control").len() >= 4 && of("control").iter().all(|l| l.fate == Fate::Green));
    for mutation in MUTATIONS.iter().chain(CONTROLS) {
        let methods: Vec<&str> = of(mutation.id).iter().map(|l| l.method.as_str()).collect();
        assert_eq!(methods, mutation.variants, "{}", mutation.id);
    }
    for line in lines.iter().filter(|l| l.mutation != "control") {
        let expected = if line.method == "ab-ll@M11" { Fate::Equivalent } else { Fate::Killed };
        assert_eq!(line.fate, expected, "{line:?}");
        // What does not end, or does not do the same again, has no schedule.
        let shown =
            |kill: &Kill| kill.token.is_some() || ["endless", "repeats"].contains(&kill.property);
        assert!(line.kills.iter().all(shown), "{line:?}");
    }
}

/// A check's own example: a list by compare-exchange, of no catalogue.
#[test]
fn the_example_is_verified_and_its_broken_twin_is_not() {
    let rows = check(&Subject::of::<CasList<false>>(), &Plan::default(), &LIMITS);
    let (sampled, rows) = rows.split_last().expect("rows");
    assert_eq!(sampled.verdict, Verdict::Sampled, "{sampled:?}");
    for row in rows {
        assert_eq!(row.verdict, Verdict::Verified, "{row:?}");
    }
    assert!(rows.iter().any(|row| row.progress.as_deref() == Some("simt")));
    println!("{} rows, {} states in the first", rows.len(), rows[0].states);
    let broken = Subject::of::<CasList<true>>();
    let rows = check(&broken, &Plan::default(), &LIMITS);
    let violated: Vec<&Finding> = rows.iter().filter(|r| r.verdict == Verdict::Violated).collect();
    let keeps = |row: &&&Finding| row.property.as_deref() == Some("keeps");
    let keeps = violated.iter().find(keeps).expect("it loses a fragment");
    assert!(keeps.instance.starts_with("n=2 "), "{keeps:?}");
    let token = keeps.token.as_ref().expect("a token").parse().expect("a token of ours");
    let Token::Litmus(token) = token else { panic!("a token of a litmus pixel") };
    let shown = replay::replay_of(&broken, &token).expect("the same operations");
    assert!(shown.run.violations().any(|(property, _)| *property == Property::Keeps));
    assert!(shown.doomed_after.is_some(), "there is a step after which nothing helps");
    println!("{}: {}", keeps.instance, keeps.message);
}

/// Work is divided by instances; results are put together in their order.
#[test]
fn rows_do_not_depend_on_the_number_of_threads() {
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let plan = Plan { progress: Some(Progress::ALL.to_vec()), ..plan(Some(2)) };
            let methods = ["kplus-array", "kb", "kplus-array@M1", "ab-ll@plain-head"];
            let rows = methods.map(|name| check(&subject(name), &plan, &LIMITS));
            rows.concat()
        })
    };
    let (one, three) = (with(1), with(3));
    assert!(one.len() > 80, "{} rows", one.len());
    assert_eq!(one, three);
}

/// No verified row without having seen everything.
#[track_caller]
fn is_all_unknown(rows: &[Finding], words: &str) {
    assert!(!rows.is_empty());
    for row in rows {
        assert_eq!((row.verdict, row.exhaustive), (Verdict::Unknown, false), "{row:?}");
        assert!(row.message.contains(words), "{row:?}");
    }
}

#[test]
fn a_bound_that_is_hit_is_no_verdict() {
    let plan = Plan { progress: Some(Progress::ALL.to_vec()), runs: 0, ..plan(Some(2)) };
    let kplus = subject("kplus-array");
    let few = Limits { states: 10, cancelled: &|| false };
    is_all_unknown(&check(&kplus, &plan, &few), "raise --max-states");
    let enough = Limits { states: 5_000_000, cancelled: &|| true };
    is_all_unknown(&check(&kplus, &plan, &enough), "interrupted");
    for id in ["C1", "C4"] {
        let only = ["kplus-array".to_owned()];
        let rows = claim_by_id(id)
            .expect("a claim")
            .check(&Catalogue::built_in(), &only, &plan, &few)
            .expect("rows");
        is_all_unknown(&rows, "raise --max-states");
    }
    let few = Limits { states: 2, cancelled: &|| false };
    for line in matrix(&Catalogue::built_in(), None, &plan, &few).expect("the matrix") {
        let weak = matches!(line.fate, Fate::Green | Fate::Equivalent);
        assert!(!weak, "{line:?}");
    }
}

/// A check that never got to an operation has not checked the method.
#[test]
fn an_operation_that_nothing_reaches_is_named() {
    let rows = check(&Subject::of::<Unreached>(), &plan(Some(3)), &LIMITS);
    let source = include_str!("support/unreached.rs");
    let line = 1 + source.lines().position(|l| l.contains("mem.exchange(")).expect("the line");
    let place = format!("relaxed exchange at tests/support/unreached.rs:{line}:");
    let (random, rows) = rows.split_last().expect("rows");
    let mut count = 0;
    for row in rows.iter().filter(|row| row.progress.is_none()) {
        assert_eq!(row.verdict, Verdict::Unknown, "{row:?}");
        assert!(row.message.contains(&place) && row.message.contains("raise -n or -k"), "{row:?}");
        count += 1;
    }
    assert!(count > 20, "{count} rows");
    // Random runs got there, and saw what it does.
    assert_eq!(random.verdict, Verdict::Violated, "{random:?}");
    assert!(random.instance.contains(" 3039/"), "{random:?}");
}
