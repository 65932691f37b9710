//! A progress spinner or bar during long work.

use std::io::{IsTerminal, stderr};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

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

/// Do `work` on `count` things, telling what it gets after each; if it takes over a second, a bar on stderr shows how
/// many are done, unless `quiet` or without a terminal.
pub(in crate::cli) fn counting<T>(
    quiet: bool,
    message: &str,
    count: usize,
    work: impl FnOnce(&dyn Fn()) -> T,
) -> T {
    if quiet || !stderr().is_terminal() {
        return work(&|| {});
    }
    let bar = ProgressBar::hidden().with_message(message.to_owned());
    bar.set_length(count as u64);
    if let Ok(style) = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len}") {
        bar.set_style(style);
    }
    let (working, ended) = channel::<()>();
    let shown = bar.clone();
    let found = thread::scope(|scope| {
        scope.spawn(move || {
            if ended.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                shown.set_draw_target(ProgressDrawTarget::stderr());
            }
        });
        let _working = working;
        work(&|| bar.inc(1))
    });
    bar.finish_and_clear();
    found
}
