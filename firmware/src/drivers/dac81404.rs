//! Torque-drive DAC (TI DAC81404): configuration after reset and the write of every tick.
//!
//! The device answers one frame late, so each frame carries back the verdict on the one before it.
//! SPI mode 1, SCLK at most 12.5 MHz (SLASEH2A Section 7.8), one frame a chip-select.

use embedded_hal::spi::SpiDevice;
use shared::wire::dac81404::{
    ALL_CHANNELS, Answer, CHANNELS, Frame, MID_SCALE, RANGE_10_V, is_echo, register, spiconfig,
    trigger,
};

use super::Progress;

/// What [`Dac81404::write`] learned from the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Acknowledge {
    /// All four codes were echoed and no CRC error was reported: LDAC may be pulsed.
    pub accepted: bool,
    /// Status register at the end of the previous write; bits in [`shared::wire::dac81404::status`].
    ///
    /// `None` where no valid answer came or the bus failed. A device that was reset in between falls back to frames without
    /// CRC and may still echo codes; only this answer's missing CRC tells it.
    pub status: Option<u16>,
    /// Every answer ends as those of a device do that was reset: with the byte that it received first.
    pub reset: bool,
}

/// One register of the configuration.
struct Setting {
    frame: Frame,
    /// Register read after the write, and the content it must have.
    check: (u8, u16),
}

impl Setting {
    const fn readable(address: u8, value: u16) -> Self {
        Self { frame: Frame::write(address, value), check: (address, value) }
    }

    /// The register reads as 0, so its echo must do; instead no alarm may be set.
    const fn write_only(address: u8, value: u16) -> Self {
        Self { frame: Frame::write(address, value), check: (register::STATUS, 0) }
    }
}

const SPICONFIG: u16 = spiconfig::RESET & !spiconfig::DEV_PWDWN | spiconfig::CRC_EN;

/// Frame checking comes first. Mid-scale has to reach the active registers before the outputs are powered:
/// they reset to code 0, which is -10 V in this range, and in synchronous mode only LDAC moves them.
const SETTINGS: [Setting; 7] = [
    Setting::readable(register::SPICONFIG, SPICONFIG),
    Setting::readable(register::GENCONFIG, 0),
    Setting::readable(register::SYNCCONFIG, ALL_CHANNELS),
    Setting::write_only(register::DACRANGE, RANGE_10_V),
    Setting::write_only(register::BRDCAST, MID_SCALE),
    Setting::write_only(register::TRIGGER, trigger::SOFT_LDAC),
    Setting::readable(register::DACPWDWN, !ALL_CHANNELS),
];

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum State {
    /// Number of settings written so far.
    Booting(usize),
    Ready,
    Failed,
}

/// Driver of one DAC81404.
#[derive(Debug)]
pub struct Dac81404 {
    state: State,
}

impl Default for Dac81404 {
    fn default() -> Self {
        Self::new()
    }
}

impl Dac81404 {
    /// A driver of a device that was reset by its RST pin at least 1 ms ago (SLASEO0B Section 8.3.3).
    pub const fn new() -> Self {
        Self { state: State::Booting(0) }
    }

    /// Writes the next setting and checks the one before: two frames a call, ready after eight calls.
    ///
    /// Ends with outputs powered at 0 V, updating at LDAC, in the ±10 V range.
    pub fn boot_step<S: SpiDevice>(&mut self, spi: &mut S) -> Progress {
        if let State::Booting(written) = self.state {
            self.state = configure(spi, written).unwrap_or(State::Failed);
        }
        match self.state {
            State::Booting(_) => Progress::Busy,
            State::Ready => Progress::Ready,
            State::Failed => Progress::Failed,
        }
    }

