//! Which law runs, and its gains.

use core::slice;

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;

use super::check::Check;
use super::fields::Field;

/// Control law, as a number: a flipped bit may not make an invalid value of it.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Law(pub u32);

impl Law {
    /// Backstepping with psi = wa² M².
    pub const INERTIA_WEIGHTED: Self = Self(0);
    /// Backstepping with a constant diagonal psi.
    pub const PAPER_PSI: Self = Self(1);
    /// Backstepping without adaptation.
    pub const FIXED_GAIN: Self = Self(2);
    /// Computed-torque PD, Eq 29.
    pub const PD: Self = Self(3);
}

/// Gains of the laws and of the observer.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Gains {
    /// Which law runs.
    pub law: Law,
    /// Diagonal of K1, 1/s (Eq 12).
    pub k1: [f32; JOINTS],
    /// Diagonal of K2, 1/s (Eq 20).
    pub k2: [f32; JOINTS],
    /// Adaptation bandwidth of the inertia-weighted law, rad/s.
    pub wa_rad_s: f32,
    /// Diagonal of psi (Eq 19).
    pub psi: [f32; JOINTS],
    /// Bound of the disturbance estimate (Eq 5), N m and N.
    pub d_max: [f32; JOINTS],
    /// Position gain of the PD, 1/s².
    pub kp: [f32; JOINTS],
    /// Velocity gain of the PD, 1/s.
    pub kd: [f32; JOINTS],
    /// Double pole of the tracking observer, rad/s.
    pub observer_rad_s: f32,
}

impl Gains {
    /// Whether every gain is in its range.
    pub(crate) fn are_valid(&self, tick_hz: f32) -> bool {
        let mut check = Check::new(tick_hz);
        self.validate(&mut check);
        check.found.is_ok()
    }

    /// The inertia-weighted law with the paper's K1 and K2.
    pub const DEFAULT: Self = Self {
        law: Law::INERTIA_WEIGHTED,
        k1: [200.0; JOINTS],
        k2: [200.0; JOINTS],
        wa_rad_s: 100.0,
        // The strongest diagonal that stays quiet at 2 kHz.
        psi: [7.6e10, 4.9e10, 1.85e10, 4.1e8],
        d_max: [6_000.0, 20_000.0, 15_000.0, 6_000.0],
        kp: [9_000.0; JOINTS],
        kd: [80.0; JOINTS],
        observer_rad_s: 2_400.0,
    };

    pub(super) fn validate(&self, check: &mut Check) {
        const FIRST: Field = Field::named("law");
        check.group(FIRST, 0, bytemuck::cast_slice(slice::from_ref(self)));
    }
}
