//! Simulated TI DAC81404 at register level (SLASEH2A; frame checking as in SLASEO0B Section 8.5.3).
//!
//! Not modelled: the 1 ms after a reset in which the device does not answer, the analogue settling, die
//! temperature and the FAULT and CLR pins.

use shared::wire::dac81404::{
    ALL_CHANNELS, Answer, CHANNELS, Frame, GENCONFIG_REFERENCE_OFF, MID_SCALE, register, spiconfig,
    status, trigger,
};

/// Full scale of the drives' inputs, V.
const FULL_SCALE_V: f64 = 10.0;

/// DEVICEID after SLASEH2A Table 8-7. Do not rely on it: a DAC61404 was seen to report its two-channel
/// sister's number (TI E2E thread 1217246).
const DEVICE_ID: u16 = 0x0A60;

/// Registers and output latches of one device.
#[derive(Clone, Debug)]
pub struct Dac81404 {
    spiconfig: u16,
    genconfig: u16,
    brdconfig: u16,
    syncconfig: u16,
    dacpwdwn: u16,
    dacrange: u16,
    alarms: u16,
    /// Codes as written.
    buffer: [u16; CHANNELS],
    /// Codes at the converters.
    active: [u16; CHANNELS],
    /// What the next frame shifts out.
    answer: Answer,
}

impl Default for Dac81404 {
    /// The state after a reset (SLASEH2A Table 8-7): asynchronous, 0 V to 5 V, all powered down.
    fn default() -> Self {
        Self {
            spiconfig: spiconfig::RESET,
            genconfig: GENCONFIG_REFERENCE_OFF,
            brdconfig: ALL_CHANNELS,
            syncconfig: 0,
            dacpwdwn: ALL_CHANNELS,
            dacrange: 0,
            alarms: 0,
            buffer: [0; CHANNELS],
            active: [0; CHANNELS],
            answer: Answer::default(),
        }
    }
}

impl Dac81404 {
    /// Power-on reset: brown-out, RST pin or the reset code in TRIGGER.
    pub fn reset(&mut self) {
        *self = Self::default();
    }

    /// One frame, from chip-select low to high. `mosi` and `miso` have the same length.
    pub fn transfer(&mut self, mosi: &[u8], miso: &mut [u8]) {
        let crc = self.spiconfig & spiconfig::CRC_EN != 0;
        let width = if crc { 4 } else { 3 };
        self.shift_out(width, mosi, miso);
        // A shorter frame is ignored; of a longer one the first bits count (SLASEO0B Section 8.5.1).
        match *mosi {
            [head, high, low, check, ..] if crc => {
                match Frame::from_bytes([head, high, low, check]) {
                    Some(frame) => self.execute(frame),
                    None => self.refuse(Frame::from_bytes_without_crc([head, high, low])),
                }
            }
            [head, high, low, ..] if !crc => {
                self.execute(Frame::from_bytes_without_crc([head, high, low]));
            }
            _ => {}
        }
    }

    /// Falling edge of LDAC: channels in synchronous mode take their buffered codes.
    pub fn ldac(&mut self) {
        for channel in channels(self.syncconfig) {
            self.active[channel] = self.buffer[channel];
        }
    }

    /// Output voltages over 10 V, channels A to D; 0 where powered down (10 kΩ to ground).
    ///
    /// No external reference is fitted, so nothing comes out while the internal one is off.
    pub fn outputs(&self) -> [f64; CHANNELS] {
        let device_off = self.spiconfig & spiconfig::DEV_PWDWN != 0
            || self.genconfig & GENCONFIG_REFERENCE_OFF != 0;
        core::array::from_fn(|channel| {
            if device_off || self.dacpwdwn & 1 << channel != 0 {
                return 0.0;
            }
            let (lowest_v, span_v) = range_v(self.range_code(channel));
            // SLASEO0B Equation 1.
            (f64::from(self.active[channel]) / 65_536.0 * span_v + lowest_v) / FULL_SCALE_V
        })
    }

    /// After `width` bytes the shift register hands on what came in (SLASEO0B Section 8.5.2).
    fn shift_out(&self, width: usize, mosi: &[u8], miso: &mut [u8]) {
        if self.spiconfig & spiconfig::SDO_EN == 0 {
            miso.fill(0xFF);
            return;
        }
        let answer = self.answer.to_bytes();
        let stream = answer.iter().take(width).chain(mosi);
        for (out, byte) in miso.iter_mut().zip(stream) {
            *out = *byte;
        }
    }

