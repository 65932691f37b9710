//! See `fragloom_fuzz::nrrd`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::nrrd(bytes));
