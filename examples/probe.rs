use fragloom::explore::*;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let limits = Limits { states: 3_000_000, cancelled: &|| false };
    let plan = Plan {
        fragments: a.get(2).and_then(|n| n.parse().ok()),
        progress: Progress::ALL.to_vec(),
        ..Plan::default()
    };
    let t = std::time::Instant::now();
    let rows = match a[1].as_str() {
        "matrix" => {
            for l in matrix::matrix(None, &plan, &limits).unwrap() {
                println!(
                    "{:10} {:36} {:10?} {}",
                    l.mutation,
                    l.method,
                    l.fate,
                    l.kills
                        .iter()
                        .map(|k| format!(
                            "{}:{} n={} steps={} states={}",
                            k.check,
                            k.property,
                            &k.instance[2..3],
                            k.steps,
                            k.states
                        ))
                        .collect::<Vec<_>>()
                        .join(" | ")
                );
            }
            vec![]
        }
        c if c.starts_with('C') => claims::claim_by_id(c)
            .unwrap()
            .check(
                &[],
                &Plan {
                    memory: vec![
                        MemoryModel::Sequential,
                        MemoryModel::Relaxed(Profile::Vulkan),
                        MemoryModel::Relaxed(Profile::Glsl),
                        MemoryModel::Relaxed(Profile::Wgsl),
                    ],
                    ..plan
                },
                &limits,
            )
            .unwrap(),
        m => check(&subject(m).unwrap(), &plan, &limits),
    };
    for r in rows {
        println!(
            "{} {:?} {:9} {:?} ex={} {} {:?}/{:?} {:?} [{}] exec {:?} states {} steps {:?} {} {:?} {}",
            r.method,
            r.property,
            r.verdict.name(),
            r.claim,
            r.exhaustive,
            r.memory,
            r.profile,
            r.progress,
            r.instance,
            "",
            r.executions,
            r.states,
            r.steps,
            r.message,
            r.outcomes,
            r.token.unwrap_or_default()
        );
    }
    println!("{:?}", t.elapsed());
}
