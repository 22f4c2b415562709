//! Time laws s(x) of trajectories. Positions are computed in integers: an `f32` s(x) would cost half a count of
//! noise.

use core::f32::consts::PI;

use shared::command::Profile;

use crate::math::sin_cos;

/// s, ds/dx and d²s/dx².
#[derive(Clone, Copy)]
pub(crate) struct Shape {
    /// s with 31 fractional bits.
    pub s_q31: i32,
    /// First derivative.
    pub ds: f32,
    /// Second derivative.
    pub dds: f32,
}

pub(crate) trait Shaped {
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
