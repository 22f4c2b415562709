//! Where things lie in the memory image, for whoever injects faults there.

use core::mem::{offset_of, size_of};
use core::ops::Range;

use super::{Coefficients, Estimates, Memory};
use crate::JointVector;
use crate::dynamics;
use crate::estimator::Observer;
use crate::law;
use crate::monitor::Thresholds;

/// The bytes of a `T` that begins at `offset`.
const fn stretch<T>(offset: usize) -> Range<usize> {
    offset..offset + size_of::<T>()
}

/// Stretches of the memory image, bytes; each begins and ends with a word.
impl Memory {
    /// Which law runs, and its gains.
    pub const GAINS: Range<usize> =
        stretch::<law::Coefficients>(offset_of!(Self, coefficients.law));
    /// Highest torque commands.
    pub const LIMITS: Range<usize> = stretch::<JointVector>(offset_of!(Self, coefficients.tau_max));
    /// The arm.
    pub const ARM: Range<usize> =
        stretch::<dynamics::Constants>(offset_of!(Self, coefficients.dynamics));
    /// Second copy of gains, limits, scales and arm.
    pub const SHADOW: Range<usize> = stretch::<Coefficients>(offset_of!(Self, shadow));
    /// Limits of the monitors and times of the supervisor.
    pub const THRESHOLDS: Range<usize> = stretch::<Thresholds>(offset_of!(Self, thresholds));
    /// Disturbance estimate.
    pub const D_HAT: Range<usize> = stretch::<JointVector>(offset_of!(Self, estimates.d_hat));

    /// Position word of joint `j`.
    pub const fn position(j: usize) -> Range<usize> {
        stretch::<u32>(observer(j) + offset_of!(Observer, position))
    }

    /// Velocity estimate of joint `j`.
    pub const fn velocity(j: usize) -> Range<usize> {
        stretch::<f32>(observer(j) + offset_of!(Observer, velocity))
    }
}

const fn observer(j: usize) -> usize {
    offset_of!(Memory, estimates) + offset_of!(Estimates, observers) + j * size_of::<Observer>()
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn stretches_hold_what_they_are_named_after() {
        let mut memory = Memory::zeroed();
        let mut poke =
            |stretch: Range<usize>| bytemuck::bytes_of_mut(&mut memory)[stretch].fill(0x55);
        poke(Memory::LIMITS);
        poke(Memory::D_HAT);
        poke(Memory::position(2));
        poke(Memory::velocity(3));
        let word = f32::from_bits(0x5555_5555);
        assert_eq!(memory.coefficients.tau_max, JointVector::repeat(word));
        assert_eq!(memory.estimates.d_hat, JointVector::repeat(word));
        let observers = memory.estimates.observers;
        assert_eq!(observers.map(|o| o.position), [0, 0, 0x5555_5555, 0]);
        assert_eq!(observers.map(|o| o.velocity), [0.0, 0.0, 0.0, word]);
        assert!(!memory.agrees());
    }
}
