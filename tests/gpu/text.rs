//! What can be known of twins without a driver.

use fragloom::catalogue::Catalogue;
use fragloom::exec::Method;
use fragloom::fragment::Data;
use fragloom::gpu::twin::shape::{Shape, constants};
use fragloom::gpu::twin::source::{self, Path, Twin, twins};
use fragloom::num::depth::Format;
use fragloom::raster::{Grid, Record};
use fragloom::scheme::Config;
use fragloom::scheme::hash_table::table::TableSettings;
use fragloom::scheme::program::PassKind;
use naga::valid::{Capabilities, ValidationFlags, Validator};

use super::support::method;

/// Configurations of different character: few and many fragments, small and large k.
fn configs() -> Vec<Config> {
    let grid = Grid { width: 40, height: 30, tile: 16 };
    let config = |k, generated: u64, most: u32| Config {
        k,
        pixels: grid.storage_pixels() as u32,
        generated,
        max_depth_complexity: most,
        bounded: generated,
        pages: generated.div_ceil(4),
        grid,
        table: TableSettings { size: [48, 48], ..TableSettings::default() },
        records: generated.div_ceil(2),
        mask_words: 1 + most,
        ..Config::default()
    };
    vec![
        config(None, 1_000, 7),
        config(Some(1), 1, 1),
        config(Some(20), 123_456, 300),
        config(None, 0, 0),
    ]
}

/// The twin of a method that has one.
fn twin(method: &str) -> Twin {
    source::twin(self::method(method)).expect("a twin")
}

/// Its modules under several configurations; every second one is of the raster path.
pub(super) fn modules(twin: Twin) -> Vec<(Shape, String)> {
    let mut modules = Vec::new();
    for config in configs() {
        let shape = Shape::new(twin.method, config).expect("a method");
        for (depth, data) in [(Format::D32, Data::Primitive), (Format::D24, Data::Nothing)] {
            let constants = constants(&shape, Record { depth, data }, [1, 2, 3]);
            let raster = constants
                .clone()
                .with_signed("CENTER_X", -5)
                .with_signed("CENTER_Y", 1 << 20)
                .with_power("PER_HALF_VIEWPORT", -20)
                .with("BAND_TOP", 16);
            for (constants, path) in [(constants, Path::Compute), (raster, Path::Raster)] {
                let text = twin.module(&constants, path).expect("a module");
                modules.push((shape.clone(), text));
            }
        }
    }
    modules
}

fn parse(Twin { method, .. }: Twin, text: &str) -> naga::Module {
    naga::front::wgsl::parse_str(text)
        .unwrap_or_else(|error| panic!("{method}: {}", error.emit_to_string(text)))
}

#[test]
fn naga_validates_every_twin() {
    for twin in twins() {
        for (_, text) in modules(twin) {
            let module = parse(twin, &text);
            let mut needs = Capabilities::empty();
            if twin.needs_atomics64() {
                needs = Capabilities::SHADER_INT64 | Capabilities::SHADER_INT64_ATOMIC_ALL_OPS;
            }
            Validator::new(ValidationFlags::all(), needs)
                .validate(&module)
                .unwrap_or_else(|e| panic!("{}: {}", twin.method, e.emit_to_string(&text)));
        }
    }
}

/// A buffer of the first group has exactly the layout's words, where these are not empty: pixel after pixel, or the
/// frame's up to an array whose length is the buffer's.
#[test]
fn words_are_where_the_simulator_has_them() {
    for twin in twins() {
        for (shape, text) in modules(twin) {
            let module = parse(twin, &text);
            let (pixel, frame) = (shape.layout.per_pixel(), shape.layout.per_frame());
            let sizes =
                [4 * pixel.words32, 8 * pixel.words64, 4 * frame.words32, 8 * frame.words64];
            for (binding, &words) in (0..).zip(&sizes) {
                let found = size_of_element(&module, binding);
                let what = format!("{} binding {binding}: {words} bytes", twin.method);
                match found {
                    None => assert_eq!(words, 0, "{what}, and none declared"),
                    Some(_) if words == 0 => {}
                    Some((size, _)) if binding < 2 => assert_eq!(size, words, "{what}"),
                    // Arrays that would be empty have one element.
                    Some((size, true)) if shape.config.generated == 0 => {
                        assert!(size < words + 64, "{what}, {size}");
                    }
                    Some((size, true)) => {
                        assert!(size <= words && (words - size) % 4 == 0, "{what}, {size}");
                    }
                    Some((size, false)) => assert!(size == words || words < 64, "{what}, {size}"),
                }
            }
        }
    }
}

