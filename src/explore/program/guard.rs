//! A scheme's own code, run so that a panic is a result: it is what a check may be looking for.

use std::cell::{Cell, RefCell};
use std::panic::{self, AssertUnwindSafe, PanicHookInfo};
use std::sync::Once;

thread_local! {
    /// How many guards are around what this thread does.
    static GUARDS: Cell<u32> = const { Cell::new(0) };
    /// What the last panic under a guard said.
    static TOLD: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Run code that may panic; what the panic said, and where, if it does. Other threads, and code without a guard, panic
/// as before: the first guard puts a hook before the one that was there.
pub(in crate::explore) fn guarded<T>(run: impl FnOnce() -> T) -> Result<T, String> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let before = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            if GUARDS.get() == 0 {
                before(info);
            } else {
                TOLD.set(Some(told(info)));
            }
        }));
    });
    GUARDS.set(GUARDS.get() + 1);
    let result = panic::catch_unwind(AssertUnwindSafe(run));
    GUARDS.set(GUARDS.get() - 1);
    result.map_err(|_| TOLD.take().unwrap_or_else(|| "panics".to_owned()))
}

/// A panic in words.
fn told(info: &PanicHookInfo<'_>) -> String {
    let place = info.location().map(|at| format!(" at {at}")).unwrap_or_default();
    let payload = info.payload();
    let text = payload.downcast_ref::<&str>().copied();
    let text = text.or_else(|| payload.downcast_ref::<String>().map(String::as_str));
    format!("panics{place}: {}", text.unwrap_or("no message"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_told_with_its_place() {
        assert_eq!(guarded(|| 7), Ok(7));
        let line = line!() + 1;
        let told = guarded(|| panic!("no {}", "room")).unwrap_err();
        assert!(told.starts_with("panics at src/explore/program/guard.rs:"), "{told}");
        assert!(told.contains(&format!(":{line}:")) && told.ends_with(": no room"), "{told}");
    }

    /// The outer guard is still there after an inner one has caught something.
    #[test]
    fn guards_stand_in_each_other() {
        let outer: Result<(), String> = guarded(|| {
            let inner = guarded(|| panic!("inner"));
            let inner: Result<(), String> = inner;
            assert!(inner.unwrap_err().ends_with("inner"));
            panic!("outer")
        });
        assert!(outer.unwrap_err().ends_with("outer"));
        assert_eq!(GUARDS.get(), 0);
    }
}
