//! Pieces read at the same time say the same as lines read one after the other.

use std::ops::Range;

use proptest::prelude::*;

use super::reader::Reader;
use super::statement::statements;
use super::{cut, read};
use crate::scene::model::Unplaced;

/// All that is found and said.
fn outcome(reader: Unplaced<Reader>) -> Unplaced<String> {
    let (groups, said) = reader?.finish();
    let groups: Vec<_> = groups.into_iter().map(|group| (group.material, group.mesh())).collect();
    Ok(format!("{groups:?} {said:?}"))
}

/// What is right: line by line.
fn one_by_one(text: &str) -> Unplaced<String> {
    let mut reader = Reader::default();
    let lines = statements(text).try_for_each(|(number, line)| {
        reader.line(number, &line).map_err(|problem| format!("line {number}: {problem}"))
    });
    outcome(lines.map(|()| reader))
}

fn in_pieces(text: &str, pieces: &[Range<usize>]) -> Unplaced<String> {
    outcome(read(text, pieces))
}

#[track_caller]
fn assert_same(text: &str) {
    let right = one_by_one(text);
    for size in (1..40).chain([text.len()]) {
        assert_eq!(in_pieces(text, &cut(text, size)), right, "pieces of {size} of {text:?}");
    }
}

const WHOLE: &str = "# a \\\r\nv 0 0 0\r\nv 1 0 0 \\\r\n1 0 0\rv 0 1 0\n\nv 1 1 0\nvt 0.1 0.2 0\nvt 1\n\
    vn 0 0 1\r\nusemtl a\nf 1/1/1 2/2/1 3/1/1\nf -3 -2 -1\n# b\nf -4//-1 -3//1 -1//1 -2//1\nv 0 0 1 # c\n\
    g b\nf 5/7 1 2\nf 1 2\nf 1 2 5\nl 1 2\nf 3 -1 1 2 4\nv 0.1 0.2 0.3 2 1 1\nv x\nvn 1 1\nf 2//1 1//2 3//1\n";

#[test]
fn pieces_of_any_size_say_the_same() {
    assert!(one_by_one(WHOLE).is_ok());
    assert_same(WHOLE);
    assert_same(&WHOLE.replace("\r\n", "\r"));
    // Many corners of one vertex.
    let normals = "vn 0 0 1\n".repeat(30);
    let faces: String =
        (0..90).map(|i| format!("f 1//{} 2//1 3//{}\n", i % 30 + 1, i % 7 + 1)).collect();
    assert_same(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{normals}{faces}"));
}

#[test]
fn the_first_fault_counts() {
    let text = format!("{WHOLE}f 1 2 99\nf 1 2 7\nf 1 2 0\n");
    let expected = Err("line 27: f: vertex 99 is not among the 7 so far".to_owned());
    assert_eq!(one_by_one(&text), expected);
    assert_same(&text);
    assert_same(&text.replace("f 1 2 99\n", ""));
    assert_same(&text.replace("f 1 2 99\nf 1 2 7\n", ""));
}

/// Pieces that end at these bytes.
fn ending(text: &str, ends: &[usize]) -> Vec<Range<usize>> {
    let starts = [0].into_iter().chain(ends.iter().copied());
    starts.zip(ends.iter().copied().chain([text.len()])).map(|(start, end)| start..end).collect()
}

#[test]
fn pieces_cut_or_used_in_another_way_are_found() {
    let text = WHOLE.to_owned() + "f 1 2 99\n";
    let right = one_by_one(&text);
    let after = |what: &str| text.find(what).map(|at| at + what.len()).unwrap();
    assert_eq!(in_pieces(&text, &ending(&text, &[after("-2 -1\n")])), right);
    let wrong = [
        ("within a line", after("f -3 -2")),
        ("within a number", after("v 0.1 0")),
        ("between CR and LF", after("vn 0 0 1\r")),
        ("before what a line goes on in", after("v 1 0 0 \\\r\n")),
    ];
    for (what, end) in wrong {
        assert_ne!(in_pieces(&text, &ending(&text, &[end])), right, "{what}");
    }
    let mut pieces = cut(&text, 40);
    let last = pieces.len() - 1;
    pieces.swap(0, last);
    assert_ne!(in_pieces(&text, &pieces), right, "in another order");
    pieces.swap(0, last);
    pieces.remove(1);
    assert_ne!(in_pieces(&text, &pieces), right, "one is missing");
}

fn line() -> impl Strategy<Value = String> {
    let number = || {
        prop_oneof![
            (-9..9_i32).prop_map(|n| n.to_string()),
            (0..99_u32).prop_map(|n| format!(".{n}e0"))
        ]
    };
    let index = || {
        (-6..9_i32, 0..5_u32, -4..5_i32).prop_map(|(v, kind, n)| match kind {
            0 => format!("{v}/{n}"),
            1 => format!("{v}//{n}"),
            2 => format!("{v}/{n}/{n}"),
            _ => v.to_string(),
        })
    };
    let of = |keyword: &'static str, words: std::ops::Range<usize>| {
        prop::collection::vec(number(), words)
            .prop_map(move |words| format!("{keyword} {}", words.join(" ")))
    };
    let face =
        prop::collection::vec(index(), 2..6).prop_map(|words| format!("f {}", words.join("\t")));
    let good = (1..4_i32, 1..4_i32, 1..4_i32).prop_map(|(a, b, c)| format!("f {a} -{b} {c}"));
    let others = [
        "",
        "# \\",
        "usemtl a",
        "usemtl b",
        "g",
        "l 1 2",
        "v 1 \\",
        "f 1 \\",
        "\\",
        "v 1 2 3 0 1 .5",
        "s 1",
        "vt 1",
        "v nan 0 0",
    ];
    prop_oneof![
        4 => of("v", 3..4),
        1 => of("v", 2..8),
        2 => of("vn", 3..4),
        2 => of("vt", 2..4),
        3 => good,
        1 => face,
        2 => prop::sample::select(others.to_vec()).prop_map(str::to_owned),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_text_says_the_same(
        lines in prop::collection::vec((line(), prop::sample::select(&["\n", "\r\n", "\r"][..])), 0..30),
        size in 1..90_usize,
    ) {
        let lines: String = lines.into_iter().map(|(line, end)| line + end).collect();
        let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\n{lines}");
        prop_assert_eq!(in_pieces(&text, &cut(&text, size)), one_by_one(&text));
    }
}
