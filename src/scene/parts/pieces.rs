//! Long texts in pieces: read at the same time, used one after the other in their order, so that what is found, and what is
//! said of it, is the same for any size of pieces and any number of threads.

use std::ops::Range;

use rayon::prelude::*;

use super::text::ends_line;

/// Bytes of a piece. A few per thread are in memory at once.
pub(in crate::scene) const PIECE: usize = 1 << 18;

/// How many pieces per thread are read at once.
const PER_THREAD: usize = 4;

/// Cuts a text into pieces of at least `size` bytes, but for the last. Each ends with a line of which `may_end`, asked
/// without the line's end, says that what follows can be understood without it.
pub(in crate::scene) fn pieces(
    text: &[u8],
    size: usize,
    may_end: impl Fn(&[u8]) -> bool,
) -> Vec<Range<usize>> {
    let mut pieces = Vec::new();
    let mut start = 0;
    while start < text.len() {
        let mut from = start.saturating_add(size.max(1) - 1).min(text.len());
        let end = loop {
            let Some(more) = text[from..].iter().position(|&byte| ends_line(byte)) else {
                break text.len();
            };
            let at = from + more;
            let second = text[at] == b'\n' && text[start..at].ends_with(b"\r");
            let at = at - usize::from(second);
            let line = text[start..at].iter().rposition(|&byte| ends_line(byte));
            let line = line.map_or(start, |before| start + before + 1);
            let end = at + if text[at..].starts_with(b"\r\n") { 2 } else { 1 };
            if may_end(&text[line..at]) {
                break end;
            }
            from = end;
        };
        pieces.push(start..end);
        start = end;
    }
    pieces
}

/// Reads pieces in parallel, and uses what was read in their order. While some are used, the next ones are read. The
/// first error of `apply` ends it.
pub(in crate::scene) fn in_order<P: Sync, T: Send, E: Send>(
    pieces: &[P],
    read: impl Fn(&P) -> T + Sync,
    mut apply: impl FnMut(T) -> Result<(), E> + Send,
) -> Result<(), E> {
    // Not worth waking threads for.
    if let [one] = pieces {
        return apply(read(one));
    }
    let all = |wave: &[P]| wave.par_iter().map(&read).collect::<Vec<T>>();
    let mut waves = pieces.chunks(PER_THREAD * rayon::current_num_threads());
    let mut ready = waves.next().map(all).unwrap_or_default();
    loop {
        let wave = waves.next();
        let (applied, next) = rayon::join(
            || std::mem::take(&mut ready).into_iter().try_for_each(&mut apply),
            || wave.map(all),
        );
        applied?;
        match next {
            Some(next) => ready = next,
            None => return Ok(()),
        }
    }
}

/// Items of a list that a thread looks at at once.
const BLOCK: usize = 1 << 14;

/// Where the first item of a list is that is `wanted`, found by several threads if the list is long.
pub(in crate::scene) fn first<T: Sync>(
    list: &[T],
    wanted: impl Fn(&T) -> bool + Send + Sync,
) -> Option<usize> {
    if list.len() <= 2 * BLOCK {
        return list.iter().position(wanted);
    }
    // Block by block, since asking for the end of the search at each item takes longer than the item.
    let has = |block: &[T]| block.iter().any(&wanted);
    let start = BLOCK * list.par_chunks(BLOCK).position_first(has)?;
    list[start..].iter().position(wanted).map(|at| start + at)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_a_list_is_found() {
        let list: Vec<usize> = (0..100_000).collect();
        for wanted in [0, 1, BLOCK - 1, BLOCK, 40_000, 99_999] {
            assert_eq!(first(&list, |&item| item >= wanted), Some(wanted));
            assert_eq!(
                first(&list[..20_000], |&item| item >= wanted),
                (wanted < 20_000).then_some(wanted)
            );
        }
        assert_eq!(first(&list, |_| false), None);
    }

    fn cut(text: &str, size: usize) -> Vec<&str> {
        let pieces = pieces(text.as_bytes(), size, |line| !line.contains(&b'\\'));
        pieces.into_iter().map(|piece| &text[piece]).collect()
    }

    #[test]
    fn pieces_end_with_whole_lines_that_stand_alone() {
        let text = "a\r\nb\rc \\\nd\n\n\\\r\n\r\ne";
        assert_eq!(cut(text, 1), ["a\r\n", "b\r", "c \\\nd\n", "\n", "\\\r\n\r\n", "e"]);
        for size in 1..=text.len() {
            let pieces = cut(text, size);
            assert_eq!(pieces.concat(), text);
            let whole = &pieces[..pieces.len() - 1];
            assert!(whole.iter().all(|piece| piece.len() >= size), "{size}: {pieces:?}");
        }
        assert_eq!(cut(text, usize::MAX), [text]);
        assert_eq!(cut("\\\n\\\n", 1), ["\\\n\\\n"]);
        assert_eq!(cut("", 1), [""; 0]);
    }

    #[test]
    fn pieces_are_used_in_their_order_up_to_the_first_error() {
        for count in [0, 1, 2, 99, 1_000] {
            let numbers: Vec<u32> = (0..count).collect();
            let mut used = Vec::new();
            let keep = |n| {
                used.push(n);
                Ok::<_, u32>(())
            };
            let whole = in_order(&numbers, |n| n * 2, keep);
            assert_eq!((whole, used), (Ok(()), numbers.iter().map(|n| n * 2).collect()));
        }
        let numbers: Vec<u32> = (0..1_000).collect();
        let mut used = 0;
        let ended = in_order(
            &numbers,
            |n| *n,
            |n| {
                used += 1;
                if n % 100 == 77 { Err(n) } else { Ok(()) }
            },
        );
        assert_eq!((ended, used), (Err(77), 78));
    }
}
