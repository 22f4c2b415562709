//! The converter ADS131M04 (TI SBAS890D) at register level: it runs on its own clock, filters, buffers
//! two conversions and answers each command one frame late.
//!
//! Not modelled: word lengths other than 24 bits and frames cut short (answered with zeros, nothing is
//! executed), the ANSI CRC, reads of more than one register (an invalid command), gain, phase, offset and
//! channel enables (stored, without effect), the register map's CRC, global chop and current detection.

mod filter;
#[cfg(test)]
mod tests;

use filter::Filter;
use shared::wire::ads131m04::{
    self as wire, FRAME_BYTES, Frame, clock, command, mode, register, status,
};

/// How long the SYNC/RESET pin must be low to reset rather than to synchronise: 2048 clocks of CLKIN
/// (section 6.6).
const RESET_LOW_S: f64 = 2048.0 / 8.192e6;

/// Registers with other defaults than 0 (Table 8-12); the lower byte of ID is not specified.
const DEFAULTS: [(u8, u16); 8] = [
    (register::ID, 0x2401),
    (register::MODE, mode::DEFAULT),
    (register::CLOCK, clock::DEFAULT),
    (register::CFG, 0x0600),
    (0x0C, 0x8000),
    (0x11, 0x8000),
    (0x16, 0x8000),
    (0x1B, 0x8000),
];

/// The last writable register, channel 3's gain calibration (Table 8-12).
const LAST_WRITABLE: u8 = 0x1C;

/// What the next frame answers.
#[derive(Clone, Copy)]
enum Answer {
    Status,
    Word(u16),
}

/// The chip.
pub struct Ads131m04 {
    registers: [u16; 0x40],
    filter: Filter,
    locked: bool,
    standby: bool,
    crc_error: bool,
    resynced: bool,
    answer: Answer,
    /// How long the SYNC/RESET pin has been low, if it is.
    pin_low_s: Option<f64>,
}

impl Ads131m04 {
    /// A chip after power-on whose clock is `clock_error_ppm` fast; `seed` is that of its noise.
    pub fn new(seed: u64, clock_error_ppm: f64) -> Self {
        let mut chip = Self {
            registers: [0; 0x40],
            filter: Filter::new(seed, clock_error_ppm),
            locked: false,
            standby: false,
            crc_error: false,
            resynced: false,
            answer: Answer::Status,
            pin_low_s: None,
        };
        chip.reset();
        chip
    }

    /// Power-on reset, as a brown-out causes it in mid-run (section 8.4.1).
    pub fn reset(&mut self) {
        self.registers = [0; 0x40];
        for (address, content) in DEFAULTS {
            self.registers[usize::from(address)] = content;
        }
        self.filter.reset(self.osr_field());
        self.locked = false;
        self.standby = false;
        self.crc_error = false;
        self.resynced = false;
        self.answer = Answer::Word(command::RESET_DONE);
    }

    /// Level of the SYNC/RESET pin: a long low pulse resets, a short one synchronises (section 6.6).
    pub fn set_reset_pin(&mut self, high: bool) {
        match (high, self.pin_low_s) {
            (false, None) => self.pin_low_s = Some(0.0),
            (true, Some(_)) => {
                if self.in_reset() {
                    self.reset();
                } else {
                    self.filter.restart();
                    self.resynced = true;
                }
                self.pin_low_s = None;
            }
            _ => {}
        }
    }

    /// Conversions since this chip was made, over all its resets: what a counter of data-ready pulses
    /// holds.
    pub fn conversions(&self) -> u32 {
        self.filter.conversions()
    }

    /// Lets `dt_s` pass with constant inputs in fractions of full scale.
    pub fn advance(&mut self, dt_s: f64, inputs: [f64; 4]) {
        if let Some(low_s) = &mut self.pin_low_s {
            *low_s += dt_s;
        }
        if !self.standby && !self.in_reset() {
            self.filter.advance(dt_s, inputs);
        }
    }

