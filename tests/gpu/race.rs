//! Timing a twin: what is drawn for that, in as many parts as there is room for.

use fragloom::catalogue;
use fragloom::gpu::check::crosscheck::find;
use fragloom::gpu::check::race::Contender;
use fragloom::gpu::driver::failure::Failure;
use fragloom::gpu::twin::picture::Picture;

use super::drivers::{all, turn};
use super::support::scene;

#[test]
fn a_picture_that_is_too_large_is_drawn_in_parts() {
    let _turn = turn();
    let scene = scene("layers:count=6", [64, 96]);
    for mut opened in all("timing in parts") {
        let picture = Picture::new(&scene, opened.bits());
        let twin = find(catalogue::method("ab-array").expect("a built-in method")).expect("a twin");
        let parts = |opened: &fragloom::gpu::check::open::Opened| {
            let contender = Contender::new(&opened.device, &picture, twin, None)?;
            let mut turns = 0;
            let seconds = contender.seconds(3, || turns += 1)?;
            assert_eq!((seconds.len(), turns), (3, 3));
            assert!(seconds.iter().all(|&seconds| seconds > 0.0));
            assert_eq!(contender.fragments(), 6 * 64 * 96, "all of it, once");
            Ok(contender.parts())
        };
        assert_eq!(parts(&opened), Ok(1));
        // 64 x 96 pixels of six 8-byte records are 294,912 bytes: there is room for two rows of tiles of six.
        opened.device.limits.max_storage_buffer_binding_size = 100_000;
        assert_eq!(parts(&opened), Ok(4));
        opened.device.limits.max_storage_buffer_binding_size = 1_000;
        let refused = parts(&opened);
        assert!(
            matches!(&refused, Err(Failure::Unsupported(why)) if why.contains("one row")),
            "{refused:?}"
        );
    }
}
