//! See `fragloom_fuzz::zip`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::zip(bytes));
