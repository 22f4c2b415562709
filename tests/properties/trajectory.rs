//! Trajectories: integer set-points against the formula in `f64`, and each refusal by its name.

use std::f64::consts::PI;

use firmware::config::Config;
use firmware::estimator::Observer;
use firmware::mode::{Events, Mode, Timing};
use firmware::trajectory::{Motion, Order, Planner, SetPoint};
use proptest::prelude::*;
use shared::arm::{JOINTS, Q0, REFERENCE};
use shared::command::{Command, Profile, Trajectory};
use shared::fault::{Fault, Refusal};

const TICK_HZ: u32 = 2_000;
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

fn timing() -> Timing {
    Timing::new(TICK_HZ)
}

fn order(trajectory: &Trajectory) -> Order {
    Planner::new(&Config::default()).plan(&Command::Start(*trajectory))
}

/// Position word of the start pose.
fn origin() -> [u32; JOINTS] {
    std::array::from_fn(|j| {
        let encoder = REFERENCE.encoders[j];
        ((Q0[j] - encoder.zero) / encoder.lsb * 64.0).round() as u32
    })
}

/// `amplitude` in rad and m from the start pose.
fn path(profile: Profile, duration_s: f64, amplitude: [f64; JOINTS]) -> Trajectory {
    Trajectory {
        profile,
        allow_velocity_step: profile == Profile::HalfSine,
        duration_ticks: (duration_s * f64::from(TICK_HZ)) as u32,
        origin_q6: origin(),
        amplitude_q5: std::array::from_fn(|j| {
            (amplitude[j] / REFERENCE.encoders[j].lsb * 32.0).round() as i32
        }),
    }
}

fn start(trajectory: &Trajectory) -> Result<Motion, Refusal> {
    match order(trajectory) {
        Order::Start(motion) if motion.starts_at(&origin()) => Ok(motion),
        Order::Start(_) => Err(Refusal::OriginMismatch),
        Order::Refused(refusal) => Err(refusal),
        other => panic!("{other:?} for a trajectory"),
    }
}

/// A healthy arm that is told `order`.
fn told<'a>(order: &'a Order, observers: &'a [Observer; JOINTS]) -> Events<'a> {
    Events { order: Some(order), observers, ready: true, brakes_open: true, fault: Fault::None }
}

/// Every set-point from phase 0 to the end.
fn set_points(trajectory: &Trajectory) -> impl Iterator<Item = (u32, SetPoint)> {
    let mut motion = start(trajectory).expect("an acceptable path");
    (0..=trajectory.duration_ticks).map(move |k| {
        let set_point = motion.set_point();
        assert_eq!(motion.phase, k);
        motion.phase += 1;
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
const LIFT: [f64; JOINTS] = [-0.02473, 0.01236, 0.24726, -0.67503];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    #[test]
    fn positions_and_rates_follow_the_formula(
        profile in prop_oneof![Just(Profile::Quintic), Just(Profile::HalfSine)],
        duration_s in 4.0..20.0f64,
        share in proptest::array::uniform4(-1.0..1.0f64),
    ) {
        let amplitude = std::array::from_fn(|j| share[j] * [0.5, 0.2, 0.5, 0.9][j]);
        let share = match profile {
            Profile::Quintic => QUINTIC_SHARE,
            Profile::HalfSine => SINE_SHARE,
        };
        follows_the_formula(&path(profile, duration_s, amplitude), |span| share * span);
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
    let mut motion = start(&trajectory).expect("an acceptable path");
    for _ in 0..trajectory.duration_ticks {
        assert!(!motion.is_over());
        motion.phase += 1;
    }
    let end = motion.set_point();
    assert!(motion.is_over());
    motion.phase += 1;
    assert_eq!(motion.set_point(), end);
}

#[test]
fn each_refusal_has_its_name() {
    let lift = |duration_s, amplitude| path(Profile::Quintic, duration_s, amplitude);
    let good = lift(10.0, LIFT);
    assert!(start(&good).is_ok());
    let shifted = |by: u32| {
        let mut trajectory = good;
        trajectory.origin_q6[2] = trajectory.origin_q6[2].wrapping_add(by);
        trajectory
    };
    let stepping = Trajectory { allow_velocity_step: false, ..path(Profile::HalfSine, 10.0, LIFT) };
    let bad = [
        ("below the range", lift(10.0, [0.0, 0.0, 0.0, -1.2]), Refusal::OutOfRange),
        ("above the range", lift(10.0, [0.0, 0.3, 0.0, 0.0]), Refusal::OutOfRange),
        ("quintic too fast", lift(1.5, LIFT), Refusal::TooFast),
        ("half sine too fast", path(Profile::HalfSine, 2.6, LIFT), Refusal::TooFast),
        ("velocity step", stepping, Refusal::VelocityStep),
        ("origin above", shifted(129), Refusal::OriginMismatch),
        ("origin below", shifted(129u32.wrapping_neg()), Refusal::OriginMismatch),
        ("origin half a turn away", shifted(1 << 31), Refusal::OutOfRange),
        ("no duration", Trajectory { duration_ticks: 0, ..good }, Refusal::BadDuration),
        ("endless", Trajectory { duration_ticks: 4_800_001, ..good }, Refusal::BadDuration),
        ("endless", Trajectory { duration_ticks: u32::MAX, ..good }, Refusal::BadDuration),
    ];
    for (what, trajectory, refusal) in bad {
        assert_eq!(start(&trajectory).err(), Some(refusal), "{what}");
    }
    let fine = [
        shifted(128),
        lift(1.65, LIFT),
        lift(10.0, [0.0, 0.27, 0.0, -1.19]),
        path(Profile::HalfSine, 2.7, LIFT),
        Trajectory { duration_ticks: 4_800_000, ..good },
    ];
    for trajectory in fine {
        assert!(start(&trajectory).is_ok(), "{trajectory:?}");
    }
}

#[test]
fn every_bit_pattern_is_refused_or_stays_in_range() {
    let extreme = [i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX];
    for amplitude in extreme {
        for joint in 0..JOINTS {
            let mut trajectory = path(Profile::Quintic, 10.0, [0.0; JOINTS]);
            trajectory.amplitude_q5[joint] = amplitude;
            let refused = amplitude.unsigned_abs() > 1;
            assert_eq!(start(&trajectory).is_err(), refused, "joint {joint}: {amplitude}");
        }
    }
}

#[test]
fn a_second_trajectory_is_busy_and_the_first_goes_on() {
    let timing = timing();
    let order = order(&path(Profile::Quintic, 10.0, LIFT));
    let observers = [Observer::default(); JOINTS];
    let events = told(&order, &observers);
    let mut mode = Mode::Holding { pose: origin() };
    assert_eq!((mode.step(&timing, &events), mode.phase()), (Refusal::None, 0));
    let mut quiet = mode;
    assert_eq!((mode.step(&timing, &events), mode.phase()), (Refusal::Busy, 1));
    quiet.step(&timing, &Events { order: None, ..events });
    assert_eq!(mode, quiet);
}

#[test]
fn a_refused_trajectory_leaves_the_pose_held() {
    let order = order(&path(Profile::Quintic, 1.0, LIFT));
    let observers = [Observer::default(); JOINTS];
    let holding = Mode::Holding { pose: origin() };
    let mut mode = holding;
    assert_eq!(mode.step(&timing(), &told(&order, &observers)), Refusal::TooFast);
    assert_eq!(mode, holding);
}
