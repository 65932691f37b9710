//! The stability matrix: what each method's result is seen to depend on is what its contract declares.

use fragloom::catalogue::{Catalogue, method};
use fragloom::explore::sample::stability::{Stability, derive, derive_one};

#[test]
fn what_is_seen_is_what_contracts_declare() {
    let rows = derive(&Catalogue::built_in()).expect("the scenes can be drawn");
    assert_eq!(rows.len(), Catalogue::built_in().promised().count());
    let wrong: Vec<&Stability> = rows.iter().filter(|row| !row.agrees()).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    let seen = |name: &str| rows.iter().find(|row| row.method == name).expect("a row");
    assert!(seen("kb").schedule && !seen("kb").arrival);
    assert!(seen("kb-sr").arrival_at_overflow && !seen("kb-sr").schedule);
    assert!(seen("kb-mdt32").inexact_at_ties && seen("kb-mdt32").arrival_at_ties);
    assert!(seen("depth-peel@published").inexact_at_ties);
    assert!(!seen("depth-peel@published").arrival_at_ties);
    assert!(!seen("depth-peel").inexact_at_ties);
    // Fewer where the first order already shows a dependence.
    assert!(rows.iter().all(|row| row.runs >= 50), "every row has so many runs behind it");
}

/// Negative control: a contract that declares too little is found.
#[test]
fn a_contract_that_declares_too_little_is_found() {
    let mut row = derive_one(method("kb").expect("known")).expect("drawn");
    assert!(row.agrees());
    row.declared = [false, false];
    assert!(!row.agrees());
    let fault = derive_one(method("kplus-heap@M9").expect("known")).expect("drawn");
    assert!(!fault.agrees(), "its contract, made for checks of races, says nothing of arrival");
}
