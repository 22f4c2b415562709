//! The controller's connections: six SPI devices, its output pins and its input pins.

use embedded_hal::digital::{InputPin, OutputPin, PinState};
use shared::arm::JOINTS;

/// Output pins. Pull resistors hold all but LDAC low, which is off, from reset to the first tick; LDAC
/// may rest at either level.
#[derive(Debug)]
pub struct Outputs<O> {
    /// Updates the DAC's outputs on its falling edge.
    pub ldac: O,
    /// Drive enables, high is on.
    pub drive_enable: [O; JOINTS],
    /// Common safe torque off, low is off.
    pub sto: O,
    /// Brake releases, high opens.
    pub brake_release: [O; JOINTS],
    /// DAC reset, low resets.
    pub dac_reset: O,
    /// ADC synchronisation and reset, low resets.
    pub adc_reset: O,
    /// Feed of the external watchdog, toggled every tick.
    pub watchdog: O,
}

/// Input pins.
#[derive(Debug)]
pub struct Inputs<I> {
    /// Brake feedback, high is open.
    pub brake_open: [I; JOINTS],
    /// Both contacts of the emergency stop, high is healthy.
    pub emergency_stop: [I; 2],
}

/// Everything the controller is wired to.
#[derive(Debug)]
pub struct Io<S, O, I> {
    /// One BiSS-C encoder a joint.
    pub encoders: [S; JOINTS],
    /// ADS131M04 with the torque transducers.
    pub adc: S,
    /// DAC81404 with the torque drives.
    pub dac: S,
    /// Output pins.
    pub outputs: Outputs<O>,
    /// Input pins.
    pub inputs: Inputs<I>,
}

/// Levels of the pins that decide about motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Levels {
    /// Torque may flow: drive enables and STO.
    pub torque: bool,
    /// Brakes are told to open.
    pub release: bool,
    /// DAC and ADC are out of reset.
    pub converters: bool,
}

impl Levels {
    /// Torque off, brakes set.
    pub const OFF: Self = Self { torque: false, release: false, converters: true };
    /// As [`Self::OFF`], converters in reset.
    pub const RESET: Self = Self { torque: false, release: false, converters: false };
}

impl<O: OutputPin> Outputs<O> {
    /// Drives every pin but LDAC; `false` if one could not be driven.
    pub fn drive(&mut self, levels: Levels, watchdog: bool) -> bool {
        let torque = PinState::from(levels.torque);
        let release = PinState::from(levels.release);
        let converters = PinState::from(levels.converters);
        let mut driven = true;
        for pin in &mut self.drive_enable {
            driven &= pin.set_state(torque).is_ok();
        }
        for pin in &mut self.brake_release {
            driven &= pin.set_state(release).is_ok();
        }
        driven &= self.sto.set_state(torque).is_ok();
        driven &= self.dac_reset.set_state(converters).is_ok();
        driven &= self.adc_reset.set_state(converters).is_ok();
        driven & self.watchdog.set_state(PinState::from(watchdog)).is_ok()
    }

    /// Returns LDAC to its resting level without an edge that updates.
    pub fn rest_ldac(&mut self) -> bool {
        self.ldac.set_high().is_ok()
    }

    /// Pulses LDAC: the DAC's outputs take what was written last.
    pub fn pulse_ldac(&mut self) -> bool {
        self.ldac.set_low().is_ok() & self.ldac.set_high().is_ok()
    }
}

impl<I: InputPin> Inputs<I> {
    /// Whether all four brakes report open; a pin that cannot be read counts as closed.
    pub fn brakes_open(&mut self) -> bool {
        self.brake_open.iter_mut().all(|pin| pin.is_high().unwrap_or(false))
    }

    /// Whether both contacts are healthy; a pin that cannot be read counts as pressed.
    pub fn emergency_stop_healthy(&mut self) -> bool {
        self.emergency_stop.iter_mut().all(|pin| pin.is_high().unwrap_or(false))
    }
}
