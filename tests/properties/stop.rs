//! A stop along the path (SS1): in 150 ms from any rate to rest, without leaving the path, within the torque
//! that the planner keeps for it.

use firmware::config::Config;
use firmware::path::{Motion, Pace, Path, Phase, Ramp, Rate, SetPoint};
use firmware::supervisor::Follower;
use hil_sim::plant::Model;
use proptest::prelude::*;
use shared::arm::{JOINTS, REFERENCE};
use shared::command::{Profile, Trajectory};

use crate::path::{TICK_HZ, path, rounding_words, word_steps};
use crate::planner::start;

/// Ticks of a stop.
const STOP: u32 = 300;
const STOP_S: f32 = 0.15;

fn pace() -> Pace {
    Pace { ticks: STOP as f32, per_tick: 1.0 / STOP as f32, per_s: 1.0 / STOP_S }
}

/// Rates from which a follower turns: rest, full rate, and what lies on the way up from one to the other.
fn rates() -> impl Strategy<Value = Rate> {
    let rising = (0..STOP).prop_map(|tick| Ramp::new(Rate::ZERO, 1.0, &pace()).rate(tick, &pace()));
    prop_oneof![Just(Rate::FULL), Just(Rate::ZERO), rising]
}

proptest! {
    #[test]
    fn a_ramp_starts_at_the_present_rate_and_ends_level(from in rates(), to in 0u32..2) {
        let ramp = Ramp::new(from, to as f32, &pace());
        let first = ramp.rate(0, &pace());
        prop_assert_eq!(first.value, from.value);
        prop_assert!((first.slope_per_s - from.slope_per_s).abs() < 1e-4);
        for tick in [STOP, STOP + 1, u32::MAX] {
            let last = ramp.rate(tick, &pace());
            prop_assert_eq!((last.value, last.slope_per_s), (to as f32, 0.0));
        }
    }

    /// The slope is the rate's derivative and the rate that of the way.
    #[test]
    fn slope_and_way_belong_to_the_rate(from in rates(), to in 0u32..2) {
        let ramp = Ramp::new(from, to as f32, &pace());
        let mut way = 0.0;
        for tick in 0..STOP {
            let [here, next] = [tick, tick + 1].map(|tick| ramp.rate(tick, &pace()));
            let mean = f64::from(here.slope_per_s + next.slope_per_s) / 2.0 / f64::from(TICK_HZ);
            prop_assert!((f64::from(next.value - here.value) - mean).abs() < 1e-5, "tick {tick}");
            way += f64::from(here.value + next.value) / 2.0;
            let advance = f64::from(ramp.advance(tick + 1, &pace()));
            prop_assert!((advance - way).abs() < 2e-3, "tick {tick}: {advance} and {way}");
        }
    }

    /// Whatever the rate at the order, the arm never turns back on the way to rest.
    #[test]
    fn a_stop_never_turns_back(from in rates()) {
        let mut follower = Follower::new(Phase::default(), from, 0, &pace());
        let way = |follower: &Follower| {
            let phase = follower.phase(&pace());
            f64::from(phase.ticks) + f64::from(phase.fraction) / 4_294_967_296.0
        };
        let mut before = 0.0;
        while !follower.is_level(&pace()) {
            let (way, rate) = (way(&follower), follower.rate(&pace()).value);
            prop_assert!(rate >= -1e-4, "a rate of {rate}");
            // The way comes as an `f32` of up to 300.
            prop_assert!(way >= before - 1e-4, "{before} to {way}");
            before = way;
            follower.step();
        }
    }
}

/// Every set-point of a stop begun at `ticks` of `motion`, until some ticks after rest.
fn stop(motion: Motion, ticks: u32) -> impl Iterator<Item = SetPoint> {
    let path = Path::Curve(motion);
    let mut follower = Follower::new(Phase { ticks, fraction: 0 }, Rate::FULL, 0, &pace());
    (0..STOP + 10).map(move |_| {
        let mut set_point = SetPoint::default();
        path.place(follower.phase(&pace()), follower.rate(&pace()), &mut set_point);
        follower.step();
        set_point
    })
}

