//! A picture on a device that has no room for it as a whole.

use crate::gpu::driver::failure::{Failure, Result};
use crate::gpu::twin::band::Band;

/// Do something with a band; or, where the device has no room for it, with each of its halves, and so on.
///
/// # Errors
/// The first error other than that; or there is no room for one row of tiles.
pub(super) fn split<'p>(
    band: &Band<'p>,
    work: &mut impl FnMut(&Band<'p>) -> Result<()>,
) -> Result<()> {
    match work(band) {
        Err(failure @ (Failure::TooLarge(_) | Failure::OutOfMemory(_))) => {
            match (band.halves(), failure) {
                (Some(halves), _) => halves.iter().try_for_each(|half| split(half, work)),
                (None, Failure::TooLarge(why)) => {
                    Err(Failure::Unsupported(format!("one row of tiles has no room: {why}")))
                }
                (None, failure) => Err(failure),
            }
        }
        done => done,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::twin::picture::Picture;
    use crate::scene::{self, Overrides};

    fn picture() -> Picture {
        let overrides = Overrides { size: Some([40, 112]), ..Overrides::default() };
        Picture::new(&scene::load("layers:count=3", &overrides).expect("a built-in scene"), 8)
    }

    /// The parts that a device takes if it has room for so many rows of tiles at once, and what is in them.
    fn parts(picture: &Picture, room: usize) -> Result<(Vec<std::ops::Range<usize>>, u64)> {
        let (mut rows, mut fragments) = (Vec::new(), 0);
        split(&picture.whole(), &mut |band| {
            if band.rows.len() > room {
                return Err(Failure::TooLarge("full".to_owned()));
            }
            rows.push(band.rows.clone());
            fragments += band.fragments();
            Ok(())
        })?;
        Ok((rows, fragments))
    }

    #[test]
    fn parts_are_the_picture_once() {
        let picture = picture();
        for (room, ends) in [
            (9, vec![0, 7]),
            (7, vec![0, 7]),
            (6, vec![0, 3, 7]),
            (3, vec![0, 3, 5, 7]),
            (1, (0..=7).collect()),
        ] {
            let right = ends.windows(2).map(|ends| ends[0]..ends[1]).collect();
            assert_eq!(parts(&picture, room).unwrap(), (right, 3 * 40 * 112), "{room}");
        }
    }

    #[test]
    fn what_no_halving_mends_is_an_error() {
        let picture = picture();
        let no_room = Failure::Unsupported("one row of tiles has no room: full".to_owned());
        assert_eq!(parts(&picture, 0), Err(no_room));
        let mut asked = 0;
        let stuck = split(&picture.whole(), &mut |_| {
            asked += 1;
            Err(Failure::Stuck(1))
        });
        assert_eq!((stuck, asked), (Err(Failure::Stuck(1)), 1));
    }
}
