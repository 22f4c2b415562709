//! An encoder's frames: `cargo fuzz run --fuzz-dir tests/fuzz biss_c`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tests::fuzz::biss_c(bytes));
