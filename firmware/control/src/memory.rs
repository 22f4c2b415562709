//! Parameters with a shadow copy and check sums, and the estimates: what a flipped bit would turn into motion.
//!
//! The tick compares the coefficients with their shadow word by word before it uses them. Where they differ,
//! a CRC-32 says which copy is right; that takes some ticks, in which the drives keep their torque.
//! The thresholds are compared two words a tick, and summed up over some ticks where they differ.

mod places;
mod trial;

use core::mem::{offset_of, size_of};

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;
use shared::crc32::crc32;

use crate::JointVector;
use crate::config::Config;
use crate::dynamics;
use crate::estimator::{self, Observer};
use crate::law;
use crate::monitor::Thresholds;

pub use trial::{Health, Scrub, Search};

/// Gains, limits and arm parameters as a tick uses them.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Coefficients {
    /// Observers.
    pub observer: estimator::Gains,
    /// Encoders.
    pub scales: [estimator::Scale; JOINTS],
    /// The arm.
    pub dynamics: dynamics::Constants,
    /// Highest torque commands, N m and N.
    pub tau_max: JointVector,
    /// DAC codes per N m and N.
    pub codes_per_torque: JointVector,
    /// The law: the only part that an order changes, and therefore last.
    pub law: law::Coefficients,
}

/// Words that a tick compares at once: enough to keep a loop's own cost small.
const ROW: usize = 6;

/// Codes from DAC mid-scale to full scale.
const DAC_HALF_SCALE: f32 = 32_768.0;

impl Coefficients {
    /// Filled group by group, so that a small stack is enough.
    #[inline(never)]
    fn set(&mut self, config: &Config) {
        let tick_hz = config.tick_hz as f32;
        let gains = &config.gains;
        self.dynamics.collect(&config.arm, &config.arm.payload);
        self.law = law::Coefficients::new(gains, tick_hz);
        self.observer = estimator::Gains::new(gains.observer_rad_s, tick_hz);
        for (j, joint) in config.joints.iter().enumerate() {
            self.scales[j] = estimator::Scale::new(joint, tick_hz);
            self.tau_max[j] = joint.tau_max;
            self.codes_per_torque[j] = DAC_HALF_SCALE / joint.drive_full_scale;
        }
    }

    fn rows(&self) -> &[[u32; ROW]; size_of::<Self>() / 4 / ROW] {
        bytemuck::cast_ref(self)
    }

    /// What no order changes, as bytes.
    fn fixed(&self) -> &[u8] {
        bytemuck::bytes_of(self).get(..offset_of!(Self, law)).unwrap_or_default()
    }
}

/// A law's coefficients with their check sum, computed outside the tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gained {
    /// The coefficients.
    pub law: law::Coefficients,
    crc: u32,
}

impl Gained {
    /// With the check sum of `law`.
    pub fn new(law: &law::Coefficients) -> Self {
        Self { law: *law, crc: crc32(bytemuck::bytes_of(law)) }
    }
}

/// What the controller believes of the arm's state.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Estimates {
    /// Position and speed of each joint.
    pub observers: [Observer; JOINTS],
    /// Disturbance, N m and N.
    pub d_hat: JointVector,
    /// Its words, exclusive-ored.
    parity: u32,
}

impl Estimates {
    /// Whether the disturbance estimate is what was last set.
    #[inline(always)]
    pub fn is_sound(&self) -> bool {
        parity(&self.d_hat) == self.parity
    }

    /// Sets the disturbance estimate.
    #[inline(always)]
    pub fn set_d_hat(&mut self, d_hat: JointVector) {
        self.d_hat = d_hat;
        self.parity = parity(&d_hat);
    }
}

#[inline(always)]
fn parity(d: &JointVector) -> u32 {
    d.x.to_bits() ^ d.y.to_bits() ^ d.z.to_bits() ^ d.w.to_bits()
}

/// See the module's documentation. What a tick uses comes first: loads of floats do not reach far.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Memory {
    /// State of the estimator.
    pub estimates: Estimates,
    /// Compared at every tick.
    pub coefficients: Coefficients,
    shadow: Coefficients,
    /// Compared in turn.
    pub thresholds: Thresholds,
    shadow_thresholds: Thresholds,
    crc_fixed: u32,
    crc_law: u32,
    crc_thresholds: u32,
}

impl Memory {
    /// Takes a configuration.
    #[inline(never)]
    pub fn set(&mut self, config: &Config) {
        self.coefficients.set(config);
        self.thresholds.set(config);
        self.crc_fixed = crc32(self.coefficients.fixed());
        self.crc_law = crc32(bytemuck::bytes_of(&self.coefficients.law));
        self.crc_thresholds = crc32(bytemuck::bytes_of(&self.thresholds));
        self.shadow = self.coefficients;
        self.shadow_thresholds = self.thresholds;
    }

    /// Takes new gains, in both copies.
    pub fn gain(&mut self, gained: &Gained) {
        self.coefficients.law = gained.law;
        self.shadow.law = gained.law;
        self.crc_law = gained.crc;
    }

    /// Whether both copies of the coefficients hold the same words.
    #[inline(never)]
    pub fn agrees(&self) -> bool {
        let rows = self.coefficients.rows().iter().zip(self.shadow.rows());
        let differing = rows.fold(0, |all, (a, b)| {
            let [a0, a1, a2, a3, a4, a5] = *a;
            let [b0, b1, b2, b3, b4, b5] = *b;
            all | (a0 ^ b0) | (a1 ^ b1) | (a2 ^ b2) | (a3 ^ b3) | (a4 ^ b4) | (a5 ^ b5)
        });
        differing == 0
    }

    /// Everything in words, for whoever injects faults.
    pub fn as_words_mut(&mut self) -> &mut [u32] {
        words_mut::<_, { size_of::<Self>() / 4 }>(self)
    }
}

/// All of a value as words.
fn words_mut<T: Pod, const N: usize>(value: &mut T) -> &mut [u32; N] {
    bytemuck::cast_mut(value)
}