    fn execute(&mut self, frame: Frame) {
        self.answer = Answer {
            read: frame.read,
            crc_error: false,
            address: frame.address,
            data: if frame.read { self.content(frame.address) } else { frame.data },
        };
        if !frame.read {
            self.write(frame.address, frame.data);
        }
    }

    fn refuse(&mut self, frame: Frame) {
        self.alarms |= status::CRC_ALM;
        self.answer =
            Answer { read: frame.read, crc_error: true, address: frame.address, data: frame.data };
    }

    fn content(&self, address: u8) -> u16 {
        match address {
            register::DEVICEID => DEVICE_ID,
            register::STATUS => self.alarms,
            register::SPICONFIG => self.spiconfig,
            register::GENCONFIG => self.genconfig,
            register::BRDCONFIG => self.brdconfig,
            register::SYNCCONFIG => self.syncconfig,
            register::DACPWDWN => self.dacpwdwn | !ALL_CHANNELS,
            _ => 0,
        }
    }

    fn write(&mut self, address: u8, data: u16) {
        match address {
            register::SPICONFIG => {
                self.spiconfig = self.spiconfig & !spiconfig::WRITABLE | data & spiconfig::WRITABLE;
            }
            register::GENCONFIG => self.genconfig = data & GENCONFIG_REFERENCE_OFF,
            register::BRDCONFIG => self.brdconfig = data & ALL_CHANNELS,
            register::SYNCCONFIG => self.syncconfig = data & ALL_CHANNELS,
            register::DACPWDWN => self.dacpwdwn = data & ALL_CHANNELS,
            register::DACRANGE => self.dacrange = data,
            register::TRIGGER => self.trigger(data),
            register::BRDCAST => {
                for channel in channels(self.brdconfig) {
                    self.load(channel, data);
                }
            }
            register::DACA..=register::DACD => {
                self.load(usize::from(address - register::DACA), data)
            }
            _ => {}
        }
    }

    /// In asynchronous mode the output follows at once (SLASEH2A Section 8.3.3.1.2).
    fn load(&mut self, channel: usize, code: u16) {
        self.buffer[channel] = code;
        if self.syncconfig & 1 << channel == 0 {
            self.active[channel] = code;
        }
    }

    fn trigger(&mut self, data: u16) {
        if data & trigger::SOFT_CLR != 0 {
            self.buffer = core::array::from_fn(|channel| {
                let (lowest_v, _) = range_v(self.range_code(channel));
                if lowest_v < 0.0 { MID_SCALE } else { 0 }
            });
            self.active = self.buffer;
        }
        if data & trigger::ALM_RESET != 0 {
            self.alarms = 0;
        }
        if data & trigger::SOFT_LDAC != 0 {
            self.ldac();
        }
        if data & trigger::SOFT_RESET_MASK == trigger::SOFT_RESET {
            self.reset();
        }
    }

    fn range_code(&self, channel: usize) -> u16 {
        self.dacrange >> (4 * channel) & 0xF
    }
}

/// Indices of the channels whose bits are set.
fn channels(mask: u16) -> impl Iterator<Item = usize> {
    (0..CHANNELS).filter(move |channel| mask & 1 << channel != 0)
}

/// Lowest voltage and span of a range code (SLASEH2A, DACRANGE register); invalid codes give nothing.
fn range_v(code: u16) -> (f64, f64) {
    match code {
        0b0000 => (0.0, 5.0),
        0b1000 => (0.0, 6.0),
        0b0001 => (0.0, 10.0),
        0b1001 => (0.0, 12.0),
        0b0010 => (0.0, 20.0),
        0b1010 => (0.0, 24.0),
        0b0011 => (0.0, 40.0),
        0b0101 => (-5.0, 10.0),
        0b1101 => (-6.0, 12.0),
        0b0110 => (-10.0, 20.0),
        0b1110 => (-12.0, 24.0),
        0b0111 => (-20.0, 40.0),
        _ => (0.0, 0.0),
    }
}

#[cfg(test)]
mod tests;
