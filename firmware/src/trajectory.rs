//! Joint trajectories q_d = origin + amplitude · s(k / N), phase kept as an integer tick k.
//!
//! Positions are computed in integers: an `f32` s(x) would cost half a count of noise.

use bytemuck::{Pod, Zeroable};
use core::f32::consts::PI;
use core::num::NonZeroU32;

use shared::arm::JOINTS;
use shared::command::{Command, Profile, Trajectory};
use shared::fault::Refusal;

use crate::config::{Config, Joint};
use crate::estimator::FRACTION_BITS;
use crate::math::sin_cos;

/// Set-point of one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SetPoint {
    /// Desired position words.
    pub position: [u32; JOINTS],
    /// Desired velocity, rad/s and m/s.
    pub velocity: [f32; JOINTS],
    /// Desired acceleration, rad/s² and m/s².
    pub acceleration: [f32; JOINTS],
}

impl SetPoint {
    /// Standing still at `position`.
    pub fn hold(position: [u32; JOINTS]) -> Self {
        Self { position, ..Self::default() }
    }
}

/// What the generator needs of one joint.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Range {
    min_code: i32,
    max_code: i32,
    /// One count, rad or m.
    lsb: f32,
    qd_max: f32,
}

impl Range {
    /// Limits of `joint` in counts.
    pub fn new(joint: &Joint) -> Self {
        let code = |q: f32| ((q - joint.encoder_zero) / joint.encoder_lsb) as i32;
        Self {
            min_code: code(joint.q_min),
            max_code: code(joint.q_max),
            lsb: joint.encoder_lsb,
            qd_max: joint.qd_max,
        }
    }
}

/// A trajectory under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    trajectory: Trajectory,
    /// Amplitudes in rad and m.
    amplitude: [f32; JOINTS],
    /// Ticks since the start.
    pub phase: u32,
    /// 2⁶³ / N: phase · this is x with 63 fractional bits.
    phase_step_q63: u64,
    /// 1 / (N T), 1/s.
    rate: f32,
}

/// A set-point this near to a trajectory's origin is the same, counts: half a count of rounding a side.
const ORIGIN_TOLERANCE: u32 = 2 << FRACTION_BITS;
/// Longest trajectory, ticks: ten minutes at 8 kHz.
const DURATION_MAX: NonZeroU32 = NonZeroU32::new(4_800_000).unwrap();

/// Turns commands into orders outside the tick, so that the tick only has to check where they start.
#[derive(Clone, Copy, Debug)]
pub struct Planner {
    ranges: [Range; JOINTS],
    tick_hz: f32,
}

/// A command as the tick takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Preload torque, open the brakes and hold the measured pose.
    Arm,
    /// Follow this motion, if it starts at the set-point.
    Start(Motion),
    /// Set the brakes and switch torque off.
    Stop,
    /// The command cannot be followed from anywhere.
    Refused(Refusal),
}

impl Planner {
    /// For a validated configuration.
    pub fn new(config: &Config) -> Self {
        Self { ranges: config.joints.map(|j| Range::new(&j)), tick_hz: config.tick_hz as f32 }
    }

    /// The order for `command`.
    pub fn plan(&self, command: &Command) -> Order {
        match command {
            Command::Arm => Order::Arm,
            Command::Stop => Order::Stop,
            Command::Start(trajectory) => match self.motion(trajectory) {
                Ok(motion) => Order::Start(motion),
                Err(refusal) => Order::Refused(refusal),
            },
        }
    }

    fn motion(&self, trajectory: &Trajectory) -> Result<Motion, Refusal> {
        let ticks = NonZeroU32::new(trajectory.duration_ticks).ok_or(Refusal::BadDuration)?;
        if ticks > DURATION_MAX {
            return Err(Refusal::BadDuration);
        }
        if trajectory.profile == Profile::HalfSine && !trajectory.allow_velocity_step {
            return Err(Refusal::VelocityStep);
        }
        let rate = self.tick_hz / ticks.get() as f32;
        let mut amplitude = [0.0; JOINTS];
        let paths = trajectory.origin_q6.iter().zip(&trajectory.amplitude_q5);
        for (((&origin, &span), range), slot) in paths.zip(&self.ranges).zip(&mut amplitude) {
            let start = (origin >> FRACTION_BITS) as i32;
            let end = start.saturating_add(span >> 5);
            if [start, end].iter().any(|c| *c < range.min_code || *c > range.max_code) {
                return Err(Refusal::OutOfRange);
            }
            *slot = span as f32 * (range.lsb / 32.0);
            if slot.abs() * rate * trajectory.profile.peak_rate() > range.qd_max {
                return Err(Refusal::TooFast);
            }
        }
        Ok(Motion {
            trajectory: *trajectory,
            amplitude,
            phase: 0,
            phase_step_q63: reciprocal_q63(ticks),
            rate,
        })
    }
}

