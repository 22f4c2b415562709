//! Damaged frames on the bus: what the check sums let through, and what comes of it. `docs/campaign.md` gives the
//! figures.

use tests::fuzz::damage::{Device, Sort, taken};
use tests::fuzz::running::{self, Fate};

const PAGE: &str = include_str!("../../docs/campaign.md");

/// Frames of each device with flipped bits, and as many with a burst.
const FOUND: u64 = 500_000;

#[test]
fn check_sums_find_two_flips_and_bursts_and_let_through_what_theory_says() {
    for (device, name, count) in [
        (Device::Encoder(26), "encoder of 26 bits", 4_000_000),
        (Device::Encoder(32), "encoder of 32 bits", 4_000_000),
        (Device::Adc, "torque converter", 16_000_000),
        (Device::Dac, "DAC", 4_000_000),
    ] {
        for sort in [Sort::Flips, Sort::Burst] {
            assert_eq!(taken(sort, device, FOUND, 1), 0, "{sort:?} of the {name}");
        }
        let one_in = 1_u64 << device.crc_bits();
        let got = taken(Sort::Any, device, count, 1);
        let due = (count / one_in) as f64;
        assert!((got as f64 - due).abs() < 5.0 * due.sqrt(), "{name}: {got}, not {due}");
        let row = format!("| {name} | 1 in {one_in} | {got} of {count} |");
        println!("{row}");
        assert!(PAGE.contains(&row), "docs/campaign.md lacks: {row}");
    }
}

/// Every value used is the one sent, or lies where the joint can be (`running` checks each frame); the arm keeps its
/// path within the 5 mm that a fault of the bus may cost.
#[test]
fn a_million_damaged_frames_move_no_position_past_its_window_nor_the_arm() {
    const COUNT: u64 = 1_000_000;
    let tally = running::run(1, COUNT);
    println!("{:?}", tally.fates);
    let [encoders, adc, dac] = tally.fates;
    let near = encoders[running::NEAR];
    let used = near.used;
    let (stops, off_mm) = (tally.stops.len(), 1e3 * tally.off_path_m);
    println!("{} ticks, {stops} stops, {off_mm:.2} mm, {:?}", tally.ticks, tally.off_counts);
    assert!(tally.frames() >= COUNT);
    for [flips, burst, any, _] in [encoders, adc, dac] {
        assert!([flips, burst, any].iter().all(|fate| fate.frames > 30_000), "{:?}", tally.fates);
        assert_eq!((flips.passed, burst.passed), (0, 0));
        assert_eq!((flips.used, burst.used, any.used), (0, 0, 0));
    }
    let Fate { frames, passed, .. } = encoders[2];
    assert!(passed.abs_diff(frames / 64) < 5 * frames.isqrt() / 8, "{passed} of {frames}");
    assert_eq!(near.passed, near.frames);
    assert!((0.15..0.4).contains(&(used as f64 / near.frames as f64)), "{near:?}");
    assert!((0.05..0.2).contains(&(stops as f64 / near.frames as f64)), "{stops} stops");
    assert!(tally.off_path_m < 5e-3, "the tip is {off_mm} mm from its path");
}