/// Trajectories near what the speed limits allow: the leading joint's peak at 1 / `slowness` of its own.
fn fast_paths() -> impl Strategy<Value = Trajectory> {
    let profile = prop_oneof![Just(Profile::Quintic), Just(Profile::HalfSine)];
    let shares = proptest::array::uniform4(-1.0..1.0f64);
    (profile, 1.001..4.0f64, shares).prop_map(|(profile, slowness, share)| {
        let amplitude: [f64; JOINTS] =
            std::array::from_fn(|j| share[j] * [2.0, 0.27, 1.8, 1.18][j]);
        let peak = if profile == Profile::Quintic { 1.875 } else { std::f64::consts::PI };
        let needed_s = (0..JOINTS).map(|j| amplitude[j].abs() * peak / REFERENCE.limits[j].qd_max);
        path(profile, slowness * needed_s.fold(0.2, f64::max), amplitude)
    })
}

fn positions(set_point: &SetPoint) -> [f64; JOINTS] {
    std::array::from_fn(|j| {
        let encoder = REFERENCE.encoders[j];
        f64::from(set_point.position[j]) / 64.0 * encoder.lsb + encoder.zero
    })
}

/// Highest share of the torque limits that a stop begun at `ticks` needs with the rated payload, by the plant.
fn share_of_torque(motion: Motion, ticks: u32) -> f64 {
    let mut model = Model::new(&REFERENCE);
    model.set_payload(f64::from(Config::default().safety.rated_payload_kg));
    let shares = stop(motion, ticks).flat_map(|set_point| {
        let torque = model.inverse_dynamics(
            &positions(&set_point),
            &set_point.velocity.map(f64::from),
            &set_point.acceleration.map(f64::from),
        );
        (0..JOINTS).map(move |j| torque[j].abs() / REFERENCE.limits[j].tau_max)
    });
    shares.fold(0.0, f64::max)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// The planner looks at some places of a path and of a stop; what is between them keeps the reserve as well.
    #[test]
    fn what_the_planner_takes_can_be_stopped_within_the_reserve(
        trajectory in fast_paths(), place in 0.0..1.0f64,
    ) {
        if let Ok(motion) = start(&trajectory) {
            let ticks = (place * f64::from(trajectory.duration_ticks)) as u32;
            let share = share_of_torque(motion, ticks);
            prop_assert!(share <= 0.9, "{share} of the torque limits");
        }
    }

    /// Positions, velocities and accelerations of a stop belong together, and it ends at rest.
    #[test]
    fn a_stop_is_smooth_and_ends_at_rest(trajectory in fast_paths(), place in 0.0..0.9f64) {
        if let Ok(motion) = start(&trajectory) {
            let ticks = (place * f64::from(trajectory.duration_ticks)) as u32;
            let all: Vec<SetPoint> = stop(motion, ticks).collect();
            // Past the end of its path a half sine has no speed to lose.
            let whole = ticks + STOP < trajectory.duration_ticks;
            for pair in all.windows(2).filter(|_| whole) {
                for j in 0..JOINTS {
                    let moved = pair[1].position[j].wrapping_sub(pair[0].position[j]) as i32;
                    let mean = word_steps((pair[0].velocity[j] + pair[1].velocity[j]) / 2.0, j);
                    let bend = word_steps(pair[0].acceleration[j].abs() / TICK_HZ as f32, j);
                    let off = (f64::from(moved) - mean).abs();
                    let allowed = rounding_words(&trajectory, j) + 0.05 * bend + 1e-6 * mean.abs();
                    prop_assert!(off <= allowed, "joint {j}: {off}");
                    let gained = pair[1].velocity[j] - pair[0].velocity[j];
                    let mean = (pair[0].acceleration[j] + pair[1].acceleration[j]) / 2.0 / TICK_HZ as f32;
                    prop_assert!((gained - mean).abs() < 2e-5, "joint {j}: {gained} and {mean}");
                }
            }
            let end = all.last().expect("a set-point");
            prop_assert_eq!((end.velocity, end.acceleration), ([0.0; JOINTS], [0.0; JOINTS]));
        }
    }
}

/// The other way round: at the speed limits at full reach, the reserve would not do.
#[test]
fn a_stop_can_need_more_than_there_is() {
    let fastest = path(Profile::Quintic, 6.3, [2.0, -0.8, 1.3, 1.1]);
    let motion = crate::path::motion(&fastest);
    let worst = (0..20).map(|place| share_of_torque(motion, place * fastest.duration_ticks / 20));
    assert!(worst.fold(0.0, f64::max) > 1.0);
    assert!(start(&fastest).is_err());
}
