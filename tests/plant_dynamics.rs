//! The plant against Pinocchio's states, against an independent Jacobian form, and against physics.

use hil_sim::plant::{Disturbance, FRICTION, Model, Plant, RATIOS, Ratios};
use shared::arm::{GRAVITY_M_S2, Inertial, PAYLOAD, Q0, REFERENCE};
use tests::mdh::energy;
use tests::vectors::{self, Part};

type Joints = [f64; 4];

const TOLERANCE: f64 = 1e-9;

#[track_caller]
fn assert_close(what: &str, got: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(got.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(1e-3, |scale: f64, x| scale.max(x.abs()));
    for (got_i, expected_i) in got.iter().zip(expected) {
        let error = (got_i - expected_i).abs() / scale;
        assert!(error <= tolerance, "{what}: {got:?} is not {expected:?} ({error:e})");
    }
}

fn assert_part(part: &Inertial, expected: &Part) {
    assert_eq!(part.mass_kg, expected.mass);
    assert_eq!(part.com_m, expected.com);
    assert_eq!(part.inertia_com_kg_m2, expected.inertia_com);
}

#[test]
fn reference_arm_is_the_one_the_vectors_were_computed_with() {
    let set = vectors::load().inertial_set;
    let (g, k) = (REFERENCE.geometry, set.kinematics);
    assert_eq!([g.a1_m, g.a2_m, g.a3_m, g.d1_m, g.d3_m], [k.a1, k.a2, k.a3, k.d1, k.d3]);
    assert_eq!(GRAVITY_M_S2, set.gravity);
    REFERENCE.links.iter().zip(&set.links).for_each(|(link, part)| assert_part(link, part));
    assert_part(&PAYLOAD, &set.payload);
}

#[test]
fn kinematics_and_dynamics_agree_with_pinocchio() {
    let model = Model::new(&REFERENCE);
    let states = vectors::load().states;
    assert_eq!(states.len(), 100);
    for s in states {
        let pose = model.forward(&s.q);
        assert_close("position", &pose.position_m, &s.position_m, TOLERANCE);
        assert_close("rotation", pose.rotation.as_flattened(), &s.rotation, TOLERANCE);
        for (row, expected) in model.jacobian(&s.q).iter().zip(s.jacobian.chunks(4)) {
            assert_close("jacobian", row, expected, TOLERANCE);
        }
        for (row, expected) in model.mass_matrix(&s.q).iter().zip(s.mass.chunks(4)) {
            assert_close("mass", row, expected, TOLERANCE);
        }
        assert_close("coriolis", &model.coriolis(&s.q, &s.qd), &s.coriolis, TOLERANCE);
        assert_close("gravity", &model.gravity(&s.q), &s.gravity, TOLERANCE);
        let torque = model.inverse_dynamics(&s.q, &s.qd, &s.qdd);
        assert_close("torque", &torque, &s.torque, TOLERANCE);
        assert_close("qdd", &model.forward_dynamics(&s.q, &s.qd, &s.torque), &s.qdd, TOLERANCE);
    }
}

#[test]
fn mass_matrix_agrees_with_the_jacobian_form() {
    for payload_kg in [0.0, 300.0, 450.0] {
        let mut model = Model::new(&REFERENCE);
        model.set_payload(payload_kg);
        for s in vectors::load().states {
            let (kinetic_j, _) = energy(&REFERENCE, payload_kg, &s.q, &s.qd);
            let m = model.mass_matrix(&s.q);
            assert_close("kinetic energy", &[0.5 * form(&m, &s.qd)], &[kinetic_j], TOLERANCE);
        }
    }
}

#[test]
fn mass_matrix_is_symmetric_and_positive_definite() {
    let mut model = Model::new(&REFERENCE);
    model.set_payload(300.0);
    for s in vectors::load().states {
        let m = model.mass_matrix(&s.q);
        for i in 0..4 {
            assert!((0..4).all(|j| m[i][j] == m[j][i]), "{m:?}");
        }
        assert!(pivots(m).iter().all(|&pivot| pivot > 0.0), "{m:?}");
    }
}

/// qd^T (Mdot - 2C) qd = 0, and gravity is the slope of the potential energy.
#[test]
fn bias_does_no_work_beyond_the_energies() {
    let payload_kg = 300.0;
    let mut model = Model::new(&REFERENCE);
    model.set_payload(payload_kg);
    let h_s = 1e-5;
    for s in vectors::load().states {
        let at = |t_s: f64| core::array::from_fn(|j| s.q[j] + t_s * s.qd[j]);
        let slope = |f: &dyn Fn(&Joints) -> f64| (f(&at(h_s)) - f(&at(-h_s))) / (2.0 * h_s);

        let kinetic_w = slope(&|q| 0.5 * form(&model.mass_matrix(q), &s.qd));
        let coriolis_w = dot(&s.qd, &model.coriolis(&s.q, &s.qd));
        let scale = s.qd.iter().map(|v| v.abs()).sum::<f64>().powi(3) * 1e4 + 1.0;
        assert!((kinetic_w - coriolis_w).abs() < 1e-7 * scale, "{kinetic_w} W, {coriolis_w} W");

        let potential_w = slope(&|q| energy(&REFERENCE, payload_kg, q, &[0.0; 4]).1);
        let gravity_w = dot(&s.qd, &model.gravity(&s.q));
        assert!((potential_w - gravity_w).abs() < 1e-3, "{potential_w} W, {gravity_w} W");
    }
}

#[test]
fn payload_makes_one_body_with_the_telescope() {
    let mut loaded = Model::new(&REFERENCE);
    loaded.set_payload(300.0);
    let mut arm = REFERENCE;
    arm.links[3] = welded(&REFERENCE.links[3], &PAYLOAD);
    let composite = Model::new(&arm);
    let mut dropped = loaded.clone();
    dropped.set_payload(0.0);
    for s in vectors::load().states {
        let torque = |model: &Model| model.inverse_dynamics(&s.q, &s.qd, &s.qdd);
        assert_close("torque", &torque(&loaded), &torque(&composite), 1e-12);
        assert_eq!(torque(&dropped), torque(&Model::new(&REFERENCE)));
    }
}

#[test]
fn free_swing_keeps_its_energy() {
    for payload_kg in [0.0, 300.0] {
        let mut plant = frictionless(1);
        plant.set_payload(payload_kg);
        let total = |plant: &Plant| {
            let (kinetic, potential) = energy(&REFERENCE, payload_kg, &plant.q(), &plant.qd());
            (kinetic, kinetic + potential)
        };
        let (start_j, total_j) = total(&plant);
        run(&mut plant, [0.0; 4], 1.0, 1000.0);
        let (end_j, drifted_j) = total(&plant);
        assert!(end_j - start_j > 1000.0, "the arm hardly moved: {start_j} J, {end_j} J");
        assert!((drifted_j - total_j).abs() < 1e-10 * (end_j - start_j), "{total_j} {drifted_j}");
    }
}

#[test]
fn friction_takes_the_energy_that_its_power_adds_up_to() {
    let mut plant = Plant::in_motion(&REFERENCE, Q0, SWING, friction_only(FRICTION), 1);
    let total_j = |plant: &Plant| {
        let (kinetic, potential) = energy(&REFERENCE, 0.0, &plant.q(), &plant.qd());
        kinetic + potential
    };
    let before_j = total_j(&plant);
    let torque = plant.model().gravity(&Q0);
    let power_w = |plant: &Plant| dot(&plant.qd(), &plant.disturbance());
    let supplied_w = |plant: &Plant| dot(&plant.qd(), &torque);
    let (mut lost_j, mut supplied_j, dt_s) = (0.0, 0.0, 1e-4);
    for _ in 0..5000 {
        let (lost_w, gained_w) = (power_w(&plant), supplied_w(&plant));
        plant.step(torque, dt_s);
        lost_j += 0.5 * dt_s * (lost_w + power_w(&plant));
        supplied_j += 0.5 * dt_s * (gained_w + supplied_w(&plant));
    }
    let balance_j = before_j + supplied_j - lost_j - total_j(&plant);
    assert!(lost_j > 10.0, "friction took {lost_j} J");
    assert!(balance_j.abs() < 1e-4, "{balance_j} J are missing after {lost_j} J of friction");
}

#[test]
fn reversed_motion_returns_to_its_start() {
    let mut there = frictionless(1);
    run(&mut there, [0.0; 4], 0.5, 4000.0);
    let back_speed = there.qd().map(|v| -v);
    let mut back = Plant::in_motion(&REFERENCE, there.q(), back_speed, friction_only([0.0; 4]), 1);
    run(&mut back, [0.0; 4], 0.5, 4000.0);
    assert_close("q", &back.q(), &Q0, 1e-9);
    assert_close("qd", &back.qd(), &SWING.map(|v| -v), 1e-9);
}

#[test]
fn halved_step_changes_nothing_and_converges_with_fourth_order() {
    let end = |substeps| {
        let disturbance = Disturbance::new(FRICTION, Ratios::Fixed(RATIOS));
        let mut plant = Plant::in_motion(&REFERENCE, Q0, SWING, disturbance, substeps);
        plant.start_disturbance();
        let torque = plant.model().gravity(&Q0);
        run(&mut plant, torque, 1.0, 1000.0);
        plant.q()
    };
    let apart =
        |a: Joints, b: Joints| a.iter().zip(b).fold(0.0, |d: f64, (a, b)| d.max((a - b).abs()));
    let one_step = apart(end(1), end(2));
    assert!(one_step < 1e-11, "1 kHz with one and two steps a tick differ by {one_step:e}");

    let coarse = |ticks_hz: f64| {
        let mut plant = Plant::in_motion(&REFERENCE, Q0, SWING, friction_only(FRICTION), 1);
        run(&mut plant, [0.0; 4], 1.0, ticks_hz);
        plant.q()
    };
    let fine = coarse(1000.0);
    let ratio = apart(coarse(10.0), fine) / apart(coarse(20.0), fine);
    assert!((10.0..25.0).contains(&ratio), "halving the step divides the error by {ratio}");
}

const SWING: Joints = [0.5, -0.3, 0.4, 0.2];

fn friction_only(friction: Joints) -> Disturbance {
    Disturbance::new(friction, Ratios::Fixed(RATIOS))
}

fn frictionless(substeps: u32) -> Plant {
    Plant::in_motion(&REFERENCE, Q0, SWING, friction_only([0.0; 4]), substeps)
}

fn run(plant: &mut Plant, torque: Joints, duration_s: f64, tick_hz: f64) {
    for _ in 0..(duration_s * tick_hz) as u32 {
        plant.step(torque, 1.0 / tick_hz);
    }
}

fn dot(a: &Joints, b: &Joints) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// v^T M v.
fn form(m: &[Joints; 4], v: &Joints) -> f64 {
    dot(v, &m.map(|row| dot(&row, v)))
}

/// Pivots of Gaussian elimination: all positive exactly if a symmetric matrix is positive definite.
fn pivots(mut m: [Joints; 4]) -> Joints {
    for k in 0..4 {
        for i in k + 1..4 {
            let factor = m[i][k] / m[k][k];
            let row = m[k];
            m[i].iter_mut().zip(row).for_each(|(x, y)| *x -= factor * y);
        }
    }
    core::array::from_fn(|k| m[k][k])
}

/// Two bodies as one, by the parallel-axis theorem about the common centre of mass.
fn welded(a: &Inertial, b: &Inertial) -> Inertial {
    let mass_kg = a.mass_kg + b.mass_kg;
    let com_m =
        core::array::from_fn(|i| (a.mass_kg * a.com_m[i] + b.mass_kg * b.com_m[i]) / mass_kg);
    let about = |part: &Inertial| {
        let [x, y, z]: [f64; 3] = core::array::from_fn(|i| part.com_m[i] - com_m[i]);
        let m = part.mass_kg;
        let moved = [y * y + z * z, x * x + z * z, x * x + y * y, -x * y, -x * z, -y * z];
        let inertia: [f64; 6] = core::array::from_fn(|i| part.inertia_com_kg_m2[i] + m * moved[i]);
        inertia
    };
    let (of_a, of_b) = (about(a), about(b));
    Inertial { mass_kg, com_m, inertia_com_kg_m2: core::array::from_fn(|i| of_a[i] + of_b[i]) }
}
