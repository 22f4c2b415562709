//! Levels of the controller's pins, and what its output pins do.

use shared::arm::JOINTS;

use super::{Bench, Event, Input, Output};

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

impl Bench {
    /// Input pins as one bit each: brake feedbacks in bits 0 to 3, emergency stop contacts in 4 and 5.
    pub fn input_levels(&self) -> u8 {
        let pins = self.brake_open.iter().chain(&self.emergency_stop);
        pins.enumerate().map(|(bit, &high)| u8::from(high) << bit).sum()
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
            Output::Watchdog => {
                o.watchdog = high;
                self.power.watchdog.drive(high);
            }
        }
    }

    /// The controller's processor resets and lets go of its pins: pull resistors take them all low.
    pub fn let_go(&mut self) {
        let joints = 0..JOINTS;
        let of_joints = joints.flat_map(|j| [Output::DriveEnable(j), Output::BrakeRelease(j)]);
        let others =
            [Output::Sto, Output::Ldac, Output::DacReset, Output::AdcReset, Output::Watchdog];
        for pin in others.into_iter().chain(of_joints) {
            self.set(pin, false);
        }
    }

    pub(super) fn get(&self, pin: Input) -> bool {
        match pin {
            Input::BrakeOpen(j) => self.brake_open[j],
            Input::EmergencyStop(contact) => self.emergency_stop[contact],
        }
    }
}
