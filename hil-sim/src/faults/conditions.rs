//! Faults that are a state of bench and plant: drives, brakes, contacts, encoder heads.

use shared::arm::{Arm, JOINTS};

use super::{Injection, Kind, Target};
use crate::bench::{Bench, DriveFault};
use crate::plant::{BrakeFault, Plant};

/// All that is wrong at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Conditions {
    drives: [DriveFault; JOINTS],
    brakes: [BrakeFault; JOINTS],
    contacts_closed: [bool; 2],
    /// Error and warning of each encoder.
    marks: [(bool, bool); JOINTS],
}

impl Conditions {
    /// What these injections make of an `arm` that is well.
    pub fn of<'a>(injections: impl Iterator<Item = &'a Injection>, arm: &Arm) -> Self {
        let mut conditions = Self {
            drives: [DriveFault::NONE; JOINTS],
            brakes: [BrakeFault::NONE; JOINTS],
            contacts_closed: [true; 2],
            marks: [(false, false); JOINTS],
        };
        for injection in injections {
            for j in injection.target.joints() {
                conditions.spoil_joint(j, injection, arm);
            }
            conditions.spoil_contacts(injection);
        }
        conditions
    }

    fn spoil_joint(&mut self, j: usize, injection: &Injection, arm: &Arm) {
        let severity = injection.severity;
        let (drive, brake) = (&mut self.drives[j], &mut self.brakes[j]);
        match injection.kind {
            Kind::EnableLost => drive.lost = true,
            Kind::TorqueStuck => drive.stuck = Some(severity),
            Kind::TorqueInverted => drive.inverted = true,
            Kind::TorqueLimit => {
                drive.limit = severity * arm.limits[j].tau_max / arm.drive_full_scale[j];
            }
            Kind::BrakeJammed => {
                brake.jammed = true;
                brake.contact = if severity == 1.0 { Some(true) } else { brake.contact };
            }
            Kind::BrakeSlip => brake.holding = severity,
            Kind::BrakeNoFeedback => brake.contact = Some(severity == 1.0),
            Kind::BrakeStuckOpen => brake.stuck_open = true,
            Kind::ErrorBit => self.marks[j].0 = true,
            Kind::WarningBit => self.marks[j].1 = true,
            _ => {}
        }
    }

    fn spoil_contacts(&mut self, injection: &Injection) {
        match (injection.kind, injection.target) {
            (Kind::EStop, _) => self.contacts_closed = [false; 2],
            (Kind::WireBroken, Target::Contact(c)) => self.contacts_closed[c] = false,
            (Kind::ContactsDiffer, Target::Contact(c)) => self.contacts_closed[1 - c] = false,
            _ => {}
        }
    }

    /// Brings bench and plant to this.
    pub fn apply(&self, bench: &mut Bench, plant: &mut Plant) {
        for j in 0..JOINTS {
            bench.set_drive_fault(j, self.drives[j]);
            plant.set_brake_fault(j, self.brakes[j]);
            let (failed, dirty) = self.marks[j];
            bench.mark_encoder(j, failed, dirty);
        }
        bench.emergency_stop = self.contacts_closed;
    }
}

#[cfg(test)]
mod tests {
    use shared::arm::REFERENCE;

    use super::*;

    fn of(injections: &[(Kind, Target, f64)]) -> Conditions {
        let injections = injections
            .iter()
            .map(|&(kind, target, severity)| Injection {
                severity,
                ..Injection::new(kind, target, 0.0)
            })
            .collect::<Vec<_>>();
        Conditions::of(injections.iter(), &REFERENCE)
    }

    #[test]
    fn faults_of_one_joint_add_up_and_leave_the_others_well() {
        let c = of(&[
            (Kind::TorqueInverted, Target::Joint(1), 0.0),
            (Kind::TorqueLimit, Target::Joint(1), 0.5),
            (Kind::BrakeJammed, Target::Brake(1), 1.0),
            (Kind::BrakeSlip, Target::Brake(1), 0.25),
            (Kind::WarningBit, Target::Encoder(2), 0.0),
        ]);
        // Half of the torque limit is 16 000 of 32 768 codes.
        let drive = DriveFault { inverted: true, limit: 16_000.0 / 32_768.0, ..DriveFault::NONE };
        assert_eq!((c.drives[0], c.drives[1]), (DriveFault::NONE, drive));
        let brake =
            BrakeFault { jammed: true, contact: Some(true), holding: 0.25, ..BrakeFault::NONE };
        assert_eq!((c.brakes[0], c.brakes[1]), (BrakeFault::NONE, brake));
        assert_eq!(c.marks, [(false, false), (false, false), (false, true), (false, false)]);
        assert_eq!(c.contacts_closed, [true; 2]);
    }

    #[test]
    fn contacts_open_as_pressed_broken_or_welded() {
        let contacts = |kind, target| of(&[(kind, target, 0.0)]).contacts_closed;
        assert_eq!(contacts(Kind::EStop, Target::Only), [false, false]);
        assert_eq!(contacts(Kind::WireBroken, Target::Contact(0)), [false, true]);
        assert_eq!(contacts(Kind::ContactsDiffer, Target::Contact(0)), [true, false]);
    }
}
