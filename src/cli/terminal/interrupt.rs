//! Ctrl-C during long work: the first press asks for what was found so far, the second ends the program.

use crossbeam_channel::{Receiver, bounded};

/// Ctrl-C, and whether it was pressed.
pub(in crate::cli) struct Interrupt(Receiver<()>);

/// The usual exit code of a program that Ctrl-C ended.
const INTERRUPTED: i32 = 130;

impl Interrupt {
    /// Watch from now on.
    pub(in crate::cli) fn watch() -> Self {
        let (pressed, seen) = bounded(1);
        let handler = move || {
            if pressed.try_send(()).is_err() {
                std::process::exit(INTERRUPTED);
            }
        };
        // Without a handler, Ctrl-C ends the program at once: nothing is lost but a partial result.
        let _ = ctrlc::set_handler(handler);
        Self(seen)
    }

    /// Whether it was pressed.
    pub(in crate::cli) fn pressed(&self) -> bool {
        !self.0.is_empty()
    }
}
