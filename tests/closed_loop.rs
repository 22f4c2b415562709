//! The firmware's laws in `f32` closed around the plant with perfect state, against an independent `f64`
//! simulation of the same loops. No bus, no delay, no observer: only law, dynamics and plant are judged.

use firmware::JointVector;
use firmware::config::{ArmModel, Config, Law};
use firmware::dynamics::Constants;
use firmware::law::{self, Coefficients, State};
use hil_sim::metrics::Meter;
use hil_sim::outcome::Metrics;
use hil_sim::path::{Desired, Path};
use hil_sim::plant::{Disturbance, FRICTION, Plant, RATIOS, Ratios};
use hil_sim::scenario::Scenario;
use shared::arm::{JOINTS, Q0, REFERENCE};
use shared::command::Profile;
use tests::closed_loop::{self, Defaults, Row};
use tests::mdh::energy;

/// Largest relative difference of a metric.
const TOLERANCE: f64 = 5e-3;

/// Largest difference of d_hat at the end, N m and N: the size of the estimates is 1 to 40.
const D_HAT_TOLERANCE: f64 = 0.05;

/// One loop at tick k: metrics so far and the estimate.
struct Loop {
    coefficients: Coefficients,
    constants: Constants,
    path: Path,
    plant: Plant,
    tick_s: f64,
    ticks: u32,
    d_hat: JointVector,
    meter: Meter,
}

impl Loop {
    fn new(defaults: &Defaults, row: &Row) -> Self {
        let o = &row.overrides;
        let tick_hz = (1.0 / o.tick_s).round() as u32;
        let mut scenario = Scenario::load("paper").expect("a shipped scenario");
        scenario.tick_hz = tick_hz;
        scenario.duration_s = defaults.duration_s;
        scenario.trajectory.amplitude = row.amplitude;
        scenario.trajectory.profile = match o.profile {
            0 => Profile::Quintic,
            _ => Profile::HalfSine,
        };
        let path = Path::of(&scenario);
        // Rest to rest, a start with the desired velocity is a start at rest.
        assert!(o.starts_with_velocity == 0 || o.profile == 0, "{}", row.name);
        let disturbance = Disturbance::new(defaults.friction, Ratios::Fixed(defaults.ratios));
        let mut plant = Plant::in_motion(&REFERENCE, Q0, [0.0; JOINTS], disturbance, o.substeps);
        plant.start_disturbance();
        Self {
            coefficients: Coefficients::new(&config(defaults, row).gains, tick_hz as f32),
            constants: Constants::new(&ArmModel::new(&REFERENCE, 1.0, 0.0)),
            path,
            plant,
            tick_s: o.tick_s,
            ticks: (defaults.duration_s / o.tick_s).round() as u32,
            d_hat: JointVector::zeros(),
            meter: Meter::default(),
        }
    }

    /// Runs to the end; `feed` is how the law is told d_hat, `watch` sees time and estimate of each tick.
    fn run(
        mut self,
        feed: impl Fn(JointVector) -> JointVector,
        mut watch: impl FnMut(f64, &Desired, &JointVector),
    ) -> (Metrics, JointVector) {
        for k in 0..=self.ticks {
            let t_s = f64::from(k) * self.tick_s;
            let desired = self.path.at(t_s);
            self.judge(&desired);
            watch(t_s, &desired, &self.d_hat);
            let state = self.state(&desired);
            let wanted =
                law::evaluate(&self.coefficients, &self.constants, &state, &feed(self.d_hat));
            self.d_hat = law::adapt(&self.coefficients, &self.d_hat, &wanted.adaptation);
            self.plant.step(wanted.torque.map(f64::from).into(), self.tick_s);
        }
        (self.meter.metrics(), self.d_hat)
    }

    fn judge(&mut self, desired: &Desired) {
        let (tip, wanted) = (self.plant.tip().position_m, self.path.tip(desired));
        let error = std::array::from_fn(|axis| tip[axis] - wanted.position_m[axis]);
        self.meter.add(&error, wanted.speed_m_s);
    }

    /// The true state, each number rounded once.
    fn state(&self, desired: &Desired) -> State {
        let (q, qd) = (self.plant.q(), self.plant.qd());
        let vector = |f: &dyn Fn(usize) -> f64| JointVector::from_fn(|j, _| f(j) as f32);
        State {
            q: vector(&|j| q[j]),
            qd: vector(&|j| qd[j]),
            e1: vector(&|j| q[j] - desired.q[j]),
            e1_dot: vector(&|j| qd[j] - desired.qd[j]),
            qdd_d: vector(&|j| desired.qdd[j]),
        }
    }
}

fn config(defaults: &Defaults, row: &Row) -> Config {
    let o = &row.overrides;
    let mut config = Config::default();
    let gains = &mut config.gains;
    gains.law = match (o.controller, o.wa_squared, o.diagonal_wa) {
        (Some(1), None, None) => Law::PD,
        (Some(2), None, None) => Law::FIXED_GAIN,
        (None, Some(_), None) => Law::INERTIA_WEIGHTED,
        (None, None, Some(_)) => Law::PAPER_PSI,
        other => panic!("{}: {other:?} is no controller", row.name),
    };
    gains.k1 = [defaults.k1 as f32; JOINTS];
    gains.k2 = [defaults.k2 as f32; JOINTS];
    gains.kp = [defaults.kp as f32; JOINTS];
    gains.kd = [defaults.kd as f32; JOINTS];
    gains.wa_rad_s = o.wa_squared.unwrap_or(0.0).sqrt() as f32;
    gains.psi = defaults.psi.map(|psi| psi as f32);
    gains.d_max = defaults.d_max.map(|d| d as f32);
    config
}

