//! The tracking observer on known motions, in encoder counts.

use firmware::config::{Config, Joint};
use firmware::estimator::{FRACTION_BITS, Gains, Observer, Scale};
use proptest::prelude::*;

const TICK_HZ: f32 = 2_000.0;
/// Ticks after which the double pole at 2400 rad/s has decayed far below a count.
const SETTLED: u32 = 60;

/// Joint 1 with its latch this many ticks after the tick instant.
fn joint(latch_ticks: f32) -> Joint {
    Joint { latch_offset_s: latch_ticks / TICK_HZ, ..Config::default().joints[0] }
}

fn gains() -> Gains {
    Gains::new(Config::default().gains.observer_rad_s, TICK_HZ)
}

/// Truth at tick `k`, counts, modulo the position word.
fn code(counts: f64) -> u32 {
    (counts.round() as i64).rem_euclid(1 << 26) as u32
}

/// Observed less true position, counts; positions wrap as the words do.
fn error_counts(observer: &Observer, counts: f64) -> f64 {
    let one = f64::from(1u32 << FRACTION_BITS);
    let truth = (counts * one).round() as i64 as u32;
    f64::from(observer.position.wrapping_sub(truth) as i32) / one
}

/// Speed in counts a tick.
fn speed(observer: &Observer, scale: &Scale, joint: &Joint) -> f64 {
    f64::from(observer.velocity(scale)) / f64::from(joint.encoder_lsb) / f64::from(TICK_HZ)
}

proptest! {
    /// Whole counts a tick carry no rounding: the velocity becomes exact, also across the word's wrap.
    #[test]
    fn constant_velocity_becomes_exact(counts_a_tick in -3000i32..3000, start in 0.0..6.7e7f64) {
        let joint = joint(0.0);
        let (gains, scale) = (gains(), Scale::new(&joint, TICK_HZ));
        let mut observer = Observer::at_rest(code(start));
        let at = |k: u32| start.round() + f64::from(counts_a_tick) * f64::from(k);
        for k in 0..2 * SETTLED {
            observer.update(&gains, &scale, code(at(k)));
            if k >= SETTLED {
                let speed = speed(&observer, &scale, &joint);
                let error = (speed - f64::from(counts_a_tick)).abs();
                prop_assert!(error < 0.01 + 1e-6 * speed.abs(), "tick {k}: {speed}");
                prop_assert!(error_counts(&observer, at(k)).abs() < 0.05, "tick {k}");
            }
        }
    }

    /// A latch after the tick instant shifts nothing: the estimate is that of the tick instant.
    #[test]
    fn latch_offset_is_carried_back(speed in -3000.0..3000.0f64, latch in 0.0f32..0.5) {
        let joint = joint(latch);
        let (gains, scale) = (gains(), Scale::new(&joint, TICK_HZ));
        let mut observer = Observer::at_rest(code(1e7));
        let at = |ticks: f64| 1e7 + speed * ticks;
        for k in 0..2 * SETTLED {
            observer.update(&gains, &scale, code(at(f64::from(k) + f64::from(latch))));
        }
        let error = error_counts(&observer, at(f64::from(2 * SETTLED - 1)));
        prop_assert!(error.abs() < 1.0, "{error} counts");
    }

    /// Steps within the 2²² words that the rounder takes in one.
    #[test]
    fn step_settles_without_much_overshoot(step in 1i32..30_000, up in any::<bool>()) {
        let joint = joint(0.0);
        let (gains, scale) = (gains(), Scale::new(&joint, TICK_HZ));
        let start = 3e7;
        let end = start + f64::from(if up { step } else { -step });
        let mut observer = Observer::at_rest(code(start));
        let mut overshoot: f64 = 0.0;
        for _ in 0..SETTLED {
            observer.update(&gains, &scale, code(end));
            let beyond = error_counts(&observer, end) * (end - start).signum();
            overshoot = overshoot.max(beyond);
        }
        // The continuous observer with a double pole passes a step by exp(-2) of it.
        let allowed = (-2.0f64).exp() * f64::from(step) + 1.0;
        prop_assert!(overshoot <= allowed, "{overshoot} of {step}");
        prop_assert!(error_counts(&observer, end).abs() < 0.05);
        prop_assert!(speed(&observer, &scale, &joint).abs() < 0.05);
    }

    /// The error after a step obeys e(k+2) = 2p e(k+1) - p² e(k) with both poles at p = exp(-omega T).
    #[test]
    fn both_poles_are_where_they_are_asked_for(step in 100i32..30_000, omega in 100.0f32..4_000.0) {
        let joint = joint(0.0);
        let (gains, scale) = (Gains::new(omega, TICK_HZ), Scale::new(&joint, TICK_HZ));
        let p = (-f64::from(omega) / f64::from(TICK_HZ)).exp();
        let end = 3e7 + f64::from(step);
        let mut observer = Observer::at_rest(code(3e7));
        let mut errors = || {
            observer.update(&gains, &scale, code(end));
            error_counts(&observer, end)
        };
        let mut last = [errors(), errors()];
        for k in 2..SETTLED {
            let e = errors();
            let residue = e - 2.0 * p * last[1] + p * p * last[0];
            // Each of the three was rounded to a word, twice a tick.
            prop_assert!(residue.abs() < 0.1 + 1e-5 * f64::from(step), "tick {k}: {residue}");
            last = [last[1], e];
        }
    }

    #[test]
    fn lost_samples_are_extrapolated(counts_a_tick in -3000i32..3000, lost in 1u32..20) {
        let joint = joint(0.0);
        let (gains, scale) = (gains(), Scale::new(&joint, TICK_HZ));
        let mut observer = Observer::at_rest(code(2e7));
        let at = |k: u32| 2e7 + f64::from(counts_a_tick) * f64::from(k);
        for k in 0..SETTLED {
            observer.update(&gains, &scale, code(at(k)));
        }
        for k in SETTLED..SETTLED + lost {
            observer.coast(1.0, 0.0);
            let error = error_counts(&observer, at(k));
            prop_assert!(error.abs() < 0.25, "{error} counts after {} lost", k - SETTLED + 1);
        }
        prop_assert!((speed(&observer, &scale, &joint) - f64::from(counts_a_tick)).abs() < 0.02);
    }

    /// Without samples the model's acceleration goes on: speed by `a` a tick, position by its sum.
    #[test]
    fn the_models_acceleration_bridges_lost_samples(
        counts_a_tick in -3000i32..3000, a_q6 in -64i32..64, lost in 1u32..100,
    ) {
        let start = 2e7;
        let mut observer = Observer::at_rest(code(start));
        observer.velocity = (counts_a_tick * 64) as f32;
        for _ in 0..lost {
            observer.coast(1.0, a_q6 as f32);
        }
        let (n, a) = (f64::from(lost), f64::from(a_q6) / 64.0);
        let end = start + n * f64::from(counts_a_tick) + a * n * (n + 1.0) / 2.0;
        prop_assert!(error_counts(&observer, end).abs() < 0.02);
        prop_assert_eq!(observer.velocity, (counts_a_tick * 64 + a_q6 * lost as i32) as f32);
    }
}
