//! Replays the corpus of every target without libFuzzer.

use std::fs;
use std::path::Path;

#[test]
fn the_corpus_passes() {
    let targets: [(&str, fn(&[u8])); 11] = [
        ("obj", fragloom_fuzz::obj),
        ("gltf", fragloom_fuzz::gltf),
        ("ply", fragloom_fuzz::ply),
        ("stl", fragloom_fuzz::stl),
        ("zip", fragloom_fuzz::zip),
        ("picture", fragloom_fuzz::picture),
        ("pcd", fragloom_fuzz::pcd),
        ("toml", fragloom_fuzz::toml),
        ("npy", fragloom_fuzz::npy),
        ("nrrd", fragloom_fuzz::nrrd),
        ("raster", fragloom_fuzz::raster),
    ];
    for (name, target) in targets {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
        let mut files: Vec<_> = fs::read_dir(folder)
            .expect("corpus")
            .map(|entry| entry.expect("file").path())
            .collect();
        files.sort();
        assert!(!files.is_empty(), "{name} has a corpus");
        for file in files {
            println!("{}", file.display());
            target(&fs::read(file).expect("readable"));
        }
    }
}
