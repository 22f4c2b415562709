//! The mocked bus: simulated chips and pins behind the `embedded-hal` traits.
//!
//! One [`Bench`] holds all devices. Handles given to the controller borrow it for the length of one
//! transaction. Within a tick a cursor tells when a read starts, because an encoder latches then.

mod drive;
mod exchange;
mod noise;
mod pins;
mod power;
mod traffic;
mod wiring;

pub use drive::DriveFault;
use noise::Noise;
pub use pins::OutputLevels;
use power::Power;
use shared::arm::{Arm, JOINTS};
pub use traffic::Event;
pub use wiring::{Device, Handle, Input, Output, wire};

use crate::chips::ads131m04::Ads131m04;
use crate::chips::dac81404::Dac81404;
use crate::chips::encoder::Encoder;
use crate::chips::watchdog::EARLY_S;
use crate::faults::Interference;

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

/// All devices on the bus, their pins and the instant within the tick.
pub struct Bench {
    encoders: [Encoder; JOINTS],
    adc: Ads131m04,
    dac: Dac81404,
    power: Power,
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
    /// Faults that may come, if any may.
    interference: Option<Box<Interference>>,
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
            power: Power::new(),
            outputs: OutputLevels::default(),
            brake_open: [false; JOINTS],
            emergency_stop: [true; 2],
            motion: Motion::default(),
            cursor_s: 0.0,
            skew_s,
            interference: None,
            noise: None,
            traffic: None,
        }
    }

    /// Starts a tick with the arm in `motion`.
    pub fn begin_tick(&mut self, motion: Motion) {
        self.motion = motion;
        self.cursor_s = 0.0;
        if let Some(interference) = &mut self.interference {
            interference.begin_tick();
        }
    }

    /// Lets `dt_s` pass with `torque` (as fractions of the transducers' full scale) acting.
    pub fn advance(&mut self, dt_s: f64, torque: [f64; JOINTS]) {
        self.adc.advance(dt_s, torque);
        self.power.advance(dt_s, self.emergency_stop);
    }

    /// What the drives give, as fractions of full scale; 0 where enable or STO is low or the hardware's
    /// safety chain is open.
    pub fn drive_commands(&self) -> [f64; JOINTS] {
        self.power.torque(&self.outputs, self.dac.outputs())
    }

    /// Releases that reach the brakes: none where STO is low or the hardware's safety chain is open.
    pub fn brake_releases(&self) -> [bool; JOINTS] {
        self.power.releases(&self.outputs)
    }

    /// Whether the hardware's safety chain, watchdog and emergency stop relay, lets torque flow.
    pub fn chain_closed(&self) -> bool {
        self.power.chain_closed()
    }

    /// Makes the drive of a joint faulty, or sound again.
    pub fn set_drive_fault(&mut self, joint: usize, fault: DriveFault) {
        self.power.drives[joint] = fault;
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

    /// Lets faults come between the bus and the chips.
    pub fn expect_faults(&mut self, interference: Option<Interference>) {
        self.interference = interference.map(Box::new);
    }

    /// Lets the fault of frames or samples with this number begin or end, if it is one.
    pub fn interfere(&mut self, injection: usize, begins: bool) {
        if let Some(interference) = &mut self.interference {
            interference.set_active(injection, begins);
        }
    }

    /// Lets an encoder's head distrust itself or ask to be cleaned.
    pub fn mark_encoder(&mut self, joint: usize, failed: bool, dirty: bool) {
        let encoder = &mut self.encoders[joint];
        (encoder.failed, encoder.dirty) = (failed, dirty);
    }

    /// The torque converter loses its supply for an instant.
    pub fn reset_adc(&mut self) {
        self.adc.reset();
    }

    /// The DAC loses its supply for an instant.
    pub fn reset_dac(&mut self) {
        self.dac.reset();
    }

    /// Gives the watchdog a falling edge more, unless it would take it for a regular one; says whether it did.
    pub fn kick_watchdog(&mut self) -> bool {
        let watchdog = &mut self.power.watchdog;
        let early = watchdog.since_fall_s() < EARLY_S;
        if early {
            for level in [true, false, self.outputs.watchdog] {
                watchdog.drive(level);
            }
        }
        early
    }
}

/// The converter's crystal against the controller's, a usual 20 ppm part.
const ADC_CLOCK_ERROR_PPM: f64 = 20.0;
