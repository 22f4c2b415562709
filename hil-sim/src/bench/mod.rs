//! The mocked bus: simulated chips and pins behind the `embedded-hal` traits.
//!
//! One [`Bench`] holds all devices. Handles given to the controller borrow it for the length of one
//! transaction. Within a tick a cursor tells when a read starts, because an encoder latches then.

mod noise;
mod traffic;
mod wiring;

use noise::Noise;
use shared::arm::{Arm, JOINTS};
use shared::wire::biss_c::LATCH_DELAY_S;
pub use traffic::Event;
pub use wiring::{Device, Handle, Input, Output, wire};

use crate::chips::ads131m04::Ads131m04;
use crate::chips::dac81404::Dac81404;
use crate::chips::encoder::Encoder;

/// True motion at a tick instant, for what is latched shortly after it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// Position, rad and m.
    pub q: [f64; JOINTS],
    /// Speed, rad/s and m/s.
    pub qd: [f64; JOINTS],
    /// Acceleration, rad/s² and m/s².
    pub qdd: [f64; JOINTS],
}

/// Levels on the controller's output pins; everything is low from reset to the first tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutputLevels {
    /// DAC update.
    pub ldac: bool,
    /// Drive enables.
    pub drive_enable: [bool; JOINTS],
    /// Safe torque off, low is off.
    pub sto: bool,
    /// Brake releases.
    pub brake_release: [bool; JOINTS],
    /// DAC reset, low resets.
    pub dac_reset: bool,
    /// ADC reset, low resets.
    pub adc_reset: bool,
    /// Watchdog feed.
    pub watchdog: bool,
}

/// All devices on the bus, their pins and the instant within the tick.
pub struct Bench {
    encoders: [Encoder; JOINTS],
    adc: Ads131m04,
    dac: Dac81404,
    /// Levels that the controller drives.
    pub outputs: OutputLevels,
    /// Brake feedback contacts, high is open.
    pub brake_open: [bool; JOINTS],
    /// Emergency stop contacts, high is healthy.
    pub emergency_stop: [bool; 2],
    motion: Motion,
    /// Time since the tick instant, s.
    cursor_s: f64,
    /// Between the starts of two encoder reads, s.
    skew_s: f64,
    /// Flips bits, once the bus is to be noisy.
    noise: Option<Noise>,
    /// What crossed bus and pins since it was last taken, if it is kept.
    traffic: Option<Vec<Event>>,
}

impl Bench {
    /// Chips fitted to `arm`, just powered up.
    ///
    /// # Panics
    /// If no encoder of the arm's width exists; scenarios are refused before that.
    pub fn new(arm: &Arm, skew_s: f64, seed: u64) -> Self {
        Self {
            encoders: arm.encoders.map(|e| Encoder::new(e).expect("a width that a head has")),
            adc: Ads131m04::new(seed, ADC_CLOCK_ERROR_PPM),
            dac: Dac81404::default(),
            outputs: OutputLevels::default(),
            brake_open: [false; JOINTS],
            emergency_stop: [true; 2],
            motion: Motion::default(),
            cursor_s: 0.0,
            skew_s,
            noise: None,
            traffic: None,
        }
    }

    /// Starts a tick with the arm in `motion`.
    pub fn begin_tick(&mut self, motion: Motion) {
        self.motion = motion;
        self.cursor_s = 0.0;
    }

    /// Lets `dt_s` pass with `torque` (as fractions of the transducers' full scale) acting.
    pub fn advance(&mut self, dt_s: f64, torque: [f64; JOINTS]) {
        self.adc.advance(dt_s, torque);
    }

    /// What the drives are told, as fractions of full scale; 0 where enable or STO is low.
    pub fn drive_commands(&self) -> [f64; JOINTS] {
        let outputs = self.dac.outputs();
        std::array::from_fn(|j| {
            let enabled = self.outputs.sto && self.outputs.drive_enable[j];
            if enabled { outputs[j] } else { 0.0 }
        })
    }

    /// Flips one bit in this share of the answers from now on.
    pub fn make_noisy(&mut self, error_share: f64, seed: u64) {
        self.noise = Some(Noise::new(error_share, seed));
    }

    /// Keeps a copy of everything that crosses bus and pins from now on.
    pub fn keep_traffic(&mut self) {
        self.traffic = Some(Vec::new());
    }

    /// What has crossed since the last call.
    pub fn take_traffic(&mut self) -> Vec<Event> {
        self.traffic.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// Conversions of the torque converter so far, as a counter of its data-ready pulses holds them.
    pub fn conversions(&self) -> u32 {
        self.adc.conversions()
    }

    /// Input pins as one bit each: brake feedbacks in bits 0 to 3, emergency stop contacts in 4 and 5.
    pub fn input_levels(&self) -> u8 {
        let pins = self.brake_open.iter().chain(&self.emergency_stop);
        pins.enumerate().map(|(bit, &high)| u8::from(high) << bit).sum()
    }

    /// One chip-select frame.
    pub fn transfer(&mut self, device: Device, mosi: &[u8], miso: &mut [u8]) {
        self.transfer_cleanly(device, mosi, miso);
        if let Some(noise) = &mut self.noise {
            noise.disturb(miso);
        }
        if let Some(traffic) = &mut self.traffic {
            traffic.push(Event::Transfer { device, mosi: mosi.to_vec(), miso: miso.to_vec() });
        }
    }

    fn transfer_cleanly(&mut self, device: Device, mosi: &[u8], miso: &mut [u8]) {
        match device {
            Device::Encoder(j) => {
                let Motion { q, qd, qdd } = &self.motion;
                let t = self.cursor_s + LATCH_DELAY_S;
                self.encoders[j].transfer(q[j] + t * (qd[j] + 0.5 * t * qdd[j]), miso);
                self.cursor_s += self.skew_s;
            }
            Device::Adc => self.adc.transfer(mosi, miso),
            Device::Dac => self.dac.transfer(mosi, miso),
        }
    }

    /// Drives an output pin.
    pub fn set(&mut self, pin: Output, high: bool) {
        if let Some(traffic) = &mut self.traffic {
            traffic.push(Event::Pin { pin, high });
        }
        let o = &mut self.outputs;
        match pin {
            Output::Ldac => {
                if o.ldac && !high {
                    self.dac.ldac();
                }
                o.ldac = high;
            }
            Output::DriveEnable(j) => o.drive_enable[j] = high,
            Output::Sto => o.sto = high,
            Output::BrakeRelease(j) => o.brake_release[j] = high,
            Output::DacReset => {
                o.dac_reset = high;
                if !high {
                    self.dac.reset();
                }
            }
            Output::AdcReset => {
                o.adc_reset = high;
                self.adc.set_reset_pin(high);
            }
            Output::Watchdog => o.watchdog = high,
        }
    }

    fn get(&self, pin: Input) -> bool {
        match pin {
            Input::BrakeOpen(j) => self.brake_open[j],
            Input::EmergencyStop(contact) => self.emergency_stop[contact],
        }
    }
}

/// The converter's crystal against the controller's, a usual 20 ppm part.
const ADC_CLOCK_ERROR_PPM: f64 = 20.0;