    /// One frame under chip select.
    pub fn transfer(&mut self, mosi: &[u8], miso: &mut [u8]) {
        miso.fill(0);
        let word_length = self.content(register::MODE) & status::WLENGTH;
        if self.in_reset() || mosi.len() < FRAME_BYTES || word_length != status::WLENGTH_24 {
            return;
        }
        let response = match self.answer {
            Answer::Word(word) => word,
            Answer::Status => self.take_status(),
        };
        let bytes = wire::encode(&Frame { response, codes: self.filter.read() });
        for (slot, byte) in miso.iter_mut().zip(bytes) {
            *slot = byte;
        }
        self.answer = self.execute(mosi);
    }

    fn in_reset(&self) -> bool {
        self.pin_low_s.is_some_and(|low_s| low_s >= RESET_LOW_S)
    }

    fn content(&self, address: u8) -> u16 {
        self.registers[usize::from(address)]
    }

    fn osr_field(&self) -> u8 {
        (self.content(register::CLOCK) >> clock::OSR_SHIFT & 0b111) as u8
    }

    /// The status register, whose event bits clear when it is put out (section 8.3.12).
    fn take_status(&mut self) -> u16 {
        let flag = |set: bool, bit: u16| if set { bit } else { 0 };
        flag(self.locked, status::LOCK)
            | flag(std::mem::take(&mut self.resynced), status::F_RESYNC)
            | flag(std::mem::take(&mut self.crc_error), status::CRC_ERR)
            | self.content(register::MODE) & (mode::RESET | status::WLENGTH)
            | flag(self.filter.data_ready(), status::DRDY)
    }

    /// A bad CRC stops every command but register writes (section 8.3.12).
    fn execute(&mut self, mosi: &[u8]) -> Answer {
        let word = |index: usize| match mosi.get(3 * index..3 * index + 2) {
            Some(&[high, low]) => u16::from_be_bytes([high, low]),
            _ => 0,
        };
        let command = word(0);
        let address = (command >> 7 & 0x3F) as u8;
        let writes = command & command::KIND == command::WREG;
        let contents = if writes { usize::from(command & 0x7F) + 1 } else { 0 };
        let covered = mosi.get(..3 * (1 + contents)).unwrap_or(mosi);
        let checked = self.content(register::MODE) & mode::RX_CRC_EN != 0;
        let crc_good = !checked || wire::checksum(covered) == word(1 + contents);
        self.crc_error |= !crc_good;

        let mut answer = Answer::Status;
        if writes && !self.locked {
            let written =
                (0..contents).filter(|i| self.write(address + *i as u8, word(1 + i))).count();
            answer = Answer::Word(command::written(address) | written.saturating_sub(1) as u16);
        }
        match (crc_good, writes) {
            (false, _) => Answer::Status,
            (true, true) => answer,
            (true, false) => self.control(command, address),
        }
    }

    /// Any command but a register write; a locked interface takes only three of them (Table 8-11).
    fn control(&mut self, command: u16, address: u8) -> Answer {
        match command {
            command::UNLOCK => self.locked = false,
            _ if command == command::read(address) && address != register::STATUS => {
                return Answer::Word(self.content(address));
            }
            _ if self.locked => return Answer::Status,
            command::LOCK => self.locked = true,
            command::RESET => {
                self.reset();
                return self.answer;
            }
            command::STANDBY => self.standby = true,
            command::WAKEUP => self.standby = false,
            _ => return Answer::Status,
        }
        Answer::Word(command)
    }

    /// Writes one register if it can be written.
    fn write(&mut self, address: u8, content: u16) -> bool {
        let writable = (register::MODE..=LAST_WRITABLE).contains(&address);
        if writable {
            let osr_field = self.osr_field();
            self.registers[usize::from(address)] = content;
            if self.osr_field() != osr_field {
                self.filter.set_oversampling(self.osr_field());
            }
        }
        writable
    }
}
