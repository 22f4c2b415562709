//! What each kind does to frames.

use shared::arm::{JOINTS, REFERENCE};
use shared::wire::ads131m04::{Frame, encode};
use shared::wire::biss_c::FrameError;

use super::super::Target;
use super::*;

const ENCODER: Device = Device::Encoder(1);

fn fault(kind: Kind, target: Target, severity: f64) -> FrameFault {
    let injection = Injection { severity, ..Injection::new(kind, target, 0.0) };
    FrameFault::new(&injection, &REFERENCE, 1).expect("a fault of frames")
}

fn layout() -> Layout {
    Layout::new(REFERENCE.encoders[1].bits).expect("a width that a head has")
}

fn word(position: u32) -> [u8; 8] {
    layout().encode(Word { position, error: false, warning: false })
}

/// Bits that differ, first to last.
fn flipped(a: &[u8], b: &[u8]) -> Vec<usize> {
    (0..8 * a.len()).filter(|bit| (a[bit / 8] ^ b[bit / 8]) << (bit % 8) & 0x80 != 0).collect()
}

fn spoilt(fault: &mut FrameFault) -> [u8; 8] {
    let mut miso = word(0x155_5555);
    fault.spoil_answer(ENCODER, 0, &mut miso);
    miso
}

#[test]
fn as_many_bits_are_flipped_as_asked_for() {
    for count in [1, 2, 7, 32] {
        let mut fault = fault(Kind::BitFlips, Target::Encoders, f64::from(count));
        for _ in 0..100 {
            assert_eq!(flipped(&word(0x155_5555), &spoilt(&mut fault)).len(), count as usize);
        }
    }
}

#[test]
fn bursts_have_their_length_and_wander() {
    for length in [1, 6, 32] {
        let mut fault = fault(Kind::Burst, Target::Encoder(1), length as f64);
        let firsts = (0..200).map(|_| {
            let bits = flipped(&word(0x155_5555), &spoilt(&mut fault));
            assert_eq!(bits[bits.len() - 1] - bits[0] + 1, length);
            bits[0]
        });
        let firsts = firsts.collect::<std::collections::BTreeSet<_>>();
        assert!(firsts.len() > 20, "{firsts:?}");
    }
}

#[test]
fn dac_is_hit_on_the_way_there_or_back_and_never_both() {
    let mut fault = fault(Kind::BitFlips, Target::Dac, 1.0);
    let mut there = 0;
    for _ in 0..1_000 {
        let (mut mosi, mut miso) = ([0; 4], [0; 4]);
        fault.spoil_request(Device::Dac, &mut mosi);
        fault.spoil_answer(Device::Dac, 0, &mut miso);
        assert_ne!(mosi == [0; 4], miso == [0; 4]);
        there += u32::from(mosi != [0; 4]);
    }
    assert!((400..600).contains(&there), "{there}");
}

#[test]
fn random_words_pass_the_check_once_in_64_or_always() {
    let share = |severity| {
        let mut fault = fault(Kind::Mutation, Target::All, severity);
        let results = (0..6_400).map(|_| layout().decode(&spoilt(&mut fault)));
        let results = results.collect::<Vec<_>>();
        assert!(results.iter().all(|r| *r != Err(FrameError::Framing)));
        results.iter().filter(|r| r.is_ok()).count()
    };
    assert!((60..140).contains(&share(0.0)), "{}", share(0.0));
    assert_eq!(share(1.0), 6_400);
    assert!((3_000..3_500).contains(&share(0.5)), "{}", share(0.5));
}

#[test]
fn converters_get_random_codes_with_a_check_sum_that_fits() {
    let frame = Frame { response: 0x810F, codes: [1, 2, 3, 4] };
    let mut miso = encode(&frame);
    fault(Kind::Mutation, Target::Adc, 1.0).spoil_answer(Device::Adc, 0, &mut miso);
    let mutated = ads131m04::decode(&miso).expect("a check sum that fits");
    assert!(mutated.response == frame.response && mutated.codes != frame.codes);
    fault(Kind::Zeros, Target::Adc, 0.0).spoil_answer(Device::Adc, 0, &mut miso);
    assert_eq!(ads131m04::decode(&miso), Ok(Frame { codes: [0; JOINTS], ..frame }));

    let answer = dac81404::Answer { address: 0x10, data: 7, ..Default::default() };
    let mut miso = answer.to_bytes();
    fault(Kind::Mutation, Target::Dac, 1.0).spoil_answer(Device::Dac, 0, &mut miso);
    let mutated = dac81404::Answer::from_bytes(miso).expect("a check sum that fits");
    assert!(mutated.address == answer.address && mutated.data != answer.data);
}

#[test]
fn losses_come_in_the_share_asked_for() {
    let lost = |severity| {
        let mut fault = fault(Kind::FrameLoss, Target::Encoders, severity);
        (0..10_000).filter(|_| fault.loses(ENCODER, 0)).count()
    };
    assert_eq!([lost(0.0), lost(1.0)], [0, 10_000]);
    assert!((900..1_100).contains(&lost(0.1)), "{}", lost(0.1));
    assert!(!fault(Kind::FrameLoss, Target::Encoders, 1.0).loses(Device::Adc, 0));
    let mut fault = fault(Kind::FrameLoss, Target::All, 0.5);
    for _ in 0..100 {
        let lost = [0, 1, 2, 3, 4].map(|frame| fault.loses(Device::Dac, frame));
        assert!(lost == [true; 5] || lost == [false; 5]);
    }
}

#[test]
fn dead_lines_are_low_high_or_an_error() {
    let dead = |severity| fault(Kind::Dead, Target::All, severity);
    assert_eq!([0.0, 1.0].map(|s| spoilt(&mut dead(s))), [[0; 8], [0xFF; 8]]);
    assert_eq!([0.0, 1.0, 2.0].map(|s| dead(s).loses(ENCODER, 0)), [false, false, true]);
    assert_eq!(spoilt(&mut fault(Kind::Missing, Target::Encoder(1), 0.0)), [0xFF; 8]);
}

#[test]
fn answers_are_repeated_frame_by_frame() {
    let mut fault = fault(Kind::Repeat, Target::Adc, 0.0);
    let good = [[1; 18], [2; 18]];
    for (frame, answer) in good.iter().enumerate() {
        fault.keep(Device::Adc, frame, &[9; 18]);
        fault.keep(Device::Adc, frame, answer);
    }
    for _ in 0..3 {
        for (frame, answer) in good.iter().enumerate() {
            let mut miso = [0; 18];
            fault.spoil_answer(Device::Adc, frame, &mut miso);
            assert_eq!(miso, *answer);
        }
    }
}

#[test]
fn swapped_encoders_answer_for_each_other() {
    let fault = fault(Kind::Swap, Target::Encoder(1), 4.0);
    let routes = [0, 1, 2, 3].map(|j| fault.route(Device::Encoder(j)));
    assert_eq!(routes, [0, 3, 2, 1].map(Device::Encoder));
    assert_eq!(fault.route(Device::Adc), Device::Adc);
}
