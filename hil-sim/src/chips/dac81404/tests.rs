//! The firmware's driver against the simulated chip, and the chip alone where the driver never goes.

use embedded_hal::spi::{ErrorType, Operation, SpiDevice};
use firmware::drivers::Progress;
use firmware::drivers::dac81404::{Acknowledge, Dac81404 as Driver};

use super::*;

/// Three quarters up, the lowest code, the highest and zero.
const CODES: [u16; CHANNELS] = [0xE000, 0x0000, 0xFFFF, 0x8000];
const OUTPUTS: [f64; CHANNELS] = [0.75, -1.0, 32_767.0 / 32_768.0, 0.0];
const GOOD: Acknowledge = Acknowledge { accepted: true, status: Some(0), reset: false };

/// The chip on a bus that can lose frames or flip bits, frames counted from 0.
struct Bus {
    chip: Dac81404,
    frame: usize,
    lost: Option<usize>,
    flipped_to_chip: Option<(usize, u32)>,
    flipped_from_chip: Option<(usize, u32)>,
}

impl Bus {
    fn new() -> Self {
        Self {
            chip: Dac81404::default(),
            frame: 0,
            lost: None,
            flipped_to_chip: None,
            flipped_from_chip: None,
        }
    }

    fn booted() -> (Self, Driver) {
        let (mut bus, mut driver) = (Self::new(), Driver::new());
        for _ in 0..7 {
            assert_eq!(driver.boot_step(&mut bus), Progress::Busy);
        }
        assert_eq!(driver.boot_step(&mut bus), Progress::Ready);
        bus.frame = 0;
        (bus, driver)
    }

    fn exchange(&mut self, bytes: &mut [u8]) {
        let frame = self.frame;
        self.frame += 1;
        if self.lost == Some(frame) {
            bytes.fill(0xFF);
            return;
        }
        let mut mosi = bytes.to_vec();
        flip(&mut mosi, self.flipped_to_chip, frame);
        self.chip.transfer(&mosi, bytes);
        flip(bytes, self.flipped_from_chip, frame);
    }
}

/// Flips bit `bit`, 0 being the last of a 32-bit frame.
fn flip(bytes: &mut [u8], what: Option<(usize, u32)>, frame: usize) {
    if let Some((at, bit)) = what
        && at == frame
    {
        bytes[3 - bit as usize / 8] ^= 1 << (bit % 8);
    }
}

impl ErrorType for Bus {
    type Error = core::convert::Infallible;
}

impl SpiDevice for Bus {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Self::Error> {
        for operation in operations {
            match operation {
                Operation::TransferInPlace(bytes) => self.exchange(bytes),
                Operation::Write(bytes) => self.exchange(&mut bytes.to_vec()),
                _ => unreachable!("the driver uses no other operation"),
            }
        }
        Ok(())
    }
}

#[test]
fn boots_with_all_outputs_at_zero_from_the_first_step_on() {
    let (mut bus, mut driver) = (Bus::new(), Driver::new());
    for _ in 0..8 {
        driver.boot_step(&mut bus);
        assert_eq!(bus.chip.outputs(), [0.0; CHANNELS]);
    }
    let chip = &bus.chip;
    assert_eq!((chip.spiconfig, chip.genconfig, chip.syncconfig), (0x0A94, 0, 0xF));
    assert_eq!((chip.dacrange, chip.dacpwdwn, chip.active), (0x6666, 0, [MID_SCALE; CHANNELS]));
}

#[test]
fn boots_a_chip_that_already_checks_frames() {
    let (bus, _) = Bus::booted();
    let mut bus = Bus { chip: bus.chip, ..Bus::new() };
    let mut driver = Driver::new();
    for _ in 0..8 {
        driver.boot_step(&mut bus);
    }
    assert_eq!(driver.boot_step(&mut bus), Progress::Ready);
}

#[test]
fn boot_fails_whatever_frame_is_lost() {
    for lost in 0..15 {
        let mut bus = Bus { lost: Some(lost), ..Bus::new() };
        let mut driver = Driver::new();
        let last = (0..8).map(|_| driver.boot_step(&mut bus)).last();
        assert_eq!(last, Some(Progress::Failed), "frame {lost}");
        assert_eq!(bus.chip.outputs(), [0.0; CHANNELS]);
    }
}

#[test]
fn outputs_move_at_ldac_and_only_then() {
    let (mut bus, mut driver) = Bus::booted();
    assert_eq!(driver.write(&mut bus, CODES), GOOD);
    assert_eq!(bus.frame, 5);
    assert_eq!(bus.chip.outputs(), [0.0; CHANNELS]);
    bus.chip.ldac();
    assert_eq!(bus.chip.outputs(), OUTPUTS);
    assert_eq!(driver.write(&mut bus, [0x8000; CHANNELS]), GOOD);
    assert_eq!(bus.chip.outputs(), OUTPUTS);
}

#[test]
fn any_flipped_bit_of_a_code_is_refused_by_the_chip_and_told() {
    for frame in 0..4 {
        for bit in 0..32 {
            let (mut bus, mut driver) = Bus::booted();
            bus.flipped_to_chip = Some((frame, bit));
            let told = driver.write(&mut bus, CODES);
            assert!(!told.accepted, "frame {frame}, bit {bit}");
            assert_eq!(bus.chip.buffer[frame], MID_SCALE);
            assert_eq!(bus.chip.outputs(), [0.0; CHANNELS]);
            // The next write is good again, and its status tells of the alarm.
            let told = driver.write(&mut bus, CODES);
            assert_eq!(told, Acknowledge { status: Some(status::CRC_ALM), ..GOOD });
        }
    }
}

