//! See `fragloom_fuzz::raster`.

#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| fragloom_fuzz::raster(bytes));
