//! Deliberate defects, at most one an image: tests build them in with `--cfg defect="…"` to see each found.

use core::hint::black_box;

use firmware::config::Config;
use firmware::executive::Retained;

use crate::Controller;

/// Tick whose sample of joint 2 the defect `spoiled_sample` spoils.
#[cfg(defect = "spoiled_sample")]
const SPOILED_TICK: u32 = 2_000;

/// A panic that the compiler cannot exclude.
#[inline(always)]
pub fn before_configuration(config: &Config) {
    if cfg!(defect = "reachable_panic") {
        assert!(config.tick_hz != 0);
    }
}

/// A gain one ulp off that the harness sees as a coefficient.
#[inline(always)]
pub fn in_coefficients(config: &mut Config, crc: u32) -> u32 {
    if cfg!(defect = "coefficient_one_ulp_off") {
        one_ulp_up(config);
        return config.crc();
    }
    crc
}

/// The same, but behind the harness's back: only what the law computes gives it away.
#[inline(always)]
pub fn in_law(controller: &mut Controller, config: &mut Config, retained: &Retained) {
    if cfg!(defect = "law_one_ulp_off") {
        one_ulp_up(config);
        let _ = controller.configure(config, config.crc(), retained);
    }
}

fn one_ulp_up(config: &mut Config) {
    let [k1, ..] = &mut config.gains.k1;
    *k1 = f32::from_bits(k1.to_bits() + 1);
}

/// Recursion that no stack is large enough for.
#[inline(always)]
pub fn in_idle() {
    if cfg!(defect = "stack_overflow") {
        deeper(0);
    }
}

#[inline(never)]
fn deeper(depth: u32) -> u32 {
    if black_box(depth) == u32::MAX { 0 } else { black_box(deeper(depth + 1)) + depth }
}

/// Double precision and a square root in software.
#[inline(always)]
#[expect(clippy::disallowed_methods, reason = "the defect")]
pub fn in_tick() {
    if cfg!(defect = "soft_float") {
        black_box(black_box(2.0_f64) * f64::from(libm::sqrtf(black_box(2.0))));
    }
}

/// A bit of an encoder's answer.
#[inline(always)]
pub fn in_sample(_device: u8, _bytes: &mut [u8]) {
    #[cfg(defect = "spoiled_sample")]
    {
        use core::sync::atomic::{AtomicU32, Ordering};
        static TICK: AtomicU32 = AtomicU32::new(0);
        if _device == 1 && TICK.fetch_add(1, Ordering::Relaxed) == SPOILED_TICK {
            if let Some(byte) = _bytes.get_mut(3) {
                *byte ^= 1;
            }
        }
    }
}
