//! Whatever comes in: decoders, operator link and scenario parser take what is right and nothing else.

mod bus;

use proptest::prelude::*;
use tests::fuzz::{self, storm};

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn any_bytes_on_the_bus(bytes: [u8; 32]) {
        fuzz::biss_c(&bytes);
        fuzz::ads131m04(&bytes);
        fuzz::dac81404(&bytes);
    }

    #[test]
    fn any_bytes_on_the_link(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        fuzz::link(&bytes);
    }

    #[test]
    fn any_bytes_as_a_scenario(bytes: Vec<u8>) {
        fuzz::scenario(&bytes);
    }

    #[test]
    fn any_text_as_a_scenario(text in "[a-z_ =\\[\\]\"0-9.\n-]{0,200}") {
        fuzz::scenario(text.as_bytes());
    }
}

/// Half of all with a valid CRC, a tenth with a valid code and a stale counter.
#[test]
fn a_million_mutated_frames_have_no_effect_and_no_stop_is_missed() {
    const COUNT: u64 = 1_000_000;
    let tally = storm::storm(1, COUNT);
    println!("{tally:?}");
    assert_eq!((tally.mutants, tally.stale), (COUNT * 9 / 10, COUNT / 10));
    let sealed = tally.resealed + tally.stale;
    assert!(sealed.abs_diff(COUNT / 2) < COUNT / 8, "{sealed} with a valid CRC");
    let [_, length, damaged, version, kind, reserved, no_session, bad_code, stale, ..] =
        tally.refusals;
    assert!([length, damaged, version, kind, reserved, bad_code].iter().all(|n| *n > 1_000));
    assert_eq!((no_session, stale), (0, tally.stale));
    assert!(tally.stops > COUNT / 100, "the new CRC makes stops as well");
}