/// Each metric beside its reference.
fn pairs(got: &Metrics, row: &Row) -> [(&'static str, f64, f64); 7] {
    [
        ("RMS x", got.rms_m[0], row.rms[0]),
        ("RMS y", got.rms_m[1], row.rms[1]),
        ("RMS z", got.rms_m[2], row.rms[2]),
        ("RSE", got.rse_m, row.rse),
        ("rho", got.rho_s, row.rho),
        ("e_max", got.e_max_m, row.e_max),
        ("v_max", got.v_max_m_s, row.v_max),
    ]
}

fn furthest(got: &Metrics, row: &Row) -> f64 {
    pairs(got, row).into_iter().fold(0.0, |worst, (_, got, want)| {
        let error = (got / want - 1.0).abs();
        if error <= worst { worst } else { error }
    })
}

#[test]
fn every_reference_run_is_met() {
    let reference = closed_loop::load();
    assert_eq!(reference.rows.len(), 6);
    for row in &reference.rows {
        let (metrics, d_hat) = Loop::new(&reference.defaults, row).run(|d| d, |_, _, _| ());
        let profile = row.overrides.profile;
        for (name, got, want) in pairs(&metrics, row) {
            let error = (got / want - 1.0).abs();
            assert!(error <= TOLERANCE, "{}, path {profile}: {name} {got:e}, {want:e}", row.name);
        }
        for (got, want) in d_hat.iter().zip(row.d_hat_end) {
            let error = (f64::from(*got) - want).abs();
            assert!(error <= D_HAT_TOLERANCE, "{}: d_hat {got}, {want}", row.name);
        }
    }
}

#[test]
fn a_wrong_sign_of_the_estimate_is_far_from_the_reference() {
    let reference = closed_loop::load();
    let adaptive = |row: &&Row| row.overrides.controller.is_none();
    for row in reference.rows.iter().filter(adaptive) {
        let (metrics, _) = Loop::new(&reference.defaults, row).run(|d| -d, |_, _, _| ());
        let error = furthest(&metrics, row);
        assert!(error > 20.0 * TOLERANCE, "{}: only {error:.1e} away", row.name);
    }
}

/// d = F qd + 30 sin(pi t) r (Eq 27, 28) with the signs of the plant's equation, from the desired path.
#[test]
fn the_estimate_is_the_disturbance_itself() {
    let reference = closed_loop::load();
    let row = &reference.rows[4];
    assert!(row.overrides.wa_squared.is_some() && row.overrides.profile == 1);
    let (mut wrong, mut whole) = ([0.0; JOINTS], [0.0; JOINTS]);
    Loop::new(&reference.defaults, row).run(
        |d| d,
        |t_s, desired, d_hat| {
            // The start-up transient of a start at rest is over by then.
            if t_s > 1.0 {
                let level = 30.0 * (std::f64::consts::PI * t_s).sin();
                for j in 0..JOINTS {
                    let d = FRICTION[j] * desired.qd[j] + level * RATIOS[j];
                    wrong[j] += (f64::from(d_hat[j]) - d).powi(2);
                    whole[j] += d * d;
                }
            }
        },
    );
    for j in 0..JOINTS {
        let error = (wrong[j] / whole[j]).sqrt();
        assert!(error < 0.25, "joint {}: the estimate errs by {error:.2} of d", j + 1);
    }
}

#[test]
fn friction_slows_each_joint_and_takes_energy() {
    let friction_only = || Disturbance::new(FRICTION, Ratios::Fixed([0.0; JOINTS]));
    for joint in 0..JOINTS {
        for speed in [-0.3, 0.3] {
            let qd = std::array::from_fn(|j| if j == joint { speed } else { 0.0 });
            let plant = Plant::in_motion(&REFERENCE, Q0, qd, friction_only(), 1);
            let bias = plant.model().bias(&Q0, &qd);
            let power_w: f64 = speed * plant.disturbance()[joint];
            let slowing = speed * plant.acceleration(&bias)[joint];
            assert!(power_w > 0.0 && slowing < 0.0, "joint {joint}: {power_w} W, {slowing}");
        }
    }
    let mut plant = Plant::in_motion(&REFERENCE, Q0, [0.3, -0.1, 0.2, 0.2], friction_only(), 1);
    let kinetic_j = |plant: &Plant| energy(&REFERENCE, 0.0, &plant.q(), &plant.qd()).0;
    let mut before_j = kinetic_j(&plant);
    for _ in 0..1000 {
        // Gravity is held, and C does no work, so only friction changes the kinetic energy; the torque
        // is held over a short step.
        let torque = plant.model().gravity(&plant.q());
        plant.step(torque, 1e-3);
        let now_j = kinetic_j(&plant);
        assert!(now_j < before_j, "{before_j} J, then {now_j} J");
        before_j = now_j;
    }
}
