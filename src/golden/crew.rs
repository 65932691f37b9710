//! Several at once: threads that take the next one when they are free.

use std::thread;

use crossbeam_channel::unbounded;

use super::Work;

/// Do `one` for each of `count`, and give the results in their order; `None` for those that were not begun when the work
/// was cancelled. `one` gets the number and how many threads it may take.
pub(super) fn all<T: Send>(
    count: usize,
    work: &Work<'_>,
    one: impl Fn(usize, usize) -> T + Sync,
) -> Vec<Option<T>> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let jobs = if work.jobs == 0 { cores } else { work.jobs }.min(count).max(1);
    let threads = (cores / jobs).max(1);
    let (todo, next) = unbounded();
    for number in 0..count {
        let _ = todo.send(number);
    }
    drop(todo);
    let (result, results) = unbounded();
    let mut all: Vec<Option<T>> = (0..count).map(|_| None).collect();
    thread::scope(|scope| {
        for _ in 0..jobs {
            let (next, result, one) = (next.clone(), result.clone(), &one);
            let cancelled = work.cancelled;
            scope.spawn(move || {
                while let Some(number) = next.try_recv().ok().filter(|_| !cancelled()) {
                    let _ = result.send((number, one(number, threads)));
                }
            });
        }
        drop(result);
        for (number, found) in results {
            all[number] = Some(found);
            (work.done)();
        }
    });
    all
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::sync::Mutex;

    use super::*;

    #[test]
    fn each_is_done_once_and_in_its_place() {
        for jobs in [0, 1, 3, 50] {
            let (told, seen) = (Cell::new(0), Mutex::new(Vec::new()));
            let done = || told.set(told.get() + 1);
            let work = Work { jobs, done: &done, ..Work::SILENT };
            let found = all(20, &work, |number, threads| {
                seen.lock().unwrap().push(number);
                assert!(threads > 0);
                number * number
            });
            assert!(found.iter().enumerate().all(|(i, found)| *found == Some(i * i)), "{jobs}");
            let mut seen = seen.into_inner().unwrap();
            seen.sort_unstable();
            assert_eq!((seen, told.get()), ((0..20).collect(), 20));
        }
        assert!(all(0, &Work::SILENT, |_, _| ()).is_empty());
    }

    #[test]
    fn what_is_cancelled_is_not_begun() {
        let begun = Mutex::new(0);
        let cancelled = || *begun.lock().unwrap() >= 3;
        let work = Work { jobs: 1, cancelled: &cancelled, ..Work::SILENT };
        let found = all(9, &work, |_, _| *begun.lock().unwrap() += 1);
        assert_eq!(found.iter().filter(|found| found.is_some()).count(), 3);
        assert!(found[3..].iter().all(Option::is_none));
    }
}
