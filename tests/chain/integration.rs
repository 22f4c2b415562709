//! The plant's integration step decides no figure.
//!
//! Closed loops of two step sizes part by 1e-13 m at first, then by other encoder and DAC codes: their errors,
//! a few counts each, become two samples of the same noise. So the step is judged in the loop without its
//! quantisers: the torques of a run, and the law's linear feedback on the distance from that run's states.

use hil_sim::metrics::Meter;
use hil_sim::outcome::{Metrics, Outcome, TickRow};
use hil_sim::path::Path;
use hil_sim::plant::{Disturbance, Plant, Ratios};
use hil_sim::run::{self, Options};
use hil_sim::scenario::{self, Scenario};
use shared::arm::{JOINTS, REFERENCE};

fn scenario(name: &str, substeps: u32) -> Scenario {
    let mut scenario = Scenario::load(name).expect("a shipped scenario");
    scenario.plant.substeps = substeps;
    scenario
}

fn outcome(scenario: &Scenario) -> Outcome {
    let options = Options { keep_rows: true, progress: &|_, _| () };
    run::run(scenario, options).expect("a configuration in range")
}

/// Metrics of a plant from the run's first state on, held to the run as told above.
fn replayed(scenario: &Scenario, outcome: &Outcome) -> Metrics {
    let scenario::Disturbance::Fixed(ratios) = scenario.plant.disturbance else {
        panic!("{}: only a fixed disturbance can be replayed", scenario.name)
    };
    let disturbance = Disturbance::new(scenario.plant.friction, Ratios::Fixed(ratios));
    let first = outcome.rows[0];
    let substeps = scenario.plant.substeps;
    let mut plant = Plant::in_motion(&REFERENCE, first.q, first.qd, disturbance, substeps);
    plant.start_disturbance();
    let path = Path::of(scenario);
    let mut meter = Meter::default();
    for row in &outcome.rows {
        let wanted = path.tip(&path.at(row.t_s));
        let tip = plant.tip().position_m;
        meter.add(
            &std::array::from_fn(|axis| tip[axis] - wanted.position_m[axis]),
            wanted.speed_m_s,
        );
        if let Some(payload) = scenario.plant.payload
            && row.t_s == payload.at_s
        {
            plant.set_payload(payload.kg);
        }
        let torque = held_to(&plant, row);
        plant.step(torque, 1.0 / f64::from(scenario.tick_hz));
    }
    meter.metrics()
}

/// The row's torque less M (K2 K1 e + (K1 + K2) e') for the distance e from the row's state.
fn held_to(plant: &Plant, row: &TickRow) -> [f64; JOINTS] {
    const K: f64 = 200.0;
    let (q, qd) = (plant.q(), plant.qd());
    let pull: [f64; JOINTS] =
        std::array::from_fn(|j| K * K * (q[j] - row.q[j]) + 2.0 * K * (qd[j] - row.qd[j]));
    let m = plant.model().mass_matrix(&q);
    std::array::from_fn(|i| row.torque[i] - (0..JOINTS).map(|j| m[i][j] * pull[j]).sum::<f64>())
}

fn furthest(a: &Metrics, b: &Metrics) -> f64 {
    let figures = |m: &Metrics| {
        let [x, y, z] = m.rms_m;
        [x, y, z, m.rse_m, m.rho_s, m.e_max_m, m.v_max_m_s]
    };
    let apart = figures(a).into_iter().zip(figures(b)).map(|(a, b)| (a / b - 1.0).abs());
    apart.fold(0.0, f64::max)
}

#[test]
fn halving_the_step_changes_no_metric() {
    for name in ["paper", "velocity-mismatch", "payload"] {
        let whole = scenario(name, 1);
        let outcome = outcome(&whole);
        let same = furthest(&replayed(&whole, &outcome), &outcome.metrics);
        assert!(same < 1e-9, "{name}: the replay is another run, {same:e}");
        let halved = furthest(&replayed(&scenario(name, 2), &outcome), &outcome.metrics);
        assert!(halved <= 1e-3, "{name}: a metric changes by {halved:e}");
    }
}

#[test]
fn halving_the_step_stays_within_the_noise_of_the_closed_loop() {
    for name in ["paper", "velocity-mismatch", "payload"] {
        let [whole, halved] = [1, 2].map(|substeps| outcome(&scenario(name, substeps)).metrics);
        let means = |m: Metrics| [m.rms_m[0], m.rms_m[1], m.rms_m[2], m.rse_m];
        for (whole, halved) in means(whole).into_iter().zip(means(halved)) {
            assert!((whole / halved - 1.0).abs() < 2e-2, "{name}: {whole:e} m and {halved:e} m");
        }
    }
}
