//! See `fragloom_fuzz::obj`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::obj(bytes));
