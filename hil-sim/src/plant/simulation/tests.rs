//! Brakes, payload and latch times on the moving arm.

use super::*;
use crate::plant::{BRAKE_CLOSE_S, BRAKE_OPEN_S, FRICTION, RATIOS, Ratios};
use shared::arm::{Q0, REFERENCE};

const TICK_S: f64 = 1e-3;
const OFF: Joints = [0.0; 4];

fn disturbance() -> Disturbance {
    Disturbance::new(FRICTION, Ratios::Fixed(RATIOS))
}

fn run(plant: &mut Plant, torque: Joints, duration_s: f64, tick_s: f64) {
    for _ in 0..(duration_s / tick_s).round() as u32 {
        plant.step(torque, tick_s);
    }
}

#[test]
fn closed_brakes_freeze_the_arm_until_they_are_open() {
    let mut plant = Plant::at_rest(&REFERENCE, Q0, disturbance(), 1);
    run(&mut plant, OFF, 0.2, TICK_S);
    plant.set_brake_release([true; 4]);
    run(&mut plant, OFF, BRAKE_OPEN_S - TICK_S, TICK_S);
    assert_eq!((plant.q(), plant.qd(), plant.brake_released()), (Q0, OFF, [false; 4]));
    run(&mut plant, OFF, TICK_S, TICK_S);
    assert_eq!((plant.q(), plant.brake_released()), (Q0, [true; 4]));
    run(&mut plant, OFF, TICK_S, TICK_S);
    assert!((0..4).skip(1).all(|j| plant.qd()[j] != 0.0), "{:?}", plant.qd());
}

#[test]
fn lone_free_joint_follows_its_own_row() {
    let mut plant = Plant::at_rest(&REFERENCE, Q0, disturbance(), 1);
    plant.set_brake_release([false, false, true, false]);
    run(&mut plant, OFF, 0.4, TICK_S);
    let (q, qd) = (plant.q(), plant.qd());
    assert!(qd[2].abs() > 0.1 && [q[0], q[1], q[3]] == [Q0[0], Q0[1], Q0[3]]);
    let torque = [9e3, 9e3, 1e3, 9e3];
    let pull = torque[2] - 200.0 * qd[2] - plant.model().bias(&q, &qd)[2];
    let expected = pull / plant.model().mass_matrix(&q)[2][2];
    let qdd = plant.acceleration(&torque);
    assert!((qdd[2] / expected - 1.0).abs() < 1e-12, "{qdd:?}, joint 3 alone {expected}");
    assert_eq!([qdd[0], qdd[1], qdd[3]], [0.0; 3]);
}

/// Torque is lost at the start of the lift and the brakes are set at once.
fn limp_fall(tick_s: f64) -> (f64, Plant) {
    let mut plant = Plant::in_motion(&REFERENCE, Q0, OFF, disturbance(), 1);
    plant.set_brake_release([false; 4]);
    let height_m = plant.tip().position_m[2];
    run(&mut plant, OFF, BRAKE_CLOSE_S, tick_s);
    assert_eq!(plant.brake_released(), [false; 4]);
    let drop_m = height_m - plant.tip().position_m[2];
    run(&mut plant, OFF, 0.2, tick_s);
    (drop_m, plant)
}

#[test]
fn limp_arm_drops_until_the_brakes_bite_and_then_stands_still() {
    let (drop_m, mut plant) = limp_fall(TICK_S);
    assert!((0.03..0.12).contains(&drop_m), "dropped {drop_m} m in 100 ms");
    let stopped = plant.q();
    assert_eq!(plant.qd(), OFF);
    run(&mut plant, OFF, 1.0, TICK_S);
    assert_eq!(plant.q(), stopped);
}

#[test]
fn stop_in_the_brakes_does_not_depend_on_the_tick() {
    let (coarse, fine) = (limp_fall(1e-3).1.q(), limp_fall(1e-3 / 8.0).1.q());
    for j in 0..4 {
        assert!((coarse[j] - fine[j]).abs() < 1e-6, "{coarse:?} at 1 kHz, {fine:?} at 8 kHz");
    }
}

#[test]
fn sliding_brake_takes_one_and_a_half_times_the_torque_limit() {
    let qd = [0.0, 0.0, 0.0, 0.8];
    let mut plant = Plant::in_motion(&REFERENCE, Q0, qd, disturbance(), 1);
    let torque = plant.model().bias(&Q0, &qd);
    let free = plant.acceleration(&torque)[3];
    plant.set_brake_release([true, true, true, false]);
    plant.brakes.advance(&plant.release, BRAKE_CLOSE_S, &plant.qd);
    let work = plant.model.inverse_dynamics(&Q0, &qd, &plant.acceleration(&torque));
    let brake_n = work[3] - (torque[3] - FRICTION[3] * 0.8);
    assert!((brake_n + 45_000.0).abs() < 1e-6, "{brake_n} N");
    assert!(free < 0.0 && free > -1.0, "friction alone slows by {free} m/s²");
}

#[test]
fn overloaded_brake_gives_way_and_catches_the_joint_again() {
    let mut plant = Plant::at_rest(&REFERENCE, Q0, disturbance(), 1);
    let hold = plant.model().gravity(&Q0);
    let slip = [hold[0], hold[1], hold[2], hold[3] + 46_000.0];
    run(&mut plant, slip, 0.05, TICK_S);
    assert!(plant.qd()[3] > 0.1, "{:?}", plant.qd());
    assert_eq!(plant.qd()[..3], [0.0; 3]);
    run(&mut plant, hold, 0.05, TICK_S);
    assert_eq!(plant.qd(), OFF);
}

#[test]
fn payload_comes_with_the_speed_of_the_tip_and_weighs_down() {
    let qd = [0.1, -0.05, 0.1, 0.2];
    let mut plant = Plant::in_motion(&REFERENCE, Q0, qd, disturbance(), 1);
    let torque = plant.model().gravity(&Q0);
    let before = plant.acceleration(&torque);
    plant.set_payload(300.0);
    assert_eq!((plant.q(), plant.qd()), (Q0, qd));
    let gained = ahead(&plant.acceleration(&torque), -1.0, &before);
    let up = plant.model().jacobian(&Q0)[2];
    let tip_m_s2: f64 = up.iter().zip(gained).map(|(row, qdd)| row * qdd).sum();
    assert!((-9.81..-1.0).contains(&tip_m_s2), "tip accelerates by {tip_m_s2} m/s² more");
}

#[test]
fn acceleration_is_the_slope_of_speed_and_extrapolates_position() {
    let mut plant = Plant::in_motion(&REFERENCE, Q0, [0.3, 0.1, -0.2, 0.4], disturbance(), 1);
    plant.start_disturbance();
    run(&mut plant, OFF, 0.3, TICK_S);
    let (torque, delta_s) = ([500.0, 9e3, 6e3, -300.0], 20e-6);
    let (q, qd, qdd) = (plant.q(), plant.qd(), plant.acceleration(&torque));
    plant.step(torque, delta_s);
    for j in 0..4 {
        let slope = (plant.qd()[j] - qd[j]) / delta_s;
        assert!((slope - qdd[j]).abs() < 1e-3, "joint {j}: {slope}, {}", qdd[j]);
        let latched = q[j] + qd[j] * delta_s + 0.5 * qdd[j] * delta_s * delta_s;
        assert!((latched - plant.q()[j]).abs() < 1e-13, "joint {j}");
    }
}
