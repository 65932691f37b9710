//! The front end: primitives in parts, bins by rows of tiles, and room that is used again, against the plain way to do
//! the same.

use std::sync::Arc;

use fragloom::num::random::Random;
use fragloom::raster::{CullFace, FrontEnd, Grid, Room};
use fragloom::scene::{Overrides, Scene, ScreenTriangle, load};

const SIZE: [u32; 2] = [200, 120];

/// The number of triangles that one part may have.
const PART: usize = 4_096;

/// Small objects, a mesh of more than one part, and triangles in pixels: anywhere in the picture, or outside of it.
fn scene(seed: u64) -> Scene {
    let mut scene = load("cubes", &Overrides::default()).expect("a scene");
    let hair = load("hairball:strands=40", &Overrides::default()).expect("a scene");
    scene.size = SIZE;
    let cubes = scene.objects.clone();
    (0..3).for_each(|_| scene.objects.extend(cubes.iter().cloned()));
    let (material, first) = (scene.materials.len(), hair.objects[0].material);
    scene.materials.push(hair.materials[first].clone());
    for mut object in hair.objects {
        object.material = material;
        scene.objects.push(object);
    }
    scene.objects.extend(cubes);
    // An object without anything.
    let mut empty = scene.objects[0].clone();
    empty.mesh = Arc::default();
    scene.objects.insert(2, empty);
    let mut random = Random::new(seed, 0);
    let mut number = |from: f64, to: f64| from + (to - from) * random.unit();
    let mut triangle = |i: usize| {
        let reach = [3.0, 30.0, 300.0][i % 3];
        let (x, y) = (number(-40.0, 240.0), number(-40.0, 160.0));
        let mut corner = || [x + number(0.0, reach), y + number(0.0, reach), number(0.0, 1.0)];
        let points = [corner(), corner(), corner()];
        ScreenTriangle { points, color: [1.0; 4] }
    };
    // A few have no area.
    scene.screen = (0..3 * PART + 17).map(&mut triangle).collect();
    for i in (0..scene.screen.len()).step_by(97) {
        scene.screen[i].points[1] = scene.screen[i].points[0];
    }
    scene
}

fn front(scene: &Scene, tile: u32, room: &Room) -> FrontEnd {
    let grid = Grid { width: SIZE[0], height: SIZE[1], tile };
    FrontEnd::attenuated(scene, grid, 8, CullFace::None, None, room)
}

type Packets = Vec<(u32, u16, u16, u64)>;

/// All packets, tile by tile, by triangle.
fn binned(front: &FrontEnd) -> Vec<Packets> {
    let of = |tile| {
        let mut found = Vec::new();
        front.packets(tile, |p| {
            found.push((front.primitive(p.primitive).triangle, p.column, p.row, p.mask));
        });
        found
    };
    (0..front.grid.tiles()).map(of).collect()
}

/// The same, without bins: every primitive in every tile.
fn plain(front: &FrontEnd) -> Vec<Packets> {
    let of = |tile| {
        let mut found = Vec::new();
        for index in front.indices() {
            let triangle = front.primitive(index).triangle;
            front.primitive_packets(index, front.grid.tile_rect(tile), |p| {
                found.push((triangle, p.column, p.row, p.mask));
            });
        }
        found
    };
    (0..front.grid.tiles()).map(of).collect()
}

#[test]
fn bins_lose_nothing_and_keep_the_order() {
    let scene = scene(1);
    for tile in [16, 32, 64] {
        let front = front(&scene, tile, &Room::default());
        assert!(front.visible() > 2 * PART && front.degenerate > 100, "{}", front.visible());
        let (found, expected) = (binned(&front), plain(&front));
        assert!(found == expected, "tile {tile}");
        let mut packets = 0;
        front.packets_in_order(|_| packets += 1);
        assert!(packets > 10_000);
    }
}

#[test]
fn indices_find_their_triangles() {
    let scene = scene(2);
    let front = front(&scene, 64, &Room::default());
    let indices = front.indices();
    assert_eq!(indices.len(), front.visible());
    assert!(indices.is_sorted_by(|a, b| a < b));
    assert!(front.primitives().map(|p| p.triangle).is_sorted_by(|a, b| a < b));
    let mut of = vec![None; front.triangles as usize];
    for &index in &indices {
        of[front.primitive(index).triangle as usize] = Some(index);
    }
    for (triangle, index) in (0..).zip(of) {
        assert_eq!(front.index_of(triangle), index, "triangle {triangle}");
    }
    assert_eq!(front.index_of(front.triangles as u32), None);
    // The last are those in pixels.
    assert_eq!(front.triangles as usize, scene.triangles() as usize);
}

#[test]
fn neither_threads_nor_room_change_anything() {
    let text = |front: &FrontEnd| {
        let indices = front.indices();
        let parts =
            indices.iter().map(|&i| format!("{i} {:?} {:?}", front.primitive(i), front.surface(i)));
        (front.degenerate, parts.collect::<Vec<_>>(), binned(front))
    };
    let scenes = [scene(3), scene(4)];
    let expected = scenes.each_ref().map(|scene| text(&front(scene, 32, &Room::default())));
    assert!(expected[0] != expected[1]);
    let room = Room::of_several();
    for threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for (scene, expected) in scenes.iter().zip(&expected) {
            let front = pool.install(|| front(scene, 32, &room));
            assert!(text(&front) == *expected, "{threads} threads");
            front.leave(&room);
        }
    }
}
