//! Paths: integer set-points against the formula in `f64`.

use std::f64::consts::PI;
use std::num::NonZeroU32;

use firmware::path::{Motion, Phase, Rate, SetPoint};
use proptest::prelude::*;
use shared::arm::{JOINTS, Q0, REFERENCE};
use shared::command::{Profile, Trajectory};

pub const TICK_HZ: u32 = 2_000;
/// Fractional bits of 1/64 count: the integer arithmetic rounds down by up to one.
const WORD: f64 = 1.0 / 64.0;
/// Counts that the paper's lift may be off.
const LIFT_COUNTS: f64 = 0.05;
/// Part of the amplitude that the quintic may be off, in 2^-32: at the end, where it is most, x³ is cut by 2,
/// the bracket by 16 and by 6 times what x² is cut, and s by 2.
const QUINTIC_SHARE: f64 = 26.0 / 4_294_967_296.0;
/// Part of the amplitude that the half sine may be off: three roundings of an angle up to pi in `f32`, and
/// 1.5 ulp of a sine below 1.
const SINE_SHARE: f64 = 3.0 * PI / 16_777_216.0 + 9e-8;

/// Position word of the start pose.
pub fn origin() -> [u32; JOINTS] {
    std::array::from_fn(|j| {
        let encoder = REFERENCE.encoders[j];
        ((Q0[j] - encoder.zero) / encoder.lsb * 64.0).round() as u32
    })
}

/// `amplitude` in rad and m from the start pose.
pub fn path(profile: Profile, duration_s: f64, amplitude: [f64; JOINTS]) -> Trajectory {
    Trajectory {
        profile,
        allow_velocity_step: profile == Profile::HalfSine,
        speed_limit_percent: 100,
        duration_ticks: (duration_s * f64::from(TICK_HZ)) as u32,
        origin_q6: origin(),
        amplitude_q5: std::array::from_fn(|j| {
            (amplitude[j] / REFERENCE.encoders[j].lsb * 32.0).round() as i32
        }),
    }
}

/// The motion along `trajectory`, whatever a planner would say of it.
pub fn motion(trajectory: &Trajectory) -> Motion {
    let ticks = NonZeroU32::new(trajectory.duration_ticks).expect("a duration");
    let lsb = REFERENCE.encoders.map(|encoder| encoder.lsb as f32);
    Motion::new(trajectory, ticks, lsb, TICK_HZ as f32)
}

/// Every set-point from phase 0 to the end.
fn set_points(trajectory: &Trajectory) -> impl Iterator<Item = (u32, SetPoint)> {
    let mut motion = motion(trajectory);
    (0..=trajectory.duration_ticks).map(move |k| {
        let set_point = motion.set_point();
        assert_eq!(motion.phase, Phase { ticks: k, fraction: 0 });
        motion.phase.ticks += 1;
        (k, set_point)
    })
}

/// s, ds/dx and d²s/dx².
fn shape(profile: Profile, x: f64) -> [f64; 3] {
    match profile {
        Profile::Quintic => [
            x * x * x * (10.0 - 15.0 * x + 6.0 * x * x),
            30.0 * x * x - 60.0 * x * x * x + 30.0 * x * x * x * x,
            60.0 * x - 180.0 * x * x + 120.0 * x * x * x,
        ],
        Profile::HalfSine => [(PI * x).sin(), PI * (PI * x).cos(), -PI * PI * (PI * x).sin()],
    }
}

/// Compares a whole path with the formula; positions may be off by `allowed` counts for a span in counts.
fn follows_the_formula(trajectory: &Trajectory, allowed: impl Fn(f64) -> f64) {
    let (n, profile) = (trajectory.duration_ticks, trajectory.profile);
    let duration_s = f64::from(n) / f64::from(TICK_HZ);
    let [_, v_peak, a_peak] = match profile {
        Profile::Quintic => [1.0, 1.875, 10.0 / 3f64.sqrt()],
        Profile::HalfSine => [1.0, PI, PI * PI],
    };
    // The end is a rest: there the half sine's speed of arrival is left out.
    for (k, set_point) in set_points(trajectory).filter(|(k, _)| *k < n) {
        let [s, ds, dds] = shape(profile, f64::from(k) / f64::from(n));
        for j in 0..JOINTS {
            let span = f64::from(trajectory.amplitude_q5[j]) / 32.0;
            let moved = set_point.position[j].wrapping_sub(trajectory.origin_q6[j]) as i32;
            let error = f64::from(moved) * WORD - span * s;
            assert!(
                error.abs() <= allowed(span.abs()) + WORD,
                "tick {k}, joint {j}: {error} counts"
            );
            let amplitude = span * REFERENCE.encoders[j].lsb;
            let rates = [
                (set_point.velocity[j], ds, v_peak, duration_s),
                (set_point.acceleration[j], dds, a_peak, duration_s * duration_s),
            ];
            for (got, want, peak, scale) in rates {
                let error = (f64::from(got) * scale - amplitude * want).abs();
                assert!(error <= 1e-6 * peak * amplitude.abs(), "tick {k}, joint {j}: {got}");
            }
        }
    }
}

/// The paper's amplitudes, rad and m.
pub const LIFT: [f64; JOINTS] = [-0.02473, 0.01236, 0.24726, -0.67503];

