//! What a fault is injected into, by the name that a scenario file gives it.

use std::fmt;
use std::ops::Range;

use firmware::memory::Memory;
use shared::arm::JOINTS;

use crate::bench::Device;

/// A stretch of the controller's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Number of the law, and its gains.
    Gain,
    /// Highest torque commands.
    Limit,
    /// The arm.
    Arm,
    /// Second copy of gains, limits, scales and arm.
    Shadow,
    /// Limits of the monitors, times of the supervisor.
    Threshold,
}

impl Place {
    /// Its bytes in the memory image.
    pub fn bytes(self) -> Range<usize> {
        match self {
            Self::Gain => Memory::GAINS,
            Self::Limit => Memory::LIMITS,
            Self::Arm => Memory::ARM,
            Self::Shadow => Memory::SHADOW,
            Self::Threshold => Memory::THRESHOLDS,
        }
    }
}

/// What a fault is injected into; joints, brakes and contacts count from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// There is but one place for a fault of this kind.
    Only,
    /// Encoder of a joint.
    Encoder(usize),
    /// All encoders.
    Encoders,
    /// Torque converter.
    Adc,
    /// Torque-drive DAC.
    Dac,
    /// Everything on the bus.
    All,
    /// Drive or torque transducer of a joint.
    Joint(usize),
    /// Those of all joints.
    Joints,
    /// Brake of a joint.
    Brake(usize),
    /// All brakes.
    Brakes,
    /// Contact of the emergency stop.
    Contact(usize),
    /// Stretch of the controller's memory.
    Place(Place),
}

use Target::{Adc, All, Brake, Brakes, Contact, Dac, Encoder, Encoders, Joint, Joints, Only};

/// Kinds of fault with but one place take this target alone.
pub const ONLY: &[Target] = &[Only];
/// One encoder.
pub const ENCODER: &[Target] = &[Encoder(0), Encoder(1), Encoder(2), Encoder(3)];
/// Encoders.
pub const ENCODERS: &[Target] = &[Encoder(0), Encoder(1), Encoder(2), Encoder(3), Encoders];
/// What measures.
pub const SENSORS: &[Target] = &[Encoder(0), Encoder(1), Encoder(2), Encoder(3), Encoders, Adc];
/// What is on the bus.
pub const DEVICES: &[Target] =
    &[Encoder(0), Encoder(1), Encoder(2), Encoder(3), Encoders, Adc, Dac, All];
/// One joint.
pub const ONE_JOINT: &[Target] = &[Joint(0), Joint(1), Joint(2), Joint(3)];
/// Joints.
pub const JOINT: &[Target] = &[Joint(0), Joint(1), Joint(2), Joint(3), Joints];
/// Brakes.
pub const BRAKE: &[Target] = &[Brake(0), Brake(1), Brake(2), Brake(3), Brakes];
/// Contacts of the emergency stop.
pub const CONTACT: &[Target] = &[Contact(0), Contact(1)];
/// Stretches of the controller's memory.
pub const PLACE: &[Target] = &[
    Target::Place(Place::Gain),
    Target::Place(Place::Limit),
    Target::Place(Place::Arm),
    Target::Place(Place::Shadow),
    Target::Place(Place::Threshold),
];

impl Target {
    /// Whether the fault is in this device.
    pub fn hits(self, device: Device) -> bool {
        match (self, device) {
            (All, _) | (Encoders, Device::Encoder(_)) | (Adc, Device::Adc) | (Dac, Device::Dac) => {
                true
            }
            (Encoder(j), Device::Encoder(k)) => j == k,
            _ => false,
        }
    }

    /// Whether the fault is in something of joint `j`.
    pub fn hits_joint(self, j: usize) -> bool {
        match self {
            Encoder(k) | Joint(k) | Brake(k) => j == k,
            Encoders | All | Joints | Brakes => true,
            Only | Adc | Dac | Contact(_) | Self::Place(_) => false,
        }
    }

    /// The joints in which the fault is.
    pub fn joints(self) -> impl Iterator<Item = usize> {
        (0..JOINTS).filter(move |&j| self.hits_joint(j))
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Only => Ok(()),
            Encoder(j) => write!(f, "encoder{}", j + 1),
            Encoders => write!(f, "encoders"),
            Adc => write!(f, "adc"),
            Dac => write!(f, "dac"),
            All => write!(f, "all"),
            Joint(j) => write!(f, "joint{}", j + 1),
            Joints => write!(f, "joints"),
            Brake(j) => write!(f, "brake{}", j + 1),
            Brakes => write!(f, "brakes"),
            Contact(c) => write!(f, "contact{}", c + 1),
            Self::Place(Place::Gain) => write!(f, "gain"),
            Self::Place(Place::Limit) => write!(f, "limit"),
            Self::Place(Place::Arm) => write!(f, "arm"),
            Self::Place(Place::Shadow) => write!(f, "shadow"),
            Self::Place(Place::Threshold) => write!(f, "threshold"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn targets_hit_what_they_name() {
        let hit = |target: Target| {
            let devices = (0..4).map(Device::Encoder).chain([Device::Adc, Device::Dac]);
            devices.map(|device| u8::from(target.hits(device))).collect::<Vec<_>>()
        };
        assert_eq!(hit(Encoder(1)), [0, 1, 0, 0, 0, 0]);
        assert_eq!(hit(Encoders), [1, 1, 1, 1, 0, 0]);
        assert_eq!(hit(Adc), [0, 0, 0, 0, 1, 0]);
        assert_eq!(hit(All), [1; 6]);
        assert_eq!(hit(Joints), [0; 6]);
        assert_eq!(Joint(2).joints().collect::<Vec<_>>(), [2]);
        assert_eq!(Brakes.joints().count(), 4);
        assert_eq!(Contact(0).joints().count(), 0);
    }

    #[test]
    fn places_are_whole_words() {
        for target in PLACE {
            let Target::Place(place) = target else { panic!("{target}") };
            let bytes = place.bytes();
            assert!(bytes.start % 4 == 0 && bytes.end % 4 == 0 && !bytes.is_empty(), "{target}");
        }
    }
}
