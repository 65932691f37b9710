//! A progress spinner during long work.

use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use indicatif::ProgressBar;

/// Work shorter than this shows nothing.
const PATIENCE: Duration = Duration::from_secs(1);

/// Do `work`; if it takes over a second, show a spinner with `message` on stderr, unless `quiet` or without a terminal.
pub(in crate::cli) fn during<T>(quiet: bool, message: &str, work: impl FnOnce() -> T) -> T {
    if quiet || !stderr().is_terminal() {
        return work();
    }
    let (working, ended) = channel::<()>();
    thread::scope(|scope| {
        scope.spawn(move || {
            if ended.recv_timeout(PATIENCE) != Err(RecvTimeoutError::Timeout) {
                return;
            }
            let spinner = ProgressBar::new_spinner().with_message(message.to_owned());
            spinner.enable_steady_tick(Duration::from_millis(100));
            // Nothing is ever sent: this returns when the other end is dropped, also on a panic.
            let _ = ended.recv();
            spinner.finish_and_clear();
        });
        let _working = working;
        work()
    })
}
