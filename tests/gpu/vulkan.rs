//! Twins in their Vulkan form: acquire and release are where the methods' sources have them, nothing else changes, and
//! the results are the same.

use fragloom::gpu::check::conform::{self, conform};
use fragloom::gpu::check::crosscheck::{Options, Path as By, Status};
use fragloom::gpu::check::open::Opened;
use fragloom::gpu::check::stress::{self, stress};
use fragloom::gpu::driver::failure::Failure;
use fragloom::gpu::spirv::orders::{Order, ordered};
use fragloom::gpu::spirv::write::{Entry, Source};
use fragloom::gpu::twin::program::Program;
use fragloom::gpu::twin::shape::{Shape, constants};
use fragloom::gpu::twin::source::{Path, Twin, twins};
use fragloom::num::depth::Format;
use fragloom::raster::Record;
use fragloom::scheme::Config;
use rspirv::dr::{Instruction, Module, Operand, load_words};
use rspirv::spirv::{Decoration, Op, Scope, StorageClass};

use super::drivers::{all, crosscheck, turn, twin};
use super::mutants::{mutant, mutant_in};
use super::support::{contract, scene, small_scenes};
use super::text::modules;

/// Operations that acquire, and that release, of each twin that has any: as many as its method's source has.
const COUNTS: [(&str, usize, usize); 8] = [
    ("ab-ll-paged", 1, 1),
    // The head and a link.
    ("kb-ll", 2, 2),
    // The lock, and the counter that is read without it.
    ("kplus-array", 2, 2),
    ("kplus-heap", 2, 2),
    ("kplus-sb", 2, 2),
    ("k-variable", 2, 2),
    ("skb+ofm", 1, 1),
    ("mlab", 1, 1),
];

/// Every binding that a twin can have, under its own number.
const BINDINGS: [&[u32]; 2] = [&[0, 1, 2, 3, 4, 5], &[0, 1, 2, 3]];

fn entry(name: &str) -> Entry<'_> {
    Entry { name, overrides: &[], bindings: &BINDINGS }
}

/// The SPIR-V of a store pass.
fn written(text: &str, entry: &Entry<'_>) -> Vec<u32> {
    Source::new(text).expect("a module").words(entry).expect("SPIR-V")
}

fn loaded(words: &[u32]) -> Module {
    load_words(words).expect("a module")
}

fn instructions(module: &Module) -> impl Iterator<Item = &Instruction> {
    module.functions.iter().flat_map(|f| &f.blocks).flat_map(|block| &block.instructions)
}

/// The value of a constant.
fn value(module: &Module, operand: &Operand) -> u32 {
    let id = operand.id_ref_any().expect("a constant's number");
    let defined = module.types_global_values.iter().find(|one| one.result_id == Some(id));
    match defined.expect("a constant").operands[0] {
        Operand::LiteralBit32(value) => value,
        ref other => panic!("{other:?}"),
    }
}

/// Atomic operations and memory barriers with an order. Every scope is the device.
fn counts(module: &Module, order: Order) -> [usize; 2] {
    let mut found = [0; 2];
    for instruction in instructions(module) {
        let (scope, place) = match instruction.class.opcode {
            Op::MemoryBarrier => (0, 1),
            _ if is_atomic(instruction) => (1, 0),
            _ => continue,
        };
        assert_eq!(value(module, &instruction.operands[scope]), Scope::Device as u32);
        let semantics = value(module, &instruction.operands[scope + 1]);
        found[place] += usize::from(semantics == order.semantics().bits());
    }
    found
}

fn is_atomic(instruction: &Instruction) -> bool {
    instruction.class.opname.starts_with("Atomic")
}

/// The instructions without orders and barriers; constants by their values.
fn without_orders(module: &Module) -> Vec<Instruction> {
    let mut kept = Vec::new();
    for instruction in instructions(module) {
        let mut instruction = instruction.clone();
        if instruction.class.opcode == Op::MemoryBarrier {
            continue;
        }
        if is_atomic(&instruction) {
            instruction.operands.retain(|operand| {
                !matches!(operand, Operand::IdScope(_) | Operand::IdMemorySemantics(_))
            });
        }
        kept.push(instruction);
    }
    kept
}

#[test]
fn acquire_and_release_are_where_the_sources_have_them() {
    for (method, acquires, releases) in COUNTS {
        for (number, (_, text)) in modules(twin(method)).into_iter().enumerate() {
            let name = if number % 2 == 0 { "store_pass" } else { "store_raster" };
            let before = written(&text, &entry(name));
            let after = ordered(&before).expect("orders").expect("functions with orders");
            let (before, after) = (loaded(&before), loaded(&after));
            for (order, expected) in Order::ALL.into_iter().zip([acquires, releases]) {
                assert_eq!(counts(&before, order), [0, 0], "{method} {name}");
                assert_eq!(counts(&after, order), [expected; 2], "{method} {name} {order:?}");
            }
            assert_eq!(without_orders(&before), without_orders(&after), "{method} {name}");
        }
    }
}

