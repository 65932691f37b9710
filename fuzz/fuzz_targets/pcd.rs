//! See `fragloom_fuzz::pcd`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::pcd(bytes));
