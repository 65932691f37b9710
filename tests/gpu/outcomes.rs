//! What explains outcomes of litmus pixels: those that an NVIDIA H200 showed, and a made-up one. No device is needed.

use fragloom::catalogue::{self, Catalogue};
use fragloom::explore::replay::replay;
use fragloom::explore::{Entry, Litmus, Subject, Token};
use fragloom::gpu::check::outcomes::{Class, Possible, copied};
use fragloom::scheme::Held;

/// What two runs counted of a method: outcomes that interleavings can give, over all litmus pixels; runs whose outcome
/// is of relaxed memory only, and runs whose outcome an earlier explorer did not have.
struct Recorded {
    method: &'static str,
    possible: u64,
    relaxed: [u64; 2],
    outside: [u64; 2],
}

const fn recorded(method: &'static str, possible: u64) -> Recorded {
    Recorded { method, possible, relaxed: [0; 2], outside: [0; 2] }
}

/// `crosscheck --litmus --repeats 1` on an NVIDIA H200, driver 580.159.04, twice; the second time only four methods.
const H200: [Recorded; 15] = [
    recorded("z-buffer", 12),
    recorded("ab-array", 12),
    recorded("ab-ll", 12),
    recorded("s-buffer", 12),
    recorded("dfb", 12),
    recorded("kb", 409),
    recorded("kb-mdt32", 44),
    recorded("kb-mdt64", 24),
    Recorded { relaxed: [168, 204], outside: [14, 20], ..recorded("ab-ll-paged", 12) },
    recorded("kb-ll", 24),
    Recorded { relaxed: [18, 13], ..recorded("kplus-array", 24) },
    Recorded { relaxed: [3, 1], ..recorded("kplus-heap", 24) },
    Recorded { relaxed: [2_354, 3_262], ..recorded("kplus-sb", 24) },
    recorded("ha64", 12),
    recorded("ha32", 6),
];

/// The outcomes that were printed: of `ab-ll-paged`, two fragments 0/20 and fffffffe/10. One invocation has read the
/// counter that the other wrote, but not yet its page; so its record went outside of the buffer, and resolve read
/// zeros in its place, which nobody had written.
const PRINTED: [[u64; 2]; 2] = [[0, 0xFFFF_FFFE_0000_0010], [0, 0x20]];

fn subject(method: &str) -> Subject {
    Subject::new(catalogue::method(method).expect("a method")).expect("it has invocations")
}

fn two() -> Litmus {
    let fragments = vec![Entry(0, 0, 0x20, 0), Entry(0, 0xFFFF_FFFE, 0x10, 0)];
    Litmus { room: 2, fragments, ..Litmus::of_one(subject("ab-ll-paged").contract) }
}

/// What the run of a token holds in the end.
fn held_after(token: &str) -> Vec<Held> {
    let Ok(Token::Litmus(token)) = token.parse() else { panic!("a token of a litmus pixel") };
    let replayed = replay(&Catalogue::built_in(), &token).expect("it runs again");
    replayed.run.end.expect("it ends").pixels
}

#[test]
fn what_an_h200_printed_is_relaxed_and_has_a_schedule() {
    let subject = subject("ab-ll-paged");
    let litmus = two();
    assert!(copied(&subject, 2).contains(&litmus), "it is among those that are run");
    let mut possible = Possible::new(&subject, &litmus).expect("few states");
    for keys in PRINTED {
        let held = Held::Keys(keys.to_vec());
        let found = possible.explain(&held, 0, 7).expect("it runs again");
        assert_eq!((found.class, found.runs, found.complete), (Class::Relaxed, 7, true));
        let token = found.token.expect("a schedule");
        println!("{}: {token}", found.outcome);
        assert_eq!(held_after(&token), [held]);
    }
}

/// The same outcome classes as recorded: as many outcomes of interleavings, and where runs were relaxed there are
/// outcomes that only relaxed memory gives, each with a schedule that gives it.
#[test]
fn an_h200_showed_relaxed_outcomes_where_there_are_some() {
    for Recorded { method, possible, relaxed, outside } in H200 {
        let subject = subject(method);
        let (mut interleavings, mut weak) = (0, 0);
        let seen = relaxed.iter().chain(&outside).any(|&runs| runs > 0);
        let mut known: Vec<Litmus> = Vec::new();
        for litmus in copied(&subject, 3) {
            // Copies of a hash table's pixel share one table: one instance of those with equal fragments is run.
            if subject.contract.crosses() && known.iter().any(|l| l.fragments == litmus.fragments) {
                continue;
            }
            let mut all = Possible::new(&subject, &litmus).expect("few states");
            let mut kept = litmus.generated(0);
            subject.contract.keep(&mut kept, None);
            let whole = Held::Keys(kept);
            if subject.contract.crosses() && !all.interleavings().eq([&whole]) {
                continue;
            }
            interleavings += all.interleavings().count() as u64;
            if seen && litmus.fragments.len() == 2 {
                let outcomes: Vec<Vec<Held>> = all.relaxed().outcomes.keys().cloned().collect();
                for pixels in outcomes {
                    let found = all.explain(&pixels[0], 0, 1).expect("it runs again");
                    assert_ne!(found.class, Class::Outside, "{method}: {}", pixels[0]);
                    if let Some(token) = found.token {
                        assert_eq!(held_after(&token), pixels, "{method}");
                        weak += 1;
                    }
                }
            }
            known.push(litmus);
        }
        println!("{method}: {interleavings} of interleavings, {weak} of relaxed memory");
        assert_eq!((interleavings, weak > 0), (possible, seen), "{method}");
    }
}

#[test]
fn what_nothing_gives_is_outside() {
    let subject = subject("ab-ll-paged");
    let litmus = two();
    let mut possible = Possible::new(&subject, &litmus).expect("few states");
    let right = Held::Keys(litmus.generated(0));
    let found = possible.explain(&right, 0, 1).expect("known");
    assert_eq!((found.class, found.token), (Class::SequentiallyConsistent, None));
    // A fragment that was never generated; and the right list, with a word too many.
    let never = Held::Keys(vec![0x20, 0x21]);
    for (held, beyond) in [(&never, 0), (&right, 1)] {
        let found = possible.explain(held, beyond, 1).expect("explored");
        assert_eq!((found.class, found.token, found.complete), (Class::Outside, None, true));
        assert_eq!(found.outcome.contains("1 more"), beyond > 0, "{}", found.outcome);
    }
}