/// A profile, a duration and amplitudes within the ranges of motion from the start pose.
pub fn paths() -> impl Strategy<Value = Trajectory> {
    let profile = prop_oneof![Just(Profile::Quintic), Just(Profile::HalfSine)];
    let shares = proptest::array::uniform4(-1.0..1.0f64);
    (profile, 4.0..20.0f64, shares).prop_map(|(profile, duration_s, share)| {
        path(profile, duration_s, std::array::from_fn(|j| share[j] * [0.5, 0.2, 0.5, 0.9][j]))
    })
}

/// Part of the amplitude that a position may be off.
fn rounding_share(profile: Profile) -> f64 {
    match profile {
        Profile::Quintic => QUINTIC_SHARE,
        Profile::HalfSine => SINE_SHARE,
    }
}

/// Word steps by which the way between two set-points of `trajectory` may be off for rounding.
pub fn rounding_words(trajectory: &Trajectory, j: usize) -> f64 {
    // Two positions, and a word step that each is cut by.
    let amplitude = f64::from(trajectory.amplitude_q5[j].unsigned_abs()) * 2.0;
    2.0 * (1.0 + rounding_share(trajectory.profile) * amplitude)
}

/// rad/s or m/s as word steps a tick.
pub fn word_steps(rate: f32, j: usize) -> f64 {
    f64::from(rate) / REFERENCE.encoders[j].lsb / (WORD * f64::from(TICK_HZ))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn positions_and_rates_follow_the_formula(
        trajectory in paths(),
    ) {
        let share = rounding_share(trajectory.profile);
        follows_the_formula(&trajectory, |span| share * span);
    }

    /// Between ticks too, where a stop goes: no step larger than the speed allows, and a rate scales velocity
    /// and its square the acceleration.
    #[test]
    fn between_ticks_the_path_is_continuous_and_scales_with_its_rate(
        trajectory in paths(), place in 0.0..0.999f64, fraction in any::<u32>(), value in 0.0f32..1.0,
        slope_per_s in -20.0f32..20.0,
    ) {
        let motion = motion(&trajectory);
        let ticks = (place * f64::from(trajectory.duration_ticks)) as u32;
        let at = |ticks, fraction| motion.set_point_at(Phase { ticks, fraction }, Rate::FULL);
        let (before, here, after) = (at(ticks, 0), at(ticks, fraction), at(ticks + 1, 0));
        let slowed = motion.set_point_at(Phase { ticks, fraction }, Rate { value, slope_per_s });
        for j in 0..JOINTS {
            let way = |a: &SetPoint, b: &SetPoint| b.position[j].wrapping_sub(a.position[j]) as i32;
            let whole = way(&before, &after);
            let part = f64::from(whole) * f64::from(fraction) / 4_294_967_296.0;
            // A tick bends the path by an eighth of its acceleration, well below a count.
            let bend = 0.25 * word_steps(here.acceleration[j].abs(), j) / f64::from(TICK_HZ);
            let off = (f64::from(way(&before, &here)) - part).abs();
            prop_assert!(off <= 2.0 * rounding_words(&trajectory, j) + bend, "joint {j}: {off}");
            prop_assert_eq!(slowed.position[j], here.position[j]);
            let velocity = here.velocity[j] * value;
            prop_assert!((slowed.velocity[j] - velocity).abs() <= 1e-6 * here.velocity[j].abs());
            let acceleration = here.acceleration[j] * value * value + here.velocity[j] * slope_per_s;
            let scale = here.acceleration[j].abs() + here.velocity[j].abs() * slope_per_s.abs();
            prop_assert!((slowed.acceleration[j] - acceleration).abs() <= 1e-5 * scale);
        }
    }
}

#[test]
fn the_papers_lift_follows_the_formula() {
    follows_the_formula(&path(Profile::Quintic, 10.0, LIFT), |_| LIFT_COUNTS);
}

#[test]
fn start_and_end_are_exact_and_at_rest() {
    for amplitude in [LIFT, LIFT.map(|a| -a), [0.0; JOINTS]] {
        let trajectory = path(Profile::Quintic, 10.0, amplitude);
        let first = set_points(&trajectory).next().expect("a first tick").1;
        assert_eq!(first, SetPoint::hold(trajectory.origin_q6));
        let (_, last) = set_points(&trajectory).last().expect("a last tick");
        assert_eq!((last.velocity, last.acceleration), ([0.0; JOINTS], [0.0; JOINTS]));
        for j in 0..JOINTS {
            // The end has twice the weight of the amplitude's fractional bit, less at most one word.
            let end = 2 * trajectory.amplitude_q5[j];
            let moved = last.position[j].wrapping_sub(trajectory.origin_q6[j]) as i32;
            assert!((0..=1).contains(&(end - moved)), "joint {j}: {moved} for {end}");
        }
    }
    let back = path(Profile::HalfSine, 10.0, LIFT);
    let (_, last) = set_points(&back).last().expect("a last tick");
    assert_eq!(last, SetPoint::hold(back.origin_q6));
}

#[test]
fn past_its_end_a_motion_stays_there() {
    let trajectory = path(Profile::Quintic, 1.0, [0.0, 0.0, 0.1, 0.1]);
    let mut motion = motion(&trajectory);
    for _ in 0..trajectory.duration_ticks {
        assert!(!motion.is_over());
        motion.phase.ticks += 1;
    }
    let end = motion.set_point();
    assert!(motion.is_over());
    motion.phase.ticks += 1;
    assert_eq!(motion.set_point(), end);
}
