//! Configuration: plain physical values, refused by name before they become coefficients.

mod arm;
mod check;
mod fields;
mod gains;
mod joint;
mod safety;

use bytemuck::{Pod, Zeroable};
use shared::arm::{Arm, JOINTS, REFERENCE};
use shared::crc32::crc32;

pub use arm::{ArmModel, Body, Geometry};
use check::Check;
pub use check::ConfigError;
pub use fields::Field;
pub use gains::{Gains, Law};
pub use joint::Joint;
use joint::joint;
pub use safety::Safety;

/// Everything that a board's owner may set: 32-bit words without padding, so that it can be sent, kept and
/// checked as bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Config {
    /// Ticks a second.
    pub tick_hz: u32,
    /// The arm.
    pub arm: ArmModel,
    /// Its joints.
    pub joints: [Joint; JOINTS],
    /// Gains.
    pub gains: Gains,
    /// When the arm is stopped and how.
    pub safety: Safety,
}

/// Lowest tick rate: through the whole chain 500 Hz ends in a limit cycle.
pub const TICK_HZ_MIN: u32 = 1_000;
/// Highest tick rate that wire time leaves room for.
pub const TICK_HZ_MAX: u32 = 8_000;

impl Config {
    /// Defaults for `arm` at `tick_hz`: the inertia-weighted law with the paper's K1 and K2.
    pub const fn for_arm(arm: &Arm, tick_hz: u32) -> Self {
        Self {
            tick_hz,
            arm: ArmModel::new(arm, 1.0, 0.0),
            joints: [joint(arm, 0), joint(arm, 1), joint(arm, 2), joint(arm, 3)],
            gains: Gains::DEFAULT,
            safety: Safety::REFERENCE,
        }
    }

    /// The check sum to be kept with the configuration.
    pub fn crc(&self) -> u32 {
        crc32(bytemuck::bytes_of(self))
    }

    /// Whether these are the bytes that `crc` was made of.
    ///
    /// # Errors
    /// [`ConfigError::Damaged`] if they are not.
    pub fn check(&self, crc: u32) -> Result<(), ConfigError> {
        if self.crc() == crc { Ok(()) } else { Err(ConfigError::Damaged) }
    }

    /// Checks every value by name: finite, sign and range.
    ///
    /// # Errors
    /// The first value that is out of range, with its range.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let tick_hz = self.tick_hz as f32;
        let mut check = Check::new(tick_hz);
        check.group(const { Field::named("tick_hz") }, 0, &[self.tick_hz]);
        self.arm.validate(&mut check);
        for (j, joint) in self.joints.iter().enumerate() {
            joint.validate(&mut check, j, tick_hz);
        }
        self.gains.validate(&mut check);
        self.safety.validate(&mut check);
        check.found
    }
}

impl Default for Config {
    /// The reference arm at 2 kHz.
    fn default() -> Self {
        const { Self::for_arm(&REFERENCE, 2_000) }
    }
}
