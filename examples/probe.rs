use fragloom::explore::*;
use rayon::prelude::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let n: u32 = a[2].parse().unwrap();
    let s = subject(&a[1]).unwrap();
    let memory = match a[3].as_str() { "sc" => MemoryModel::Sequential, "vulkan" => MemoryModel::Relaxed(Profile::Vulkan), "glsl" => MemoryModel::Relaxed(Profile::Glsl), _ => MemoryModel::Relaxed(Profile::Wgsl) };
    let fam = Family { fragments: n, ks: vec![1,2,3], helpers: 0 };
    let t = std::time::Instant::now();
    let list = if a.len() > 4 { litmus::of_size(s.contract, &fam, n) } else { litmus::instances(s.contract, &fam) };
    let limits = Limits { states: 20_000_000, cancelled: &|| false };
    let out: Vec<_> = list.par_iter().map(|l| (l, explore(&s, l, Device { memory, warp: None }, &limits))).collect();
    let mut states = 0; let mut tr = 0;
    for (l, e) in &out {
        states += e.states; tr += e.transitions;
        if out.len() < 30 || !e.violations.is_empty() && false { println!("{} states {} tr {} exec {:?} outcomes {} claims {}", l.describe(), e.states, e.transitions, e.executions, e.outcomes.len(), e.claims); }
    }
    let mut seen = std::collections::BTreeMap::new();
    for (l, e) in &out { for (p, f) in &e.violations { seen.entry(*p).or_insert((l.describe(), f.message.clone(), f.schedule.len())); } }
    println!("{} instances {} states {} transitions {:?} complete {}", out.len(), states, tr, t.elapsed(), out.iter().all(|o| o.1.complete));
    println!("{seen:#?}");
}