    /// Sends the codes of channels A to D (offset binary) and asks for the status: always five frames.
    ///
    /// The outputs follow at the next falling edge of LDAC, which must come only if the codes were accepted
    /// and at least 80 ns after the last frame (SLASEH2A Section 7.6). Before [`Progress::Ready`] nothing
    /// is sent.
    #[inline(always)]
    pub fn write<S: SpiDevice>(&mut self, spi: &mut S, codes: [u16; CHANNELS]) -> Acknowledge {
        if self.state != State::Ready {
            return Acknowledge::default();
        }
        let [a, b, c, d] = codes;
        let a = Frame::write(register::DACA, a).to_bytes();
        let b = Frame::write(register::DACB, b).to_bytes();
        let c = Frame::write(register::DACC, c).to_bytes();
        let d = Frame::write(register::DACD, d).to_bytes();
        let mut frames = [a, b, c, d, const { Frame::read(register::STATUS).to_bytes() }];
        let mut exchanged = true;
        // No short cut: the bus schedule stays the same whatever the device answers.
        for frame in &mut frames {
            exchanged &= spi.transfer_in_place(frame).is_ok();
        }
        if !exchanged {
            return Acknowledge::default();
        }
        let [status, echo_a, echo_b, echo_c, echo_d] = frames;
        let accepted =
            is_echo(a, echo_a) & is_echo(b, echo_b) & is_echo(c, echo_c) & is_echo(d, echo_d);
        let status = content(status, register::STATUS);
        Acknowledge { accepted, status, reset: status.is_none() && is_without_crc(&frames) }
    }
}

/// Whether the answers of one write have 24 bits, behind which the device hands on what comes in.
#[cold]
#[inline(never)]
fn is_without_crc(answers: &[[u8; 4]; 5]) -> bool {
    const HEADS: [u8; 5] = [
        register::DACA,
        register::DACB,
        register::DACC,
        register::DACD,
        Frame::read(register::STATUS).to_bytes_without_crc()[0],
    ];
    answers.iter().zip(HEADS).all(|([_, _, _, last], head)| *last == head)
}

/// Writes setting number `written` and asks for its check; `None` where anything fails.
#[inline(never)]
fn configure<S: SpiDevice>(spi: &mut S, written: usize) -> Option<State> {
    let Some(setting) = SETTINGS.get(written) else {
        let answer = exchange(spi, &Frame::read(register::STATUS))?;
        return passed(answer, written).then_some(State::Ready);
    };
    let query = Frame::read(setting.check.0);
    if written == 0 {
        // Until CRC-EN is set the device wants 24 bits; the echo of that frame has no CRC yet.
        spi.write(&setting.frame.to_bytes_without_crc()).ok()?;
        exchange(spi, &query)?;
    } else {
        let answer = exchange(spi, &setting.frame)?;
        let echoed = is_echoed(spi, &query, &setting.frame);
        if !(echoed && passed(answer, written)) {
            return None;
        }
    }
    Some(State::Booting(written + 1))
}

/// Whether `answer` is what the check of the last of `written` settings must read.
fn passed(answer: [u8; 4], written: usize) -> bool {
    SETTINGS
        .get(written.wrapping_sub(1))
        .is_some_and(|last| content(answer, last.check.0) == Some(last.check.1))
}

/// Sends `next` and tells whether its answer echoes `sent`, the frame before it.
fn is_echoed<S: SpiDevice>(spi: &mut S, next: &Frame, sent: &Frame) -> bool {
    exchange(spi, next).is_some_and(|answer| sent.is_echoed_by(answer))
}

/// One transaction: sends `frame`, returns the answer to the frame before it.
#[inline(never)]
fn exchange<S: SpiDevice>(spi: &mut S, frame: &Frame) -> Option<[u8; 4]> {
    let mut bytes = frame.to_bytes();
    spi.transfer_in_place(&mut bytes).ok()?;
    Some(bytes)
}

