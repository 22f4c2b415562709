//! The planner: each refusal by its name, and what it accepts can be stopped.

use firmware::config::Config;
use firmware::path::Motion;
use firmware::planner::{Order, Planner};
use shared::arm::{JOINTS, REFERENCE};
use shared::command::{Command, GainName, Profile, Trajectory};
use shared::fault::Refusal;

use crate::path::{LIFT, origin, path};

/// Codes of the start pose.
fn codes() -> [u32; JOINTS] {
    origin().map(|word| word >> 6)
}

fn plan_at(command: &Command, codes: &[u32; JOINTS]) -> Order {
    let mut order = Order::Arm;
    Planner::new(&Config::default()).plan(command, codes, &mut order);
    order
}

pub fn plan(command: &Command) -> Order {
    plan_at(command, &codes())
}

/// The planned motion, if it starts at the start pose.
pub fn start(trajectory: &Trajectory) -> Result<Motion, Refusal> {
    match plan(&Command::Start(*trajectory)) {
        Order::Start(motion) if motion.starts_at(&origin()) => Ok(motion),
        Order::Start(_) => Err(Refusal::OriginMismatch),
        Order::Refused(refusal) => Err(refusal),
        other => panic!("{other:?} for a trajectory"),
    }
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
fn a_speed_limit_refuses_what_is_faster_than_its_share() {
    let lift = path(Profile::Quintic, 10.0, LIFT);
    // Joint 4 leads: 1.875 · 0.675 m in 10 s are 15.8 % of its 0.8 m/s.
    for (speed_limit_percent, is_refused) in [(0, true), (15, true), (16, false), (255, false)] {
        let found = start(&Trajectory { speed_limit_percent, ..lift });
        assert_eq!(found.err() == Some(Refusal::TooFast), is_refused, "{speed_limit_percent} %");
    }
}

/// 300 kg at full reach: slewing at the speed limit could not be stopped in 150 ms within the reserve.
#[test]
fn a_jog_that_could_not_be_stopped_is_refused() {
    let jog = |pose: [f64; JOINTS], speeds| {
        let codes = std::array::from_fn(|j| {
            let encoder = REFERENCE.encoders[j];
            ((pose[j] - encoder.zero) / encoder.lsb) as u32
        });
        match plan_at(&Command::Jog(speeds), &codes) {
            Order::Jog(line) => Ok(line),
            Order::Refused(refusal) => Err(refusal),
            other => panic!("{other:?} for a jog"),
        }
    };
    const FULL_REACH: [f64; JOINTS] = [0.0, 0.3, 1.3, 5.2];
    const FOLDED: [f64; JOINTS] = [0.0, 1.2, -1.1, 3.0];
    assert_eq!(jog(FULL_REACH, [0.59, 0.0, 0.0, 0.0]), Err(Refusal::NotStoppable));
    assert!(jog(FULL_REACH, [0.1, 0.0, 0.0, 0.0]).is_ok());
    assert!(jog(FOLDED, [0.59, 0.0, 0.0, 0.0]).is_ok());
    for j in 0..JOINTS {
        for (speed, refusal) in [
            (f32::NAN, Refusal::NotFinite),
            (f32::INFINITY, Refusal::NotFinite),
            (0.9, Refusal::TooFast),
        ] {
            let mut speeds = [0.0; JOINTS];
            speeds[j] = speed;
            assert_eq!(jog(FOLDED, speeds), Err(refusal), "joint {j}: {speed}");
        }
    }
}

#[test]
fn gains_are_refused_by_name_range_and_law() {
    let ask = |name, values| match plan(&Command::SetGain { name, values }) {
        Order::SetGains(_) => None,
        Order::Refused(refusal) => Some(refusal),
        other => panic!("{other:?} for a gain"),
    };
    let k1 = GainName::K1 as u8;
    assert_eq!(ask(k1, [150.0; JOINTS]), None);
    assert_eq!(ask(k1, [150.0, 150.0, 150.0, f32::NAN]), Some(Refusal::GainOutOfRange));
    assert_eq!(ask(k1, [150.0, 1_001.0, 150.0, 150.0]), Some(Refusal::GainOutOfRange));
    // A gain without joints uses the first value alone.
    assert_eq!(ask(GainName::Wa as u8, [50.0, f32::NAN, -1.0, 1e9]), None);
    assert_eq!(ask(GainName::Wa as u8, [-1.0, 50.0, 50.0, 50.0]), Some(Refusal::GainOutOfRange));
    assert_eq!(ask(GainName::Kp as u8, [9_000.0; JOINTS]), Some(Refusal::OtherLaw));
    for name in GainName::ALL.len() as u8..=u8::MAX {
        assert_eq!(ask(name, [1.0; JOINTS]), Some(Refusal::UnknownGain), "{name}");
    }
}
