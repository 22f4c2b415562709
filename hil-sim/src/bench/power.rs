//! What stands between the controller's pins and the arm: the hardware's safety chain and the drives.

use shared::arm::JOINTS;

use super::OutputLevels;
use super::drive::DriveFault;
use crate::chips::stop_relay::StopRelay;
use crate::chips::watchdog::Watchdog;

/// Safety chain and drives. STO feeds the brake valves too: without it every brake sets.
#[derive(Clone, Debug)]
pub(super) struct Power {
    pub watchdog: Watchdog,
    relay: StopRelay,
    pub drives: [DriveFault; JOINTS],
}

impl Power {
    /// At power-up.
    pub fn new() -> Self {
        Self {
            watchdog: Watchdog::default(),
            relay: StopRelay::default(),
            drives: [DriveFault::NONE; JOINTS],
        }
    }

    /// Lets `dt_s` pass with the emergency stop's contacts as they are.
    pub fn advance(&mut self, dt_s: f64, contacts: [bool; 2]) {
        self.watchdog.advance(dt_s);
        self.relay.advance(dt_s, contacts);
    }

    /// Whether the hardware lets torque flow, whatever the firmware does.
    pub fn chain_closed(&self) -> bool {
        self.watchdog.is_closed() && self.relay.is_closed()
    }

    /// What the drives give, as shares of full scale, where the DAC tells them `codes`.
    pub fn torque(&self, pins: &OutputLevels, codes: [f64; JOINTS]) -> [f64; JOINTS] {
        let supplied = pins.sto && self.chain_closed();
        std::array::from_fn(|j| {
            let enabled = supplied && pins.drive_enable[j];
            if enabled { self.drives[j].output(codes[j]) } else { 0.0 }
        })
    }

    /// Releases that reach the brakes.
    pub fn releases(&self, pins: &OutputLevels) -> [bool; JOINTS] {
        let supplied = pins.sto && self.chain_closed();
        pins.brake_release.map(|told| told && supplied)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ON: OutputLevels = OutputLevels {
        ldac: true,
        drive_enable: [true; 4],
        sto: true,
        brake_release: [true; 4],
        dac_reset: true,
        adc_reset: true,
        watchdog: false,
    };
    const CODES: [f64; JOINTS] = [0.1, 0.2, 0.3, 0.4];

    /// Fed until it lets torque flow.
    fn closed() -> Power {
        let mut power = Power::new();
        for edge in 0..4 {
            power.watchdog.drive(edge % 2 == 0);
            power.advance(2e-3, [true; 2]);
        }
        assert_eq!((power.torque(&ON, CODES), power.releases(&ON)), (CODES, [true; 4]));
        power
    }

    fn is_dead(power: &Power, pins: &OutputLevels) -> bool {
        power.torque(pins, CODES) == [0.0; 4] && power.releases(pins) == [false; 4]
    }

    #[test]
    fn nothing_flows_before_the_watchdog_was_fed() {
        assert!(is_dead(&Power::new(), &ON));
    }

    #[test]
    fn sto_takes_torque_and_brake_supply_whatever_the_other_pins_say() {
        assert!(is_dead(&closed(), &OutputLevels { sto: false, ..ON }));
    }

    #[test]
    fn open_chain_does_what_sto_does() {
        let (mut hung, mut pressed) = (closed(), closed());
        hung.advance(9e-3, [true; 2]);
        for _ in 0..300 {
            pressed.watchdog.drive(true);
            pressed.advance(2e-3, [false, true]);
            pressed.watchdog.drive(false);
            pressed.advance(2e-3, [false, true]);
        }
        assert!(is_dead(&hung, &ON) && is_dead(&pressed, &ON));
        assert!(pressed.watchdog.is_closed());
    }

    #[test]
    fn enable_and_release_pins_count_for_their_joint_alone() {
        let mut pins = ON;
        (pins.drive_enable[1], pins.brake_release[2]) = (false, false);
        let power = closed();
        assert_eq!(power.torque(&pins, CODES), [0.1, 0.0, 0.3, 0.4]);
        assert_eq!(power.releases(&pins), [true, true, false, true]);
    }
}