fn content(answer: [u8; 4], address: u8) -> Option<u16> {
    Answer::from_bytes(answer)?.content_of(address)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec;
    use std::vec::Vec;

    use embedded_hal_mock::eh1::spi::{Mock, Transaction};

    use super::*;

    const CODES: [u16; 4] = [0x8000, 0xFFFF, 0x1234, 0x0000];

    /// One chip-select: `sent` goes out while `answer` comes in.
    fn exchange_of(sent: [u8; 4], answer: [u8; 4]) -> [Transaction<u8>; 3] {
        [
            Transaction::transaction_start(),
            Transaction::transfer_in_place(sent.to_vec(), answer.to_vec()),
            Transaction::transaction_end(),
        ]
    }

    fn echo(address: u8, data: u16) -> [u8; 4] {
        Answer { address, data, ..Answer::default() }.to_bytes()
    }

    fn reading(address: u8, data: u16) -> [u8; 4] {
        Answer { read: true, crc_error: false, address, data }.to_bytes()
    }

    /// The five answers of a good write; the first is the status asked for one write earlier.
    fn good_answers() -> [[u8; 4]; 5] {
        let [a, b, c, d] = CODES;
        [reading(0x02, 0), echo(0x10, a), echo(0x11, b), echo(0x12, c), echo(0x13, d)]
    }

    fn write_with(answers: [[u8; 4]; 5]) -> Acknowledge {
        let [a, b, c, d] = CODES;
        let frames = [
            Frame::write(0x10, a),
            Frame::write(0x11, b),
            Frame::write(0x12, c),
            Frame::write(0x13, d),
            Frame::read(0x02),
        ];
        let expected: Vec<_> = frames
            .iter()
            .zip(answers)
            .flat_map(|(frame, answer)| exchange_of(frame.to_bytes(), answer))
            .collect();
        let mut spi = Mock::new(&expected);
        let acknowledge = Dac81404 { state: State::Ready }.write(&mut spi, CODES);
        spi.done();
        acknowledge
    }

    #[test]
    fn a_good_write_is_accepted() {
        assert_eq!(
            write_with(good_answers()),
            Acknowledge { accepted: true, status: Some(0), reset: false }
        );
    }

    #[test]
    fn each_missing_echo_or_error_bit_is_told_and_five_frames_still_go_out() {
        for bad in 1..5 {
            for answer in [[0; 4], [0xFF; 4], echo(0x10 + bad as u8 - 1, 0x5555)] {
                let mut answers = good_answers();
                answers[bad] = answer;
                let told = write_with(answers);
                assert_eq!(
                    told,
                    Acknowledge { accepted: false, status: Some(0), reset: false },
                    "{bad}"
                );
            }
            let mut answers = good_answers();
            answers[bad][0] |= 1 << 6;
            assert!(!write_with(answers).accepted, "CRC error of frame {bad}");
        }
    }

    #[test]
    fn only_a_status_with_its_crc_counts() {
        // A device without CRC repeats the first byte it receives instead: 10h, the address of channel A.
        for wrong in [[0x82, 0, 0, 0x10], [0; 4], [0xFF; 4], reading(0x03, 0), echo(0x02, 0)] {
            let mut answers = good_answers();
            answers[0] = wrong;
            assert_eq!(
                write_with(answers),
                Acknowledge { accepted: true, status: None, reset: false }
            );
        }
    }

    #[test]
    fn nothing_is_written_before_ready() {
        let mut spi = Mock::new(&[]);
        assert_eq!(Dac81404::new().write(&mut spi, CODES), Acknowledge::default());
        spi.done();
    }

    #[test]
    fn boot_starts_with_24_bits_and_fails_on_a_wrong_read_back() {
        let config = [0x03, 0x0A, 0x94];
        let mut expected = vec![
            Transaction::transaction_start(),
            Transaction::write_vec(config.to_vec()),
            Transaction::transaction_end(),
        ];
        expected.extend(exchange_of(Frame::read(0x03).to_bytes(), [0; 4]));
        // The reset value instead of what was written.
        expected.extend(exchange_of(Frame::write(0x04, 0).to_bytes(), reading(0x03, 0x0AA4)));
        expected.extend(exchange_of(Frame::read(0x04).to_bytes(), echo(0x04, 0)));
        let mut spi = Mock::new(&expected);
        let mut dac = Dac81404::new();
        assert_eq!(dac.boot_step(&mut spi), Progress::Busy);
        assert_eq!(dac.boot_step(&mut spi), Progress::Failed);
        assert_eq!(dac.boot_step(&mut spi), Progress::Failed);
        spi.done();
    }
}