/// 2⁶³ / `n` rounded down, for n below 2²⁴: long division by bytes, as there is no 64-bit one in hardware.
fn reciprocal_q63(n: NonZeroU32) -> u64 {
    const HIGH: u32 = 1 << 31;
    let mut quotient = u64::from(HIGH / n);
    let mut remainder = HIGH % n;
    for _ in 0..4 {
        remainder <<= 8;
        quotient = quotient << 8 | u64::from(remainder / n);
        remainder %= n;
    }
    quotient
}

impl Motion {
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
        Self { phase: 0, ..*self }
    }

    /// Whether the end has been reached.
    #[inline(always)]
    pub fn is_over(&self) -> bool {
        self.phase >= self.trajectory.duration_ticks
    }

    /// The set-point at the present phase; past the end, the end.
    #[inline(always)]
    pub fn set_point(&self) -> SetPoint {
        let profile = self.trajectory.profile;
        let shape = if self.phase == 0 {
            // The tick that takes the order is the dearest without the formula's cost.
            profile.start()
        } else if self.is_over() {
            profile.end()
        } else {
            // x with 32 fractional bits; phase < N keeps the product below 2⁶³.
            let x_q32 = (u64::from(self.phase).wrapping_mul(self.phase_step_q63) >> 31) as u32;
            profile.at(x_q32)
        };
        let mut set_point = SetPoint::default();
        for j in 0..JOINTS {
            // 5 + 31 fractional bits less 30 leave 6.
            let span = (i64::from(self.trajectory.amplitude_q5[j]) * i64::from(shape.s_q31)) >> 30;
            set_point.position[j] = self.trajectory.origin_q6[j].wrapping_add(span as u32);
            set_point.velocity[j] = self.amplitude[j] * (shape.ds * self.rate);
            set_point.acceleration[j] = self.amplitude[j] * (shape.dds * (self.rate * self.rate));
        }
        set_point
    }
}

/// s, ds/dx and d²s/dx².
#[derive(Clone, Copy)]
struct Shape {
    /// s with 31 fractional bits.
    s_q31: i32,
    ds: f32,
    dds: f32,
}

trait Shaped {
    fn at(self, x_q32: u32) -> Shape;
    fn start(self) -> Shape;
    fn end(self) -> Shape;
    fn peak_rate(self) -> f32;
}

impl Shaped for Profile {
    #[inline(always)]
    fn at(self, x_q32: u32) -> Shape {
        match self {
            Self::Quintic => quintic(x_q32),
            Self::HalfSine => half_sine(x_q32),
        }
    }

    fn start(self) -> Shape {
        let ds = match self {
            Self::Quintic => 0.0,
            Self::HalfSine => PI,
        };
        Shape { s_q31: 0, ds, dds: 0.0 }
    }

    fn end(self) -> Shape {
        let s_q31 = match self {
            Self::Quintic => i32::MAX,
            Self::HalfSine => 0,
        };
        Shape { s_q31, ds: 0.0, dds: 0.0 }
    }

    /// Highest |ds/dx|: 30/16 at x = 1/2, or pi at the ends.
    fn peak_rate(self) -> f32 {
        match self {
            Self::Quintic => 1.875,
            Self::HalfSine => PI,
        }
    }
}

/// 2^-32, the weight of a bit of x.
const X_STEP: f32 = 1.0 / 4_294_967_296.0;

/// s = x³ (10 - 15x + 6x²).
#[inline(always)]
fn quintic(x_q32: u32) -> Shape {
    let high = |a: u32, b: u32| ((u64::from(a) * u64::from(b)) >> 32) as u32;
    let x2 = high(x_q32, x_q32);
    let x3 = high(x2, x_q32);
    // The bracket lies in 1..=10: 28 fractional bits fill a word.
    let bracket_q28 =
        (10u32 << 28).wrapping_sub(high(15 << 28, x_q32)).wrapping_add(high(6 << 28, x2));
    let s_q31 = ((u64::from(x3) * u64::from(bracket_q28)) >> 29) as u32;
    let x = x_q32 as f32 * X_STEP;
    let y = 1.0 - x;
    let xy = x * y;
    Shape {
        s_q31: (if s_q31 > i32::MAX as u32 { i32::MAX as u32 } else { s_q31 }) as i32,
        ds: 30.0 * xy * xy,
        dds: 60.0 * xy * (y - x),
    }
}

/// s = sin(pi x).
#[inline(always)]
fn half_sine(x_q32: u32) -> Shape {
    let (s, c) = sin_cos(x_q32 as f32 * (X_STEP * PI));
    Shape { s_q31: (s * S_ONE) as i32, ds: PI * c, dds: -PI * PI * s }
}

/// 1 with 31 fractional bits; the cast saturates.
const S_ONE: f32 = 2_147_483_648.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reciprocal_is_the_quotient() {
        let all = (1..5_000).chain((5_000..=DURATION_MAX.get()).step_by(997));
        for n in all.filter_map(NonZeroU32::new) {
            assert_eq!(reciprocal_q63(n), (1 << 63) / u64::from(n.get()), "{n}");
        }
    }
}
