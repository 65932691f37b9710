//! The exhaustive explorer: states and moves a second on one core, median of some turns. The goal is a million states a
//! second under sequential consistency.

mod support;

use fragloom::catalogue;
use fragloom::explore::program::instances::of_size;
use fragloom::explore::{Conditions, Family, Limits, MemoryModel, Profile, Subject, explore};
use support::{median, time};

const TURNS: usize = 5;

const CASES: [(&str, u32, u32, MemoryModel); 6] = [
    ("kplus-array", 6, 1, MemoryModel::Sequential),
    ("kplus-array", 6, 2, MemoryModel::Sequential),
    ("kplus-array", 6, 3, MemoryModel::Sequential),
    ("ab-ll", 4, 1, MemoryModel::Sequential),
    ("kplus-array", 3, 2, MemoryModel::Relaxed(Profile::Vulkan)),
    ("ab-ll", 3, 1, MemoryModel::Relaxed(Profile::Vulkan)),
];

fn main() {
    println!(
        "{:<14} {:>2} {:>2} {:<15} {:>9} {:>9} {:>8} {:>10} {:>10}",
        "method", "n", "k", "memory", "states", "moves", "seconds", "Mstates/s", "Mmoves/s"
    );
    for (method, n, k, memory) in CASES {
        let method = catalogue::method(method).expect("a built-in method");
        let subject = Subject::new(method).expect("it has invocations");
        let family = Family { fragments: n, ks: vec![k], helpers: 0 };
        let instances = of_size(&subject, &family, n);
        let Some(litmus) = instances.first() else { continue };
        let limits = Limits { states: 50_000_000, cancelled: &|| false };
        let conditions = Conditions { memory, warp: None };
        let mut size = (0, 0);
        let turn = |_| {
            time(|| {
                let explored = explore(&subject, litmus, conditions, &limits);
                size = (explored.states, explored.transitions);
            })
        };
        let seconds = median((0..TURNS).map(turn).collect());
        let rate = |count: usize| count as f64 * 1e-6 / seconds;
        println!(
            "{method:<14} {n:>2} {k:>2} {:<15} {:>9} {:>9} {seconds:>8.3} {:>10.2} {:>10.2}",
            memory.to_string(),
            size.0,
            size.1,
            rate(size.0),
            rate(size.1)
        );
    }
}