#[test]
fn any_flipped_bit_of_an_answer_that_matters_is_told() {
    for frame in 0..5 {
        for bit in 0..32 {
            let (mut bus, mut driver) = Bus::booted();
            bus.flipped_from_chip = Some((frame, bit));
            let told = driver.write(&mut bus, CODES);
            let known_anyway = frame > 0 && (bit < 8 || bit == 31);
            assert_eq!(told == GOOD, known_anyway, "frame {frame}, bit {bit}");
        }
    }
}

#[test]
fn any_lost_frame_is_told() {
    for lost in 0..5 {
        let (mut bus, mut driver) = Bus::booted();
        bus.lost = Some(lost);
        assert_ne!(driver.write(&mut bus, CODES), GOOD, "frame {lost}");
    }
}

#[test]
fn a_reset_between_two_writes_is_told_by_the_missing_status() {
    let (mut bus, mut driver) = Bus::booted();
    driver.write(&mut bus, CODES);
    bus.chip.ldac();
    bus.chip.reset();
    assert_eq!(bus.chip.outputs(), [0.0; CHANNELS]);
    for _ in 0..3 {
        assert_eq!(driver.write(&mut bus, CODES).status, None);
        assert_eq!(bus.chip.outputs(), [0.0; CHANNELS]);
    }
    // Asynchronous again: codes reach the converters without LDAC, behind powered-down amplifiers.
    assert_eq!(bus.chip.active, CODES);
}

#[test]
fn a_reset_within_a_write_is_told_at_once_or_by_the_next_status() {
    for frame in 1..5 {
        let (mut bus, mut driver) = Bus::booted();
        for at in 0..5 {
            if at == frame {
                bus.chip.reset();
            }
            let code = Frame::write(register::DACA + at as u8, CODES[at % CHANNELS]);
            let sent = if at < 4 { code } else { Frame::read(register::STATUS) };
            let mut bytes = sent.to_bytes();
            bus.exchange(&mut bytes);
            if at == frame {
                assert_eq!(bytes[..3], [0; 3]);
            }
        }
        assert_eq!(driver.write(&mut bus, CODES).status, None);
    }
}

/// Sends one frame and returns what the chip shifts out.
fn send<const N: usize>(chip: &mut Dac81404, mosi: [u8; N]) -> [u8; N] {
    let mut miso = [0; N];
    chip.transfer(&mosi, &mut miso);
    miso
}

#[test]
fn registers_reset_to_the_sheets_values() {
    let mut chip = Dac81404::default();
    for (address, [high, low]) in [
        (register::DEVICEID, [0x0A, 0x60]),
        (register::STATUS, [0, 0]),
        (register::SPICONFIG, [0x0A, 0xA4]),
        (register::GENCONFIG, [0x40, 0]),
        (register::BRDCONFIG, [0, 0x0F]),
        (register::SYNCCONFIG, [0, 0]),
        (register::DACPWDWN, [0xFF, 0xFF]),
        (register::DACRANGE, [0, 0]),
    ] {
        send(&mut chip, Frame::read(address).to_bytes_without_crc());
        assert_eq!(send(&mut chip, [0; 3]), [0x80 | address, high, low]);
    }
}

#[test]
fn frames_count_their_first_24_or_32_bits_and_shorter_ones_nothing() {
    let mut chip = Dac81404::default();
    send(&mut chip, [register::SYNCCONFIG, 0]);
    assert_eq!(
        send(&mut chip, [register::SYNCCONFIG, 0, 5, 0x77]),
        [0, 0, 0, register::SYNCCONFIG]
    );
    assert_eq!(chip.syncconfig, 5);
    let frame = Frame::write(register::SPICONFIG, 0x0A94).to_bytes_without_crc();
    send(&mut chip, frame);
    send(&mut chip, Frame::write(register::SYNCCONFIG, 0xF).to_bytes_without_crc());
    assert_eq!((chip.syncconfig, chip.alarms), (5, 0));
}

#[test]
fn the_range_decides_what_a_code_means() {
    let mut chip = Dac81404::default();
    for (address, data) in [
        (register::SPICONFIG, 0x0A84),
        (register::GENCONFIG, 0),
        (register::DACPWDWN, 0),
        (register::BRDCAST, MID_SCALE),
    ] {
        send(&mut chip, Frame::write(address, data).to_bytes_without_crc());
    }
    assert_eq!(chip.outputs(), [0.25; CHANNELS]);
    send(&mut chip, Frame::write(register::DACRANGE, 0x6666).to_bytes_without_crc());
    assert_eq!(chip.outputs(), [0.0; CHANNELS]);
    send(&mut chip, Frame::write(register::DACB, 0).to_bytes_without_crc());
    assert_eq!(chip.outputs(), [0.0, -1.0, 0.0, 0.0]);
    send(&mut chip, Frame::write(register::TRIGGER, trigger::SOFT_CLR).to_bytes_without_crc());
    assert_eq!(chip.outputs(), [0.0; CHANNELS]);
    send(&mut chip, Frame::write(register::TRIGGER, trigger::SOFT_RESET).to_bytes_without_crc());
    assert_eq!(chip.spiconfig, spiconfig::RESET);
}
