//! See `fragloom_fuzz::gltf`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::gltf(bytes));
