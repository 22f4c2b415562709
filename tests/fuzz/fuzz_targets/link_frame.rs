//! The board's end of the operator link: `cargo fuzz run --fuzz-dir tests/fuzz link_frame`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tests::fuzz::link(bytes));