/// What a method's other passes do stands between barriers anyway.
#[test]
fn passes_without_orders_stay_as_they_are() {
    for (method, ..) in COUNTS {
        let (_, text) = modules(twin(method)).remove(0);
        for name in ["clear_pass", "resolve_pass"] {
            assert_eq!(ordered(&written(&text, &entry(name))), Ok(None), "{method} {name}");
        }
    }
}

/// With plain variables, a driver may keep values where other invocations do not see them.
#[test]
fn buffers_are_coherent() {
    for (method, ..) in COUNTS {
        let (_, text) = modules(twin(method)).remove(0);
        let module = loaded(&written(&text, &entry("store_pass")));
        let with = |decoration| {
            let is = move |one: &&Instruction| {
                one.operands.get(1) == Some(&Operand::Decoration(decoration))
            };
            module.annotations.iter().filter(is).map(|one| one.operands[0].clone())
        };
        let coherent: Vec<Operand> = with(Decoration::Coherent).collect();
        let read_only: Vec<Operand> = with(Decoration::NonWritable).collect();
        let storage = Operand::StorageClass(StorageClass::StorageBuffer);
        let mut found = 0;
        for variable in &module.types_global_values {
            if variable.class.opcode == Op::Variable && variable.operands[0] == storage {
                let id = Operand::IdRef(variable.result_id.expect("a number"));
                assert_ne!(coherent.contains(&id), read_only.contains(&id), "{method}");
                found += 1;
            }
        }
        assert!(found >= 2, "{method}: words and fragments");
    }
}

/// Methods that are outside of what WGSL guarantees, and order nothing that a form could.
const WITHOUT: &[&str] = &["ab-ll-double"];

#[test]
fn what_wgsl_does_not_guarantee_has_a_vulkan_form() {
    let mut without = Vec::new();
    for twin in twins() {
        let within = twin.method.contract().is_within_wgsl();
        let name = twin.method.name();
        assert_eq!(twin.not_guaranteed().is_empty(), within, "{name}");
        match twin.vulkan() {
            None if within => {}
            None => without.push(name),
            Some(vulkan) => {
                assert!(!within || name.contains('@'), "{name}");
                assert_eq!(
                    (twin.name(), vulkan.name()),
                    (name.to_owned(), format!("{name}/vulkan"))
                );
                // What does not wait for a lock needs no progress of its holder.
                let base = name.split('@').next().unwrap_or(name);
                assert_eq!(vulkan.not_guaranteed().is_empty(), base == "kb-ll", "{name}");
            }
        }
    }
    assert_eq!(without, WITHOUT);
    assert!(COUNTS.iter().all(|(name, ..)| twin(name).vulkan().is_some()));
}

/// A function with another name orders nothing; one whose operations cannot have its order is an error.
#[test]
fn a_mark_that_is_lost_or_misplaced_is_found() {
    let of = |twin: Twin| {
        let (_, text) = modules(twin).remove(0);
        ordered(&written(&text, &entry("store_pass")))
    };
    let unread =
        loaded(&of(mutant("kplus-array", "acquire_count", "plain_count")).unwrap().unwrap());
    assert_eq!(Order::ALL.map(|order| counts(&unread, order)), [[1; 2], [2; 2]]);
    let renamed = |to: &str| {
        let part = mutant_in("kplus-array", "reach/pixel_rows", "release_count", to);
        Twin { text: part.text.replace("release_count", to).leak(), ..part }
    };
    let unraised = loaded(&of(renamed("raise_count")).unwrap().unwrap());
    assert_eq!(Order::ALL.map(|order| counts(&unraised, order)), [[2; 2], [1; 2]]);
    let read = mutant("kplus-array", "acquire_count", "release_read");
    for (found, to) in [(read, "release_read"), (renamed("acquire_write"), "acquire_write")] {
        let found = of(found);
        let error = found.expect_err("a load cannot release, and a store cannot acquire");
        assert!(error.to_string().contains(to), "{error}");
    }
}

/// On a device, a twin that names only one of the orders is refused.
#[test]
fn both_orders_must_be_there() {
    let _turn = turn();
    for opened in all("missing marks") {
        for (part, from, to) in [
            ("parts/lock", "acquire_lock", "take_lock"),
            ("parts/unlock", "release_lock", "free_lock"),
        ] {
            let half = mutant_in("ab-ll-paged", part, from, to);
            let half = Twin { text: half.text.replace(from, to).leak(), ..half };
            let half = half.vulkan().expect("the other order");
            let shape = Shape::new(half.method, Config::default()).expect("a method");
            let record = Record { depth: Format::D32, data: fragloom::fragment::Data::Color };
            let constants = constants(&shape, record, [0; 3]);
            let text = half.module(&constants, Path::Compute).expect("a text");
            assert!(Source::new(&text).is_ok());
            let found = Program::new(&opened.device, half, shape, constants).map(|_| ());
            let missing = format!("no function {}_", &from[..7]);
            match found {
                Err(Failure::Invalid(problem)) => assert!(problem.contains(&missing), "{problem}"),
                found => assert!(!opened.device.spirv, "{found:?}"),
            }
        }
    }
}