/// Bytes of an element of the runtime-sized array that a binding is, or of a struct without the array that it ends in,
/// or of the whole; and whether there is such an array.
fn size_of_element(module: &naga::Module, binding: u32) -> Option<(u64, bool)> {
    let at = naga::ResourceBinding { group: 0, binding };
    let (_, variable) = module.global_variables.iter().find(|(_, v)| v.binding == Some(at))?;
    let mut layouter = naga::proc::Layouter::default();
    layouter.update(module.to_ctx()).expect("a layout");
    let bytes = |ty| u64::from(layouter[ty].size);
    let is_dynamic = |ty| {
        matches!(
            module.types[ty].inner,
            naga::TypeInner::Array { size: naga::ArraySize::Dynamic, .. }
        )
    };
    Some(match &module.types[variable.ty].inner {
        naga::TypeInner::Array { base, size: naga::ArraySize::Dynamic, .. } => {
            if binding < 2 {
                (bytes(*base), true)
            } else {
                (0, true)
            }
        }
        naga::TypeInner::Struct { members, .. } => match members.last() {
            Some(last) if is_dynamic(last.ty) => (last.offset.into(), true),
            _ => (bytes(variable.ty), false),
        },
        _ => (bytes(variable.ty), false),
    })
}

#[test]
fn twins_define_the_passes_of_their_programs() {
    for twin in twins() {
        let contract = twin.method.contract();
        let has = |kind| contract.program.passes.iter().any(|pass| pass.kind == kind);
        for (function, needed) in [
            ("prepare", has(PassKind::Prepare)),
            ("screen", has(PassKind::Screen)),
            ("frame", has(PassKind::Frame)),
            ("clear", true),
            ("store", true),
            ("resolve", true),
        ] {
            assert_eq!(twin.defines(function), needed, "{}: {function}", twin.method);
        }
        assert_eq!(twin.defines("again"), contract.program.repeats, "{}", twin.method);
    }
}

#[test]
fn contracts_say_how_wgsl_expresses_what_has_a_twin() {
    for twin in twins() {
        let contract = twin.method.contract();
        assert!(contract.wgsl.is_some(), "{}", twin.method);
        let publishes = ["kb-ll", "ab-ll-double"].contains(&contract.base_name());
        assert_eq!(contract.is_within_wgsl(), !(twin.locks() || publishes), "{}", twin.method);
    }
    assert!(source::twin(Method::EXACT).is_none());
}

/// A method without a twin is named in the documentation, with the reason.
#[test]
fn what_has_no_twin_is_documented() {
    let page = include_str!("../../docs/gpu.md");
    let table = page.split("These have no twin").nth(1).expect("the table");
    let section = table.split("\n## ").next().expect("its section");
    let named: Vec<&str> = section.lines().filter_map(|line| line.split('|').nth(1)).collect();
    for method in Catalogue::built_in().promised() {
        let name = method.name();
        let listed = named.iter().any(|cell| cell.contains(&format!("`{name}`")));
        if !name.contains('@') && method != Method::EXACT {
            assert_eq!(listed, source::twin(method).is_none(), "{name}");
        }
    }
}

#[test]
fn a_file_is_included_once_and_unknown_ones_are_refused() {
    let (_, text) = modules(twin("kplus-sb")).remove(0);
    assert_eq!(text.matches("struct Fragment {").count(), 1);
    assert!(!text.contains("//# include"));
    let wrong = Twin { text: "//# include shared/nothing\n", ..twin("ab-ll") };
    let error = wrong.module(&Default::default(), Path::Compute).expect_err("no such file");
    assert!(error.to_string().contains("shared/nothing"), "{error}");
    let wrong = Twin { text: "//# replaces shared/nothing\n", ..twin("ab-ll") };
    let error = wrong.module(&Default::default(), Path::Compute).expect_err("no such file");
    assert!(error.to_string().contains("shared/nothing"), "{error}");
}

/// What replaces a part stands instead of it, wherever the part is included.
#[test]
fn a_part_is_replaced_by_what_follows() {
    let [plain, heap] = ["kplus-sb", "kplus-sb@heap"].map(|name| modules(twin(name)).remove(0).1);
    for (text, up_to) in [(plain, 16), (heap, 0)] {
        assert_eq!(text.matches("const ARRAY_UP_TO").count(), 1);
        assert!(text.contains(&format!("const ARRAY_UP_TO: u32 = {up_to}u;")));
    }
    assert!(twin("kplus-sb@heap").locks() && twin("kplus-sb@heap").waits());
    assert!(!twin("kb-ab-ll").locks() && !twin("kb-ab-ll").waits());
}

#[test]
fn a_faulty_text_is_not_valid() {
    let (_, text) = modules(twin("ab-ll")).remove(0);
    let wrong = text.replace("atomicAdd(&nodes.taken, 1u)", "atomicAdd(&nodes.taken, 1.0)");
    assert_ne!(text, wrong);
    let valid = naga::front::wgsl::parse_str(&wrong).is_ok_and(|module| {
        Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).is_ok()
    });
    assert!(!valid);
}
