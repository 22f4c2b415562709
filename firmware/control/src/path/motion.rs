//! Joint trajectories q_d = origin + amplitude · s(phase / N).

use core::num::NonZeroU32;

use shared::arm::JOINTS;
use shared::command::Trajectory;

use super::shape::{Shape, Shaped};
use super::{Phase, Rate, SetPoint};
use crate::estimator::FRACTION_BITS;

/// A trajectory under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    trajectory: Trajectory,
    /// Amplitudes in rad and m.
    amplitude: [f32; JOINTS],
    /// How far along it is.
    pub phase: Phase,
    /// 2⁶³ / N: phase · this is x with 63 fractional bits. Low and high word, so that modes align to words.
    phase_step_q63: [u32; 2],
    /// 1 / (N T), 1/s.
    rate: f32,
}

/// A set-point this near to a trajectory's origin is the same, counts: half a count of rounding a side.
const ORIGIN_TOLERANCE: u32 = 2 << FRACTION_BITS;
/// Longest trajectory, ticks: ten minutes at 8 kHz.
pub const DURATION_MAX: NonZeroU32 = NonZeroU32::new(4_800_000).unwrap();

impl Motion {
    /// A motion at its start; `lsb` is one encoder count of each joint, rad and m.
    pub fn new(
        trajectory: &Trajectory,
        ticks: NonZeroU32,
        lsb: [f32; JOINTS],
        tick_hz: f32,
    ) -> Self {
        let mut amplitude = [0.0; JOINTS];
        for ((slot, &span), lsb) in amplitude.iter_mut().zip(&trajectory.amplitude_q5).zip(lsb) {
            *slot = span as f32 * (lsb / 32.0);
        }
        Self {
            trajectory: *trajectory,
            amplitude,
            phase: Phase::default(),
            phase_step_q63: reciprocal_q63(ticks),
            rate: tick_hz / ticks.get() as f32,
        }
    }

    /// Amplitudes, and how many times them the joints' highest speeds are, rad/s and m/s.
    pub fn peak(&self) -> (&[f32; JOINTS], f32) {
        (&self.amplitude, self.trajectory.profile.peak_rate() * self.rate)
    }

    /// Duration, ticks.
    pub fn duration_ticks(&self) -> u32 {
        self.trajectory.duration_ticks
    }

    /// Whether the motion starts at the set-point `from`.
    #[inline(always)]
    pub fn starts_at(&self, from: &[u32; JOINTS]) -> bool {
        self.trajectory.origin_q6.iter().zip(from).all(|(origin, from)| {
            origin.wrapping_sub(*from).wrapping_add(ORIGIN_TOLERANCE) <= 2 * ORIGIN_TOLERANCE
        })
    }

    /// The motion at its start. Field by field: a whole copy would go through a memory routine.
    #[inline(always)]
    pub fn begun(&self) -> Self {
        Self { phase: Phase::default(), ..*self }
    }

    /// The same motion, started from `origin`.
    pub fn moved_to(&self, origin: [u32; JOINTS]) -> Self {
        Self { trajectory: Trajectory { origin_q6: origin, ..self.trajectory }, ..self.begun() }
    }

    /// Whether the end has been reached.
    #[inline(always)]
    pub fn is_over(&self) -> bool {
        self.phase.ticks >= self.trajectory.duration_ticks
    }

    /// The set-point at the present phase; past the end, the end.
    pub fn set_point(&self) -> SetPoint {
        self.set_point_at(self.phase, Rate::FULL)
    }

    /// The set-point at `phase`, passed at `rate`.
    pub fn set_point_at(&self, phase: Phase, rate: Rate) -> SetPoint {
        let mut set_point = SetPoint::default();
        self.place(phase, rate, &mut set_point);
        set_point
    }

    /// Puts the set-point at `phase`, passed at `rate`, where it is wanted.
    #[inline(never)]
    pub fn place(&self, phase: Phase, rate: Rate, to: &mut SetPoint) {
        let shape = self.shape(phase);
        let (ds, dds) = (shape.ds * self.rate, shape.dds * (self.rate * self.rate));
        let velocity = ds * rate.value;
        let acceleration = dds * (rate.value * rate.value) + ds * rate.slope_per_s;
        for j in 0..JOINTS {
            // 5 + 31 fractional bits less 30 leave 6.
            let span = (i64::from(self.trajectory.amplitude_q5[j]) * i64::from(shape.s_q31)) >> 30;
            to.position[j] = self.trajectory.origin_q6[j].wrapping_add(span as u32);
            to.velocity[j] = self.amplitude[j] * velocity;
            to.acceleration[j] = self.amplitude[j] * acceleration;
        }
    }

    fn shape(&self, phase: Phase) -> Shape {
        let profile = self.trajectory.profile;
        if phase == Phase::default() {
            profile.start()
        } else if phase.ticks >= self.trajectory.duration_ticks {
            profile.end()
        } else {
            profile.at(self.progress(phase))
        }
    }

    /// x with 32 fractional bits, before the end; phase < N keeps the products below 2⁶³.
    #[inline(always)]
    fn progress(&self, phase: Phase) -> u32 {
        let [low, high] = self.phase_step_q63.map(u64::from);
        let whole = u64::from(phase.ticks).wrapping_mul(high << 32 | low);
        let rest = u64::from(phase.fraction) * high;
        (whole.wrapping_add(rest) >> 31) as u32
    }
}

/// 2⁶³ / `n` rounded down, for n below 2²⁴: long division by bytes, as there is no 64-bit one in hardware.
fn reciprocal_q63(n: NonZeroU32) -> [u32; 2] {
    const HIGH: u32 = 1 << 31;
    let mut quotient = u64::from(HIGH / n);
    let mut remainder = HIGH % n;
    for _ in 0..4 {
        remainder <<= 8;
        quotient = quotient << 8 | u64::from(remainder / n);
        remainder %= n;
    }
    [quotient as u32, (quotient >> 32) as u32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reciprocal_is_the_quotient() {
        let all = (1..5_000).chain((5_000..=DURATION_MAX.get()).step_by(997));
        for n in all.filter_map(NonZeroU32::new) {
            let [low, high] = reciprocal_q63(n).map(u64::from);
            assert_eq!(high << 32 | low, (1 << 63) / u64::from(n.get()), "{n}");
        }
    }
}
