//! The torque converter's frames: `cargo fuzz run --fuzz-dir tests/fuzz ads131m04`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tests::fuzz::ads131m04(bytes));
