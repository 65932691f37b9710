//! Invocations and operations in words.

use crate::memory::asked::Action;
use crate::memory::{Access, Order, Update};

/// A, B, C ...
#[must_use]
pub fn label(invocation: usize) -> char {
    char::from(b'A' + (invocation % 26) as u8)
}

/// An operation in words.
#[must_use]
pub fn describe(action: Action) -> String {
    match action {
        Action::Read(Access::Plain) => "plain load".to_owned(),
        Action::Read(Access::Atomic(o)) => format!("{} load", order_name(o)),
        Action::Write(value, Access::Plain) => format!("plain store of {value:x}"),
        Action::Write(value, Access::Atomic(o)) => format!("{} store of {value:x}", order_name(o)),
        Action::Update(update, o) => {
            let what = match update {
                Update::Exchange(v) => format!("exchange {v:x}"),
                Update::CompareExchange { expected, new } => {
                    format!("compare-exchange {expected:x} -> {new:x}")
                }
                Update::Add(v) => format!("add {v:x}"),
                Update::And(v) => format!("and {v:x}"),
                Update::Or(v) => format!("or {v:x}"),
                Update::Min(v) => format!("min {v:x}"),
                Update::Max(v) => format!("max {v:x}"),
            };
            format!("{} {what}", order_name(o))
        }
    }
}

/// A memory order in words.
#[must_use]
pub fn order_name(order: Order) -> &'static str {
    match order {
        Order::Relaxed => "relaxed",
        Order::Acquire => "acquire",
        Order::Release => "release",
        Order::AcqRel => "acq-rel",
    }
}
