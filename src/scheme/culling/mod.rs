//! Passes that find, before anything is stored, what need not be: their result is a depth for every pixel, and the
//! store pass of another method skips what lies behind it (`Job::culling`).

pub mod occupancy;
