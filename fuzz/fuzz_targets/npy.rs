//! See `fragloom_fuzz::npy`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::npy(bytes));
