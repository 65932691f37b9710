//! Tokens: whatever happens to one on its way, it is refused with a reason, or it is the one that was sent.

use fragloom::catalogue::{self, Catalogue};
use fragloom::explore::{Finding, Limits, Plan, Subject, Token, check, replay};
use proptest::prelude::*;

const LIMITS: Limits<'static> = Limits { states: 1_000_000, cancelled: &|| false };

fn subject(method: &str) -> Subject {
    Subject::new(catalogue::method(method).expect("a method")).expect("it has invocations")
}

fn small() -> Plan {
    Plan { fragments: Some(2), ks: vec![1, 2], ..Plan::default() }
}

/// Tokens of different kinds: memory models, a cycle, ties, several pixels.
fn tokens() -> &'static [String] {
    static TOKENS: std::sync::OnceLock<Vec<String>> = std::sync::OnceLock::new();
    TOKENS.get_or_init(|| {
        let of = |method: &str| check(&subject(method), &small(), &LIMITS);
        let methods = ["kb", "kplus-array@M1", "kplus-array@M19", "ab-ll@M14"];
        let rows: Vec<Finding> = methods.into_iter().flat_map(of).collect();
        rows.into_iter().filter_map(|row| row.token).collect()
    })
}

/// Those that pages of `docs/` show.
#[test]
fn tokens_of_the_docs_run_again() {
    let page = include_str!("../docs/approximate.md");
    let lines = page.lines().filter_map(|line| line.strip_prefix("fragloom replay "));
    let tokens: Vec<&str> = lines.filter_map(|line| line.split(' ').next()).collect();
    for text in &tokens {
        let token = text.parse().expect("a token of ours");
        let Token::Litmus(token) = token else { panic!("a token of a litmus pixel") };
        replay::replay(&Catalogue::built_in(), &token).expect("the same operations");
    }
    assert_eq!(tokens.len(), 2);
}

fn reason(text: &str) -> String {
    text.parse::<Token>().expect_err("no token of ours").to_string()
}

#[test]
fn a_token_is_what_was_sent() {
    let tokens = tokens();
    assert!(tokens.len() > 10, "{}", tokens.len());
    for text in tokens {
        let token: Token = text.parse().expect("a token of ours");
        assert_eq!(token.to_string(), *text);
        assert_eq!(format!(" {text}\n").parse::<Token>().expect("blanks do not matter"), token);
        let Token::Litmus(token) = token else { panic!("a token of a litmus pixel") };
        assert!(!token.schedule().is_empty());
        replay::replay(&Catalogue::built_in(), &token).expect("it runs again");
    }
    println!(
        "{} tokens, the longest of {:?} characters",
        tokens.len(),
        tokens.iter().map(String::len).max()
    );
}

/// Every character, by another of the alphabet, and cut at every length.
#[test]
fn a_damaged_token_is_refused() {
    let mut refused = 0;
    for text in tokens() {
        for at in 0..text.len() {
            for other in ['A', 'B', '_', '7', 'z', '-', ' ', '=', '\u{e9}'] {
                let mut damaged: Vec<char> = text.chars().collect();
                if damaged[at] == other {
                    continue;
                }
                damaged[at] = other;
                let damaged: String = damaged.into_iter().collect();
                let reason = reason(&damaged);
                assert!(reason.contains("token"), "{damaged}: {reason}");
                refused += 1;
            }
            reason(&text[..at]);
            reason(&format!("{}{}", &text[..at], &text[at + 1..]));
        }
        reason(&format!("{text}A"));
        reason(&format!("{text}{text}"));
    }
    println!("{refused} damaged tokens");
}

#[test]
fn what_is_no_token_says_why() {
    let token = &tokens()[0];
    let version = token.replacen("fl2-", "fl9-", 1);
    assert!(reason(&version).contains("version 9"), "{}", reason(&version));
    assert!(reason("fl2-").contains("damaged"));
    assert!(reason(&token[..token.len() - 1]).contains("damaged"));
    for text in ["", "-", "fl", "fl-", "flx-abc", "kb.schedule", "fl1", &token[4..]] {
        assert!(
            reason(text).contains("begins with fl2-") || reason(text).contains("version"),
            "{text}"
        );
    }
}

/// The same schedule, of a method that does something else by now.
#[test]
fn a_token_of_a_method_that_has_changed_is_refused() {
    let rows = check(&subject("kplus-array@M1"), &small(), &LIMITS);
    let text = rows.iter().find_map(|row| row.token.clone()).expect("a token");
    let Ok(Token::Litmus(token)) = text.parse() else { panic!("a token of a litmus pixel") };
    replay::replay(&Catalogue::built_in(), &token).expect("unchanged");
    for other in ["kplus-array", "kplus-array@M1-relaxed", "kb", "z-buffer"] {
        let other = subject(other);
        let refused = replay::replay_of(&other, &token).expect_err("other operations").to_string();
        println!("{refused}");
        assert!(
            refused.contains("changed since") || refused.contains("something else"),
            "{refused}"
        );
    }
    let mut unknown = token.clone();
    unknown.method = "no-such-method".to_owned();
    assert!(replay::replay(&Catalogue::built_in(), &unknown).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn garbage_is_refused(text in ".*", body in "[A-Za-z0-9_-]{0,200}", bytes: Vec<u8>) {
        prop_assert!(text.parse::<Token>().is_err(), "{:?}", text);
        let body = format!("fl2-{body}");
        prop_assert!(body.parse::<Token>().is_err(), "{:?}", body);
        let bytes = format!("fl2-{}", String::from_utf8_lossy(&bytes));
        prop_assert!(bytes.parse::<Token>().is_err(), "{:?}", bytes);
    }
}
