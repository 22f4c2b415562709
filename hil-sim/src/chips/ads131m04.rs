//! The converter ADS131M04 (TI SBAS890D) at register level: it runs on its own clock, filters, buffers
//! two conversions and answers each command one frame late.
//!
//! Not modelled: word lengths other than 24 bits (the chip then answers with zeros), the ANSI CRC, register
//! reads of more than one register (answered like an invalid command), gain, phase, offset and channel
//! enables (stored, without effect), the register map's CRC, global chop and current detection.

use rand_distr::{Distribution, StandardNormal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use shared::wire::ads131m04::{
    self as wire, CODE_MAX, CODE_MIN, FRAME_BYTES, Frame, clock, command, mode, register, status,
};

/// Nominal CLKIN and modulator clock, half of it (section 8.3.6).
const CLKIN_HZ: f64 = 8.192e6;
const MODULATOR_HZ: f64 = CLKIN_HZ / 2.0;

/// Modulator clocks between a reset and the first sample (section 8.4.2).
const START_UP_CLOCKS: f64 = 300.0;

/// How long the SYNC/RESET pin must be low to reset rather than to synchronise (section 6.6).
const RESET_LOW_S: f64 = 2048.0 / CLKIN_HZ;

/// Input-referred noise at gain 1 by OSR field, V rms (Table 7-1), and what is full scale (section 8.5.1.9).
const NOISE_V: [f64; 8] =
    [21.31e-6, 10.68e-6, 7.56e-6, 5.35e-6, 4.25e-6, 3.38e-6, 2.39e-6, 1.90e-6];
const FULL_SCALE_V: f64 = 1.2;

const CODES_FULL_SCALE: f64 = 8_388_608.0;

/// Registers with other defaults than 0 (Table 8-12); ID's lower byte is free to choose.
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

/// Writable registers end with channel 3's gain calibration (Table 8-12).
const LAST_WRITABLE: u8 = 0x1C;

/// What the next frame answers.
#[derive(Clone, Copy, Debug)]
enum Answer {
    Status,
    Word(u16),
}

/// The chip and the analogue inputs' past.
#[derive(Debug)]
pub struct Ads131m04 {
    registers: [u16; 0x40],
    locked: bool,
    standby: bool,
    crc_error: bool,
    resynced: bool,
    answer: Answer,
    pin_low_s: Option<f64>,
    /// Own clock over nominal clock.
    clock_ratio: f64,
    /// Time since the last conversion, in conversions; negative while starting up.
    phase: f64,
    /// Integral of the inputs since the last conversion.
    partial: [f64; 4],
    /// Means of the inputs over the last four conversion intervals, newest last.
    means: [[f64; 4]; 4],
    conversions: u32,
    since_reset: u32,
    unread: u32,
    last_read: [i32; 4],
    rng: Xoshiro256PlusPlus,
}

impl Ads131m04 {
    /// A chip after power-on whose clock is `clock_error_ppm` fast.
    pub fn new(seed: u64, clock_error_ppm: f64) -> Self {
        let mut chip = Self {
            registers: [0; 0x40],
            locked: false,
            standby: false,
            crc_error: false,
            resynced: false,
            answer: Answer::Status,
            pin_low_s: None,
            clock_ratio: 1.0 + 1e-6 * clock_error_ppm,
            phase: 0.0,
            partial: [0.0; 4],
            means: [[0.0; 4]; 4],
            conversions: 0,
            since_reset: 0,
            unread: 0,
            last_read: [0; 4],
            rng: Xoshiro256PlusPlus::seed_from_u64(seed),
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
        self.locked = false;
        self.standby = false;
        self.crc_error = false;
        self.resynced = false;
        self.answer = Answer::Word(command::RESET_DONE);
        self.restart_filter();
        self.phase = -START_UP_CLOCKS / self.oversampling();
        self.since_reset = 0;
        self.last_read = [0; 4];
    }

    /// Level of the SYNC/RESET pin: a long low pulse resets, a short one synchronises (section 6.6).
    pub fn set_reset_pin(&mut self, high: bool) {
        match (high, self.pin_low_s) {
            (false, None) => self.pin_low_s = Some(0.0),
            (true, Some(low_s)) => {
                self.pin_low_s = None;
                if low_s >= RESET_LOW_S {
                    self.reset();
                } else {
                    self.restart_filter();
                    self.resynced = true;
                }
            }
            _ => {}
        }
    }

    /// Falling edges of the data-ready pin since this chip was made, over all its resets: what a counter
    /// at that pin holds.
    pub fn conversions(&self) -> u32 {
        self.conversions
    }

    /// Lets `dt_s` pass with constant inputs in fractions of full scale.
    pub fn advance(&mut self, dt_s: f64, inputs: [f64; 4]) {
        if let Some(low_s) = &mut self.pin_low_s {
            *low_s += dt_s;
        }
        if self.standby || self.in_reset() {
            return;
        }
        let start = self.phase;
        let end = start + dt_s * self.clock_ratio * MODULATOR_HZ / self.oversampling();
        let begun = start.max(0.0);
        let done = end as u32;
        self.phase = end - f64::from(done);
        if done == 0 {
            self.integrate(inputs, end.max(0.0) - begun);
            return;
        }
        self.integrate(inputs, 1.0 - begun);
        self.push(self.partial);
        for _ in 1..done.min(4) {
            self.push(inputs);
        }
        self.partial = inputs.map(|x| x * self.phase);
        self.conversions = self.conversions.wrapping_add(done);
        self.since_reset = self.since_reset.saturating_add(done);
        self.unread = self.unread.saturating_add(done).min(2);
    }

    /// One frame under chip select.
    ///
    /// A frame cut short executes nothing and leaves the conversion unread. Of a full buffer the two newest
    /// conversions are kept: the sheet (section 8.5.1.9.1) only says that there are two.
    pub fn transfer(&mut self, mosi: &[u8], miso: &mut [u8]) {
        miso.fill(0);
        if self.in_reset() || self.word_length() != status::WLENGTH_24 {
            return;
        }
        let response = match self.answer {
            Answer::Word(word) => word,
            Answer::Status => self.status(),
        };
        let codes = self.oldest_unread();
        let bytes = wire::encode(&Frame { response, codes });
        for (slot, byte) in miso.iter_mut().zip(bytes) {
            *slot = byte;
        }
        if mosi.len() < FRAME_BYTES {
            return;
        }
        if matches!(self.answer, Answer::Status) {
            self.crc_error = false;
            self.resynced = false;
        }
        self.last_read = codes;
        self.unread = self.unread.saturating_sub(1);
        self.answer = self.execute(mosi);
    }

    fn in_reset(&self) -> bool {
        self.pin_low_s.is_some_and(|low_s| low_s >= RESET_LOW_S)
    }

    fn content(&self, address: u8) -> u16 {
        self.registers[usize::from(address)]
    }

    fn osr_field(&self) -> usize {
        usize::from(self.content(register::CLOCK) >> clock::OSR_SHIFT & 0b111)
    }

    fn oversampling(&self) -> f64 {
        f64::from(128_u32 << self.osr_field())
    }

    fn word_length(&self) -> u16 {
        self.content(register::MODE) & status::WLENGTH
    }

    fn restart_filter(&mut self) {
        self.phase = 0.0;
        self.partial = [0.0; 4];
        self.means = [[0.0; 4]; 4];
        self.unread = 0;
    }

    fn integrate(&mut self, inputs: [f64; 4], share: f64) {
        for (sum, input) in self.partial.iter_mut().zip(inputs) {
            *sum += input * share;
        }
    }

    fn push(&mut self, mean: [f64; 4]) {
        self.means.rotate_left(1);
        self.means[3] = mean;
    }

    fn status(&self) -> u16 {
        let flag = |set: bool, bit: u16| if set { bit } else { 0 };
        flag(self.locked, status::LOCK)
            | flag(self.resynced, status::F_RESYNC)
            | flag(self.crc_error, status::CRC_ERR)
            | self.content(register::MODE) & (mode::RESET | status::WLENGTH)
            | flag(self.unread > 0, status::DRDY)
    }

    /// Codes that the next frame carries; noise is drawn here, once a conversion.
    fn oldest_unread(&mut self) -> [i32; 4] {
        if self.unread == 0 {
            return self.last_read;
        }
        let behind = self.unread - 1;
        let newest = 3 - behind as usize;
        // The first two conversions after a reset come from a sinc1 filter (section 8.3.7.1.1), the others
        // from the sinc3 filter, whose impulse response integrates to 1/6, 4/6, 1/6 over three intervals.
        let taps = if self.since_reset - behind <= 2 {
            [0.0, 0.0, 1.0]
        } else {
            [1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0]
        };
        let noise = NOISE_V[self.osr_field()] / FULL_SCALE_V * CODES_FULL_SCALE;
        std::array::from_fn(|channel| {
            let input: f64 =
                (0..3).map(|tap| taps[tap] * self.means[newest + tap - 2][channel]).sum();
            let normal: f64 = StandardNormal.sample(&mut self.rng);
            let code = (input * CODES_FULL_SCALE + normal * noise).round();
            (code as i32).clamp(CODE_MIN, CODE_MAX)
        })
    }

    /// Executes a full frame; a bad CRC stops everything but register writes (section 8.3.12).
    fn execute(&mut self, mosi: &[u8]) -> Answer {
        let word = |index: usize| {
            mosi.get(3 * index..3 * index + 2).map_or(0, |w| u16::from_be_bytes([w[0], w[1]]))
        };
        let command = word(0);
        let writes = command & command::KIND == command::WREG;
        let contents = if writes { usize::from(command & 0x7F) + 1 } else { 0 };
        let covered = mosi.get(..3 * (1 + contents)).unwrap_or(mosi);
        let crc_checked = self.content(register::MODE) & mode::RX_CRC_EN != 0;
        let crc_good = !crc_checked || wire::checksum(covered) == word(1 + contents);
        self.crc_error |= !crc_good;
        let address = (command >> 7 & 0x3F) as u8;
        if writes && !self.locked {
            let written =
                (0..contents).filter(|i| self.write(address + *i as u8, word(1 + i))).count();
            let answer = command::written(address) | written.saturating_sub(1) as u16;
            return if crc_good { Answer::Word(answer) } else { Answer::Status };
        }
        if !crc_good {
            return Answer::Status;
        }
        self.control(command, address)
    }

    fn control(&mut self, command: u16, address: u8) -> Answer {
        match command {
            command::UNLOCK => self.locked = false,
            command::LOCK => self.locked = true,
            _ if command == command::read(address) && address != register::STATUS => {
                return Answer::Word(self.content(address));
            }
            _ if self.locked => return Answer::Status,
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
            let oversampling = self.oversampling();
            self.registers[usize::from(address)] = content;
            if self.oversampling() != oversampling {
                self.restart_filter();
            }
        }
        writable
    }
}
