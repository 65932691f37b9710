//! See `fragloom_fuzz::stl`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::stl(bytes));
