//! Arithmetic that gives the same bits on host and target: comparisons instead of `f32::min` and `max`,
//! polynomials instead of a library's sine.

use core::f32::consts::FRAC_2_PI;

/// The smaller of two numbers; `b` where they cannot be ordered.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The larger of two numbers; `b` where they cannot be ordered.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// `x` limited to ±`bound`.
#[inline(always)]
pub fn clamp_symmetric(x: f32, bound: f32) -> f32 {
    max(min(x, bound), -bound)
}

/// 1.5 · 2²³: adding it leaves the nearest integer in the low mantissa bits.
const ROUNDER: f32 = 12_582_912.0;

/// The nearest integer, ties to even. Exact for |x| < 2²²; beyond, some integer.
///
/// A float-to-integer cast costs comparisons for its saturation; this is one addition.
#[inline(always)]
pub fn round_to_i32(x: f32) -> i32 {
    ((x + ROUNDER).to_bits() as i32).wrapping_sub(ROUNDER.to_bits() as i32)
}

/// Upper part of pi/2, 201/128: its product with an integer below 2¹⁶ is exact.
const HALF_PI_HIGH: f32 = 1.570_312_5;
/// pi/2 less its upper part.
const HALF_PI_LOW: f32 = 4.838_268e-4;

/// Sine and cosine of an angle within ±64 rad, within 1.5 ulp of 1.
///
/// Cody-Waite reduction to ±pi/4, then the minimax polynomials of Moshier's Cephes library (`sinf.c`).
#[inline(never)]
pub fn sin_cos(x_rad: f32) -> (f32, f32) {
    let shifted = x_rad * FRAC_2_PI + ROUNDER;
    let quadrant = shifted.to_bits();
    let turns = shifted - ROUNDER;
    let r = (x_rad - turns * HALF_PI_HIGH) - turns * HALF_PI_LOW;
    let r2 = r * r;
    let sine = r + r * r2 * (-1.666_665_5e-1 + r2 * (8.332_161e-3 - r2 * 1.951_529_6e-4));
    let cosine = (1.0 - 0.5 * r2)
        + r2 * r2 * (4.166_664_6e-2 + r2 * (-1.388_731_6e-3 + r2 * 2.443_315_7e-5));
    let (s, c) = if quadrant & 1 == 0 { (sine, cosine) } else { (cosine, sine) };
    let sine_sign = (quadrant & 2) << 30;
    let cosine_sign = (quadrant.wrapping_add(1) & 2) << 30;
    (f32::from_bits(s.to_bits() ^ sine_sign), f32::from_bits(c.to_bits() ^ cosine_sign))
}
