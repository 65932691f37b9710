//! Twins with a fault are found: by conformance, one invocation at a time; where the fault is in no word, by pictures.

use fragloom::gpu::check::conform::{self, conform};
use fragloom::gpu::check::crosscheck::{self, Options, Status};
use fragloom::gpu::driver::failure::Failure;
use fragloom::gpu::twin::picture::Picture;
use fragloom::gpu::twin::program::Program;
use fragloom::gpu::twin::resolve::draw;
use fragloom::gpu::twin::shape::{Shape, constants};
use fragloom::gpu::twin::source::Twin;

use super::drivers::{all, alone, crosscheck, turn, twin};
use super::merging::mutant_part;
use super::support::scene;

/// A twin with one change.
pub(super) fn mutant(method: &str, from: &str, to: &str) -> Twin {
    let twin = twin(method);
    let text = twin.text.replace(from, to);
    assert_ne!(text, twin.text, "{method}: {from}");
    Twin { text: text.leak(), ..twin }
}

/// A twin with one change in a part that it includes.
pub(super) fn mutant_in(method: &str, part: &str, from: &str, to: &str) -> Twin {
    let twin = twin(method);
    let file = format!("{}/src/gpu/wgsl/{part}.wgsl", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(file).expect("a part");
    let changed = text.replace(from, to);
    assert_ne!(text, changed, "{part}: {from}");
    let text = format!("//# replaces {part}\n{}\n{changed}", twin.text);
    Twin { text: text.leak(), ..twin }
}

#[test]
fn conformance_finds_changed_twins() {
    let _turn = alone();
    let mutants = [
        mutant("ab-ll", "nodes.links[node] = ", "nodes.links[0] = "),
        mutant("ab-array", "return KEPT", "return CULLED"),
        mutant("kplus-array", "array_append(pixel, count, key)", "put(pixel, count, key)"),
        mutant("s-buffer", "sum_up(number, index)", "sum_up(number, 0u)"),
        mutant("kb", "is_less", "!is_less"),
        mutant("kb-ll", "!is_less(key, key_of_node(next))", "is_less(key_of_node(next), key)"),
        mutant("skb+ofm", "count -= 1u", "count -= 0u"),
        mutant("skb+ofm", "< min(depth, own.depth)", "<= min(depth, own.depth)"),
        mutant("skb+ofm", "first = second", "first = first"),
        mutant("skb+ofm", "max(first, record.depth)", "first"),
        mutant("dfb+ofm", "= fragment.extra", "= fragment.depth"),
        mutant_part("skb+ofm", "words.x < words.y", "words.x > words.y"),
        mutant("mlab", "   last = carried;", "   last = node;"),
        mutant("mlab", "next.key.x), next.behind)", "next.key.x), no_light())"),
        mutant("mlab", "return MERGED", "return KEPT"),
        mutant("hybrid", "Wide(alpha, 1u << 8u)", "Wide(alpha, 1u)"),
        mutant("hybrid", "Inserted(MERGED, farthest)", "Inserted(MERGED, key)"),
        mutant("wboit", "* far * far", "* far"),
        mutant("wboit", "PASSING: u32 = 4u", "PASSING: u32 = 3u"),
        mutant("mbt", "power *= u", "power *= -u"),
        mutant("mbt", "EMPTY", "0u"),
        mutant("stochastic", "SAMPLES - i) < left", "SAMPLES) < left"),
        mutant("stochastic", "Wide(i + 1u, 0u)", "Wide(i, 0u)"),
        mutant_in("kb-ab-array", "a_buffer/ab_array", "return KEPT", "return CULLED"),
        mutant_in("kb-ab-ll", "a_buffer/ab_ll", "nodes.links[node] = ", "nodes.links[0] = "),
        mutant_in("kb-ab-sb", "a_buffer/s_buffer", "start + index", "start"),
        mutant("kplus", "array_append(pixel, count, key)", "put(pixel, count, key)"),
        mutant_in("kplus-sb@heap", "parts/max_heap", "is_less(above, key)", "is_less(key, above)"),
        mutant_in("ab-ll-bucket", "parts/buckets", "depth - near)", "far - depth)"),
        mutant("ab-ll-double", "previous[next] = node", "previous[next] = next"),
        mutant("ha64-multiset", "bool = false", "bool = true"),
        mutant("hash-coherent", "node = node_in(old)", "node += 0u"),
        mutant("depth-peel", "key + 1lu == begin", "key == begin"),
        mutant_in("depth-peel-dual", "parts/ends", "else if key == end", "else if key > end"),
        mutant("depth-peel-bucket", "atomicMax(", "atomicMin("),
        mutant("kplus-multi", "one_more(farthest), emitted", "farthest, emitted"),
        mutant("kb-multi", "nearer < K", "nearer <= K"),
        mutant("ha32", "age += 1u;\n    }\n    return AGE", "age += 2u;\n    }\n    return AGE"),
    ];
    for opened in all("mutants") {
        for mutant in mutants {
            let extent = conform::Extent { fragments: 3, programs: 30 };
            let found = conform(&opened.device, mutant, extent).expect("a device");
            if mutant.needs_atomics64() && !opened.device.atomics64 {
                assert!(found.unsupported.is_some(), "{found:?}");
                continue;
            }
            // One that sums the same group twice sums the only one there is.
            let equivalent = mutant.method.name() == "s-buffer";
            assert_eq!(found.difference.is_none(), equivalent, "{found:?}");
        }
    }
}

/// What resolve selects is in no word, so that pictures must show it.
#[test]
fn a_selection_of_others_than_the_nearest_is_seen() {
    let _turn = turn();
    let scene = scene("layers:count=6", [24, 16]);
    let selecting = "//# replaces shared/emit\n//# include shared/nearest\n";
    let mutants = [
        mutant("kb-ab-ll", selecting, ""),
        mutant_in("kb-ab-ll", "shared/nearest", "is_less(carried, other)", "false"),
        mutant_in("kb-ab-array", "shared/nearest", "ray.count < K {", "ray.count < 2u {"),
    ];
    for opened in all("selection") {
        for mutant in mutants {
            let options = Options { twins: vec![mutant], k: Some(3), ..Options::default() };
            for row in crosscheck(&opened, &scene, &options) {
                assert!(row.status == Status::Different && row.is_finding, "{row:?}");
            }
        }
    }
}

/// A pixel that always asks for another round is a failure, not a loop without end.
#[test]
fn rounds_without_end_are_stopped() {
    let _turn = turn();
    let endless = mutant("kplus-multi", "return any(begins[pixel] != DONE)", "return true");
    let scene = scene("layers:count=5", [16, 16]);
    for opened in all("rounds") {
        for (twin, right) in [(twin("kplus-multi"), Ok(())), (endless, Err(Failure::Endless(7)))] {
            let picture = Picture::new(&scene, opened.bits());
            let contract = twin.method.contract();
            let record = crosscheck::record(contract);
            let band = picture.whole();
            let shape = Shape::new(twin.method, band.config(contract, Some(2))).expect("a method");
            let constants = constants(&shape, record, picture.background);
            let program = Program::new(&opened.device, twin, shape, constants).expect("a program");
            let fragments = band.stream(contract, record, Some(1));
            let expected = band.expected(twin.method, record, Some(2));
            let geometry = |function: &str| program.compute(function, &fragments);
            let drawn = draw(&program, &picture.palette, expected.starts(), geometry);
            assert_eq!(drawn.map(|_| ()), right);
        }
    }
}
