//! See `fragloom_fuzz::ply`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::ply(bytes));