/// Whether a driver can be held to its results where operations are ordered. In compute shaders, lavapipe of Mesa 22.3
/// then leaves out what invocations do later, also those that run alone: with the orders only, with the barriers only,
/// and not without both. Khronos' validator finds no fault in the SPIR-V.
fn keeps_orders(opened: &Opened) -> bool {
    opened.device.spirv && !opened.device.name.name.contains("llvmpipe")
}

fn forms() -> Vec<Twin> {
    twins().into_iter().filter_map(Twin::vulkan).collect()
}

#[test]
fn invocations_do_the_same_in_both_forms() {
    let _turn = turn();
    for opened in all("the conformance of Vulkan forms") {
        assert_eq!(opened.device.spirv, opened.device.name.backend == "vulkan");
        for twin in forms() {
            // Slabs have many more litmus pixels.
            let programs = if twin.method.name() == "skb+ofm" { 4 } else { 12 };
            let extent = conform::Extent { fragments: 3, programs };
            let found = conform(&opened.device, twin, extent).expect("a device");
            assert_eq!(found.method, twin.name());
            assert_eq!(found.unsupported.is_none(), opened.device.spirv, "{found:?}");
            if keeps_orders(&opened) {
                assert_eq!(found.difference, None, "{found:?}");
            }
            assert!(found.steps > 50 || !opened.device.spirv, "{found:?}");
        }
        let wrong =
            mutant("kplus-array", "array_append(pixel, count, key)", "put(pixel, count, key)");
        let wrong = wrong.vulkan().expect("orders");
        let extent = conform::Extent { fragments: 3, programs: 30 };
        let found = conform(&opened.device, wrong, extent).expect("a device");
        assert!(found.difference.is_some() || !opened.device.spirv, "{found:?}");
    }
}

#[test]
fn scenes_are_the_same_in_both_forms() {
    let _turn = turn();
    for opened in all("Vulkan forms") {
        let (options, mut compared) = (Options { twins: forms(), ..Options::default() }, [0, 0]);
        for scene in small_scenes() {
            for row in crosscheck(&opened, &scene, &options) {
                if row.path == By::Compute && !keeps_orders(&opened) {
                    continue;
                }
                assert!(!row.is_finding, "{row:?}");
                let name = row.method.strip_suffix("/vulkan").expect("the form's name");
                if row.status == Status::Unsupported {
                    let no_raster = row.path == By::Raster && row.reason.contains("compute path");
                    assert!(no_raster || !opened.device.spirv, "{row:?}");
                } else if contract(name).order_independent() {
                    assert_eq!(row.status, Status::Equal, "{row:?}");
                    compared[usize::from(row.path == By::Compute)] += row.differences.fragments;
                }
            }
        }
        println!("{}: {compared:?} fragments compared", opened.device.name.name);
        let [raster, compute] = compared;
        assert!(raster > 50_000 || !opened.device.spirv);
        assert!(compute > 50_000 || !keeps_orders(&opened));
    }
}

#[test]
fn litmus_pixels_have_outcomes_of_interleavings() {
    let _turn = turn();
    for opened in all("litmus pixels of Vulkan forms") {
        for method in ["kplus-array", "kb-ll", "ab-ll-paged"] {
            let twin = twin(method).vulkan().expect("orders");
            let extent =
                stress::Extent { fragments: 3, repeats: 1, instances: usize::MAX, pressure: None };
            let found = stress(&opened.device, twin, extent).expect("a device");
            assert_eq!(found.status == Status::Unsupported, !opened.device.spirv, "{found:?}");
            if keeps_orders(&opened) {
                assert_eq!((found.outside, found.relaxed), (0, 0), "{found:?}");
            }
            assert!(found.seen > 0 || !opened.device.spirv, "{found:?}");
        }
    }
}

#[test]
fn a_device_without_spirv_says_so() {
    let _turn = turn();
    for mut opened in all("a device without SPIR-V") {
        opened.device.spirv = false;
        let options = Options { twins: forms(), ..Options::default() };
        for row in crosscheck(&opened, &scene("gears", [24, 16]), &options) {
            assert_eq!((row.status, row.is_finding), (Status::Unsupported, false), "{row:?}");
            assert!(row.reason.contains("SPIR-V") || row.reason.contains("compute"), "{row:?}");
        }
    }
}
