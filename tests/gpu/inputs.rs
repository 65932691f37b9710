//! A twin that reads an input: the words that an application fills reach a device's invocations.

use fragloom::exec::Method;
use fragloom::fragment::Fragment;
use fragloom::gpu::check::conform::{Extent, conform};
use fragloom::gpu::twin::source::{Form, Twin};
use fragloom::memory::{Atomic, Declared, Input, Layout, Memory, Order, Per, Pixel, Plain, Words};
use fragloom::scheme::contract::Dependence;
use fragloom::scheme::{Config, Contract, Keeps, Keys, Outcome, Scheme};

use super::drivers::{all, turn};

/// Slots of a pixel.
const SLOTS: u32 = 4;

/// An array of slots of which an image says how many a pixel may use.
struct Capped {
    counter: Words<Pixel, Atomic, u32>,
    records: Words<Pixel, Plain, u64>,
    cap: Input,
}

impl Scheme for Capped {
    const CONTRACT: Contract = Contract {
        words: "9",
        dependence: Dependence::Arrival,
        ..Contract::new("capped", Keeps::FirstArrivals)
    };

    type Holds = Keys;

    fn new(_: &Config, layout: &mut Layout) -> Self {
        let cap = Declared { name: "cap", per: Per::Pixel, default: SLOTS, tried: &[0, 1, 3] };
        Self {
            counter: layout.pixel(1),
            records: layout.pixel(SLOTS.into()),
            cap: layout.input(cap),
        }
    }

    async fn clear<M: Memory>(&self, mem: &M, pixel: u32) {
        mem.store(self.counter.at(pixel, 0), 0, Order::Relaxed).await;
    }

    async fn store<M: Memory>(&self, mem: &M, fragment: Fragment) -> Outcome {
        let slot = mem.add(self.counter.at(fragment.pixel, 0), 1, Order::Relaxed).await;
        if slot >= mem.input(self.cap.at(fragment.pixel)) {
            return Outcome::Overflow;
        }
        mem.plain_store(self.records.at(fragment.pixel, slot), fragment.key()).await;
        Outcome::Kept
    }

    async fn resolve<M: Memory>(&self, mem: &M, pixel: u32, keys: &mut Keys) {
        let count = mem.load(self.counter.at(pixel, 0), Order::Relaxed).await;
        for slot in 0..count.min(mem.input(self.cap.at(pixel))) {
            keys.push(mem.plain_load(self.records.at(pixel, slot)).await);
        }
    }
}

const TEXT: &str = "
//# include shared/fragment
//# include shared/emit

struct Pixel {
    counter: atomic<u32>,
}

struct Records {
    slots: array<Key, 4>,
}

@group(0) @binding(0) var<storage, read_write> pixels: array<Pixel>;
@group(0) @binding(1) var<storage, read_write> records: array<Records>;
@group(0) @binding(5) var<storage, read> inputs: array<u32>;

fn clear(pixel: u32) {
    atomicStore(&pixels[pixel].counter, 0u);
}

fn store(fragment: Fragment) -> u32 {
    let slot = atomicAdd(&pixels[fragment.pixel].counter, 1u);
    if slot >= inputs[INPUT_CAP + fragment.pixel] {
        return OVERFLOW;
    }
    records[fragment.pixel].slots[slot] = key_of(fragment);
    return KEPT;
}

fn resolve(pixel: u32) {
    let count = atomicLoad(&pixels[pixel].counter);
    for (var slot = 0u; slot < min(count, inputs[INPUT_CAP + pixel]); slot++) {
        emit(records[pixel].slots[slot]);
    }
}
";

#[test]
fn a_twin_reads_its_inputs() {
    let _turn = turn();
    let method = Method::of::<Capped>();
    let extent = Extent { fragments: 3, programs: 24 };
    for opened in all("inputs") {
        let twin = Twin { method, text: TEXT, form: Form::Wgsl };
        let found = conform(&opened.device, twin, extent).expect("a device");
        assert_eq!((&found.difference, &found.unsupported), (&None, &None), "{found:?}");
        assert!(found.steps > 100, "{found:?}");
        // Another pixel's word, and none.
        for to in ["inputs[INPUT_CAP]", "4u"] {
            let text = TEXT.replacen("inputs[INPUT_CAP + fragment.pixel]", to, 1);
            let mutant = Twin { text: text.leak(), ..twin };
            let found = conform(&opened.device, mutant, extent).expect("a device");
            assert!(found.difference.is_some(), "{to}: {found:?}");
        }
    }
}
