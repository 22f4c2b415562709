//! The firmware's driver against the chip, and the chip against the sheet.

use super::*;
use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use firmware::drivers::Progress;
use firmware::drivers::SampleError;
use firmware::drivers::ads131m04::{Ads131m04 as Driver, Sample};

const TICK_S: f64 = 500e-6;
const CONVERSION_S: f64 = 1.0 / 32_000.0;
const FULL_SCALE: f64 = 8_388_608.0;
/// Noise at 32 kSPS: 21.31 uV of 1.2 V (Table 7-1).
const NOISE_CODES: f64 = 21.31e-6 / 1.2 * FULL_SCALE;
/// Six times the noise, as a fraction of full scale.
const CLOSE: f64 = 6.0 * 21.31e-6 / 1.2;

struct Bus<'a>(&'a mut Ads131m04);

impl ErrorType for Bus<'_> {
    type Error = ErrorKind;
}

impl SpiDevice for Bus<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        match operations {
            [Operation::Transfer(miso, mosi)] => self.0.transfer(mosi, miso),
            _ => return Err(ErrorKind::Other),
        }
        Ok(())
    }
}

fn booted(seed: u64, clock_error_ppm: f64, tick_s: f64) -> (Ads131m04, Driver) {
    let mut chip = Ads131m04::new(seed, clock_error_ppm);
    let mut driver = Driver::new();
    chip.advance(5e-3, [0.0; 4]);
    for _ in 0..9 {
        assert_eq!(driver.boot_step(&mut Bus(&mut chip)), Progress::Busy);
        chip.advance(tick_s, [0.0; 4]);
    }
    assert_eq!(driver.boot_step(&mut Bus(&mut chip)), Progress::Ready);
    chip.advance(tick_s, [0.0; 4]);
    (chip, driver)
}

/// A configured chip with an empty buffer at a conversion's end, its clock `clock_error_ppm` fast.
fn drained(seed: u64, clock_error_ppm: f64) -> Ads131m04 {
    let (mut chip, _) = booted(seed, clock_error_ppm, 1e-3);
    null(&mut chip);
    null(&mut chip);
    chip
}

fn exchange(chip: &mut Ads131m04, mosi: [u8; FRAME_BYTES]) -> Frame {
    let mut miso = [0; FRAME_BYTES];
    chip.transfer(&mosi, &mut miso);
    wire::decode(&miso).expect("the chip's frames are well formed")
}

fn null(chip: &mut Ads131m04) -> Frame {
    exchange(chip, wire::request(command::NULL))
}

fn assert_close(codes: [i32; 4], inputs: [f64; 4], tolerance: f64) {
    for (code, input) in codes.into_iter().zip(inputs) {
        let error = f64::from(code) / FULL_SCALE - input;
        assert!(error.abs() < tolerance, "{code} is not near {input}");
    }
}

#[test]
fn driver_boots_and_reads_at_every_tick_rate() {
    let inputs = [0.5, -0.25, 0.9, 0.0];
    for tick_s in [1e-3, 500e-6, 250e-6, 125e-6] {
        let (mut chip, mut driver) = booted(1, -100.0, tick_s);
        for _ in 0..2000 {
            chip.advance(tick_s, inputs);
            let sample = driver.sample(&mut Bus(&mut chip)).expect("no fault");
            assert_eq!((sample.overrange, sample.command_refused), (0, false));
        }
        chip.advance(tick_s, inputs);
        assert_close(driver.sample(&mut Bus(&mut chip)).expect("no fault").codes, inputs, CLOSE);
    }
}

#[test]
fn driver_sees_clipping_at_both_rails() {
    let (mut chip, mut driver) = booted(2, 0.0, TICK_S);
    chip.advance(TICK_S, [1.01, -1.01, 0.99, -0.99]);
    let sample = driver.sample(&mut Bus(&mut chip)).expect("no fault");
    assert_eq!(sample.overrange, 0b0011);
}

#[test]
fn driver_sees_a_reset_in_mid_run() {
    let (mut chip, mut driver) = booted(3, 0.0, TICK_S);
    chip.reset();
    for _ in 0..3 {
        chip.advance(TICK_S, [0.0; 4]);
        assert_eq!(driver.sample(&mut Bus(&mut chip)), Err(SampleError::Reset));
        assert_eq!(driver.status() & status::RESET, status::RESET);
    }
}

#[test]
fn driver_refuses_to_read_a_conversion_twice() {
    let (mut chip, mut driver) = booted(4, 0.0, TICK_S);
    let sample = driver.sample(&mut Bus(&mut chip));
    assert!(matches!(sample, Ok(Sample { .. })));
    assert_eq!(driver.sample(&mut Bus(&mut chip)), Err(SampleError::Stale));
    chip.advance(TICK_S, [0.0; 4]);
    assert!(driver.sample(&mut Bus(&mut chip)).is_ok());
}

/// Locked, the interface takes neither a reset nor a register write, whatever their CRC.
#[test]
fn driver_leaves_the_chip_locked_against_stray_commands() {
    let (mut chip, mut driver) = booted(5, 0.0, TICK_S);
    for stray in [wire::request(command::RESET), wire::write_request(register::CLOCK, 0x0F06)] {
        exchange(&mut chip, stray);
        chip.advance(TICK_S, [0.0; 4]);
        let sample = driver.sample(&mut Bus(&mut chip)).expect("no fault");
        assert!(!sample.command_refused);
    }
    let mut flipped = wire::request(command::NULL);
    flipped[1] ^= command::RESET as u8;
    exchange(&mut chip, flipped);
    chip.advance(TICK_S, [0.0; 4]);
    assert!(driver.sample(&mut Bus(&mut chip)).is_ok_and(|sample| sample.command_refused));
}

