//! The controller's connections: six SPI devices, its output pins and its input pins.

use control::supervisor::{Brakes, Levels};
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
    /// Feed of the external watchdog, toggled every 2 ms.
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

impl<O: OutputPin> Outputs<O> {
    /// Drives every pin but LDAC and the watchdog's; `false` if one could not be driven.
    #[inline(always)]
    pub fn drive(&mut self, levels: Levels) -> bool {
        // Constant levels cost no bit arithmetic.
        if levels == Levels::LIVE { self.drive_to(Levels::LIVE) } else { self.drive_rare(levels) }
    }

    /// The same where it is rarely wanted.
    #[cold]
    #[inline(never)]
    pub fn drive_rare(&mut self, levels: Levels) -> bool {
        self.drive_to(levels)
    }

    #[inline(always)]
    fn drive_to(&mut self, levels: Levels) -> bool {
        let converters = PinState::from(levels.converters);
        let mut driven = true;
        for (j, pin) in self.drive_enable.iter_mut().enumerate() {
            driven &= pin.set_state(PinState::from(levels.drives >> j & 1 != 0)).is_ok();
        }
        for (j, pin) in self.brake_release.iter_mut().enumerate() {
            driven &= pin.set_state(PinState::from(levels.release >> j & 1 != 0)).is_ok();
        }
        driven &= self.sto.set_state(PinState::from(levels.sto)).is_ok();
        driven &= self.dac_reset.set_state(converters).is_ok();
        driven & self.adc_reset.set_state(converters).is_ok()
    }

    /// Drives the watchdog's pin, each of whose edges feeds it.
    pub fn feed(&mut self, high: bool) -> bool {
        self.watchdog.set_state(PinState::from(high)).is_ok()
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
    /// What the brakes report; a pin that cannot be read says neither.
    #[inline(always)]
    pub fn brakes(&mut self) -> Brakes {
        let mut brakes = Brakes { open: 0, closed: 0 };
        for (j, pin) in self.brake_open.iter_mut().enumerate() {
            if let Ok(open) = pin.is_high() {
                brakes.open |= u8::from(open) << j;
                brakes.closed |= u8::from(!open) << j;
            }
        }
        brakes
    }

    /// Contacts of the emergency stop that are open, one bit each; a pin that cannot be read counts as open.
    #[inline(always)]
    pub fn contacts_open(&mut self) -> u8 {
        let pins = self.emergency_stop.iter_mut().enumerate();
        pins.fold(0, |open, (c, pin)| open | u8::from(!pin.is_high().unwrap_or(false)) << c)
    }
}
