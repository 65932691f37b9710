//! See `fragloom_fuzz::toml`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::toml(bytes));