/// Two flipped bits turn NULL into RESET as long as the input CRC is off.
#[test]
fn a_fresh_chip_takes_a_corrupted_command() {
    let mut chip = Ads131m04::new(6, 0.0);
    assert_eq!(null(&mut chip).response, command::RESET_DONE);
    assert_eq!(null(&mut chip).response, 0x0500);
    let mut flipped = wire::request(command::NULL);
    flipped[1] ^= command::RESET as u8;
    exchange(&mut chip, flipped);
    assert_eq!(null(&mut chip).response, command::RESET_DONE);
}

#[test]
fn a_bad_crc_stops_commands_but_not_register_writes() {
    let mut chip = Ads131m04::new(7, 0.0);
    exchange(&mut chip, wire::write_request(register::MODE, 0x1110));
    let mut write = wire::write_request(register::GAIN, 0x1111);
    write[7] ^= 1;
    exchange(&mut chip, write);
    let mut read = wire::request(command::read(register::GAIN));
    read[4] ^= 1;
    assert_eq!(exchange(&mut chip, read).response, 0x1100, "CRC_ERR, and no longer RESET");
    assert_eq!(null(&mut chip).response, 0x1100);
    exchange(&mut chip, wire::request(command::read(register::GAIN)));
    assert_eq!(null(&mut chip).response, 0x1111);
}

#[test]
fn a_step_settles_in_three_conversions() {
    let mut chip = drained(8, 0.0);
    let step = [0.6, -0.6, 0.3, 0.0];
    for gain in [1.0 / 6.0, 5.0 / 6.0, 1.0, 1.0] {
        chip.advance(CONVERSION_S, step);
        assert_close(null(&mut chip).codes, step.map(|input| gain * input), CLOSE);
    }
}

/// Against three running means of 128 modulator samples each, the sinc3 of section 8.3.7.2. They lag one
/// sample behind three means over time, which a change of 0.8 turns into 0.8 / 2 / 128.
#[test]
fn filter_follows_the_modulator_samples() {
    let inputs: Vec<f64> = (0..40).map(|k| 0.8 * f64::from(k * k % 13) / 13.0 - 0.3).collect();
    let samples: Vec<f64> = inputs.iter().flat_map(|x| [*x; 128]).collect();
    let mean = |x: &[f64]| -> Vec<f64> {
        let at = |i: usize| x[(i + 1).saturating_sub(128)..=i].iter().sum::<f64>() / 128.0;
        (0..x.len()).map(at).collect()
    };
    let filtered = mean(&mean(&mean(&samples)));
    let mut chip = drained(9, 0.0);
    for (k, input) in inputs.iter().enumerate() {
        chip.advance(CONVERSION_S, [*input; 4]);
        let newest = null(&mut chip).codes;
        assert_close(newest, [filtered[128 * (k + 1) - 1]; 4], 0.8 / 256.0 + CLOSE);
    }
}

#[test]
fn long_and_short_steps_of_time_agree() {
    for pieces in [1, 7, 64] {
        let mut chip = drained(10, 0.0);
        let before = chip.conversions();
        for _ in 0..pieces {
            chip.advance(40.5 * CONVERSION_S / f64::from(pieces), [0.4; 4]);
        }
        assert_eq!(chip.conversions() - before, 40);
        assert_eq!(null(&mut chip).response & status::DRDY, status::DRDY);
        assert_close(null(&mut chip).codes, [0.4; 4], CLOSE);
        assert_eq!(null(&mut chip).response & status::DRDY, 0);
    }
}

#[test]
fn noise_has_the_sheets_spread() {
    let mut chip = drained(11, 0.0);
    let mut sum = 0.0;
    for _ in 0..5000 {
        chip.advance(TICK_S, [0.0; 4]);
        sum += null(&mut chip).codes.iter().map(|code| f64::from(*code).powi(2)).sum::<f64>();
    }
    let rms = (sum / 20_000.0).sqrt();
    assert!((rms / NOISE_CODES - 1.0).abs() < 0.02, "{rms} against {NOISE_CODES}");
}

#[test]
fn conversions_count_the_chips_own_clock() {
    for (ppm, expected) in [(0.0, 32_000), (20_000.0, 32_640), (-500.0, 31_984)] {
        let mut chip = drained(12, ppm);
        let before = chip.conversions();
        for _ in 0..2000 {
            chip.advance(TICK_S, [0.0; 4]);
        }
        assert!((chip.conversions() - before).abs_diff(expected) <= 1);
    }
}

#[test]
fn the_reset_pin_synchronises_or_resets() {
    for (low_s, response) in [(100e-6, 0xC10F), (300e-6, command::RESET_DONE)] {
        let mut chip = drained(13, 0.0);
        chip.set_reset_pin(false);
        chip.advance(low_s, [0.0; 4]);
        chip.set_reset_pin(true);
        chip.advance(TICK_S, [0.0; 4]);
        assert_eq!(null(&mut chip).response, response);
    }
}
