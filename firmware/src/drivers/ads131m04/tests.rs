extern crate std;

use super::*;
use embedded_hal_mock::eh1::spi::{Mock, Transaction};
use std::vec::Vec;

const CODES: [i32; 4] = [1, -2, 3, -4];

fn frame(response: u16, codes: [i32; 4]) -> [u8; FRAME_BYTES] {
    wire::encode(&Frame { response, codes })
}

fn run<T>(
    frames: &[(&[u8; FRAME_BYTES], [u8; FRAME_BYTES])],
    call: impl FnOnce(&mut Mock<u8>) -> T,
) -> T {
    let transactions: Vec<_> = frames
        .iter()
        .flat_map(|(request, answer)| {
            [
                Transaction::transaction_start(),
                Transaction::transfer(request.to_vec(), answer.to_vec()),
                Transaction::transaction_end(),
            ]
        })
        .collect();
    let mut spi = Mock::new(&transactions);
    let result = call(&mut spi);
    spi.done();
    result
}

/// One sample with these two answers; `turn` is the register that was due in the first.
fn sample(
    adc: &mut Ads131m04,
    older: [u8; FRAME_BYTES],
    newest: [u8; FRAME_BYTES],
) -> Result<Sample, SampleError> {
    let request = &READBACK[(adc.turn + 1) % READBACK.len()].request;
    run(&[(&NULL, older), (request, newest)], |spi| adc.sample(spi))
}

fn due(adc: &Ads131m04) -> [u8; FRAME_BYTES] {
    frame(READBACK[adc.turn % READBACK.len()].content, [9; 4])
}

/// Answers of a healthy device, written out from Table 8-11 and the register values.
const ANSWERS: [u16; 10] =
    [0xFF24, 0x2437, 0x4100, 0x4180, 0x1110, 0x0F02, 0x0555, 0xC10F, 0x810F, 0x810F];

fn boot(adc: &mut Ads131m04, answers: &[u16]) -> Progress {
    answers.iter().enumerate().fold(Progress::Busy, |_, (row, answer)| {
        run(&[(&BOOT[row].request, frame(*answer, CODES))], |spi| adc.boot_step(spi))
    })
}

#[test]
fn boots_on_the_answers_of_a_healthy_device() {
    let mut adc = Ads131m04::new();
    assert_eq!(boot(&mut adc, &ANSWERS[..9]), Progress::Busy);
    let last = run(&[(&BOOT[9].request, frame(0x810F, CODES))], |spi| adc.boot_step(spi));
    assert_eq!(last, Progress::Ready);
    assert_eq!(run(&[], |spi| adc.boot_step(spi)), Progress::Ready);
}

#[test]
fn boot_fails_for_good_on_any_wrong_answer() {
    for row in 0..ANSWERS.len() {
        let mut answers = ANSWERS;
        answers[row] ^= 0x8500;
        let mut adc = Ads131m04::new();
        assert_eq!(boot(&mut adc, &answers[..=row]), Progress::Failed, "row {row}");
        assert_eq!(run(&[], |spi| adc.boot_step(spi)), Progress::Failed);
    }
}

#[test]
fn boot_fails_on_a_dead_line() {
    let mut adc = Ads131m04::new();
    let dead = [0xFF; FRAME_BYTES];
    let progress = run(&[(&BOOT[0].request, dead)], |spi| adc.boot_step(spi));
    assert_eq!(progress, Progress::Failed);
}

/// A controller that restarts beside a running converter must not take it for a fresh one.
#[test]
fn boot_refuses_a_device_that_was_not_reset() {
    assert_eq!(boot(&mut Ads131m04::new(), &[0x810F]), Progress::Failed);
}

#[test]
fn the_newer_of_two_conversions_is_used() {
    let mut adc = Ads131m04::new();
    let codes = [CODE_MAX, 5, wire::CODE_MIN, CODE_MAX - 1];
    let older = due(&adc);
    let expected = Sample { codes, overrange: 0b0101, command_refused: false };
    assert_eq!(sample(&mut adc, older, frame(0x810F, codes)), Ok(expected));
}

#[test]
fn status_words_are_told_apart() {
    for (status, expected) in [
        (0x810F, Ok(false)),
        (0x910F, Ok(true)),
        (0x8100, Err(SampleError::Stale)),
        (0x8107, Err(SampleError::Stale)),
        (0xC10F, Err(SampleError::Stale)),
        (0x850F, Err(SampleError::Reset)),
        (0x010F, Err(SampleError::Reset)),
        (0x050F, Err(SampleError::Reset)),
        (0xA10F, Err(SampleError::Device)),
        (command::RESET_DONE, Err(SampleError::Reset)),
        (0x830F, Err(SampleError::Framing)),
    ] {
        let mut adc = Ads131m04::new();
        let older = due(&adc);
        let result = sample(&mut adc, older, frame(status, CODES));
        assert_eq!(result.map(|s| s.command_refused), expected, "{status:#06x}");
        assert_eq!(adc.status(), status);
    }
}

#[test]
fn damaged_frames_are_refused_by_their_fault() {
    let mut adc = Ads131m04::new();
    let mut newest = frame(HEALTHY, CODES);
    newest[4] ^= 1;
    let older = due(&adc);
    assert_eq!(sample(&mut adc, older, newest), Err(SampleError::Crc));
    newest[4] ^= 1;
    newest[17] ^= 1;
    let older = due(&adc);
    assert_eq!(sample(&mut adc, older, newest), Err(SampleError::Framing));
    // Damage to the frame that only drains the buffer costs nothing.
    newest[17] ^= 1;
    assert!(sample(&mut adc, [0xFF; FRAME_BYTES], newest).is_ok());
}

#[test]
fn a_repeated_conversion_is_stale() {
    let mut adc = Ads131m04::new();
    let older = due(&adc);
    assert!(sample(&mut adc, older, frame(HEALTHY, CODES)).is_ok());
    let older = due(&adc);
    assert_eq!(sample(&mut adc, older, frame(HEALTHY, CODES)), Err(SampleError::Stale));
}

#[test]
fn a_lost_first_frame_costs_one_sample() {
    let mut adc = Ads131m04::new();
    let newest = due(&adc);
    assert_eq!(sample(&mut adc, [0; FRAME_BYTES], newest), Err(SampleError::Framing));
    let older = due(&adc);
    assert!(sample(&mut adc, older, frame(HEALTHY, CODES)).is_ok());
}

#[test]
fn another_configuration_counts_when_read_back_three_times_running() {
    let mut adc = Ads131m04::new();
    let wrong = frame(0x0F06, CODES);
    for round in 1..9 {
        let older = if round == 3 { due(&adc) } else { wrong };
        let result = sample(&mut adc, older, frame(HEALTHY, [round; 4]));
        assert_eq!(result == Err(SampleError::Configuration), round >= 6, "round {round}");
    }
}

#[test]
fn a_refused_read_back_is_no_mismatch() {
    let mut adc = Ads131m04::new();
    for round in 1..9 {
        let older = frame(HEALTHY | status::CRC_ERR, CODES);
        let sample = sample(&mut adc, older, frame(HEALTHY, [round; 4]));
        assert!(sample.is_ok_and(|sample| sample.command_refused));
    }
}
