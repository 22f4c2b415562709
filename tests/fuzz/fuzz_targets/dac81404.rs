//! The DAC's frames: `cargo fuzz run --fuzz-dir tests/fuzz dac81404`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| tests::fuzz::dac81404(bytes));
