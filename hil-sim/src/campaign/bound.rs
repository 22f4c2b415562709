//! How far the bare plant sinks: with the fault acting until the reaction's limit, then under an ideal reaction.

use shared::arm::{JOINTS, REFERENCE};

use super::measure::Track;
use super::row::Acting;
use super::trial::{TICK_S, Trial};
use crate::path::Path;
use crate::plant::{BRAKE_CLOSE_S, Disturbance, FRICTION, Joints, Model, Plant, RATIOS, Ratios};
use crate::scenario::Scenario;

/// On top of what the bare plant does.
const MARGIN: f64 = 1.1;
/// Time that the plant is followed, s.
const FOLLOWED_S: f64 = 2.0;
/// A brake's friction over the torque limit.
const BRAKE: f64 = 1.5;
/// Steps a tick of the isolated joint's motion.
const SUBSTEPS: u32 = 10;

/// The bound, m: the state is that of step `from` of `trial`, the torques are those of the step before, and the
/// reaction comes up to `limit` ticks later, whenever that is worst: a fault may lift the arm until then. Heights count
/// from `reference`.
pub fn bound_m(
    trial: &Trial,
    from: usize,
    limit: u32,
    acting: Acting,
    scenario: &Scenario,
    reference: &Track,
) -> f64 {
    let t_s = trial.frames[from].true_s - trial.start_s.unwrap_or(0.0);
    let sinking = |limit| {
        let heights = match acting {
            Acting::Isolated(j) => isolated(trial, from, limit, j, scenario),
            _ => cut(trial, from, limit, acting, scenario),
        };
        let below = heights.iter().enumerate();
        below.map(|(i, h)| reference.height(t_s + i as f64 * TICK_S) - h).fold(0.0, f64::max)
    };
    MARGIN * (0..=limit).map(sinking).fold(0.0, f64::max)
}

/// Torque of the fault until the limit, then none and all brakes.
fn cut(trial: &Trial, from: usize, limit: u32, acting: Acting, scenario: &Scenario) -> Vec<f64> {
    let (frame, before) = (&trial.frames[from], &trial.frames[from - 1]);
    let t_s = frame.true_s - trial.start_s.unwrap_or(0.0);
    let disturbance = Disturbance::new(FRICTION, Ratios::Fixed(RATIOS));
    let mut plant = Plant::in_motion(&REFERENCE, frame.q, frame.qd, disturbance, 1);
    plant.set_payload(scenario.plant.payload_kg);
    let law = Law { path: Path::of(scenario), scenario };
    (0..(FOLLOWED_S / TICK_S) as u32)
        .map(|tick| {
            let acts = tick < limit;
            plant.set_brake_release([acts; JOINTS]);
            let height = plant.tip().position_m[2];
            let torque = match acting {
                _ if !acts => [0.0; JOINTS],
                Acting::Held => before.torque,
                Acting::Limp | Acting::Isolated(_) => [0.0; JOINTS],
                Acting::Stuck(j, share) => {
                    let mut torque = law.torque(&plant, t_s + f64::from(tick) * TICK_S);
                    torque[j] = share * REFERENCE.drive_full_scale[j];
                    torque
                }
                Acting::Inverted(j) => {
                    let mut torque = law.torque(&plant, t_s + f64::from(tick) * TICK_S);
                    torque[j] = -torque[j];
                    torque
                }
            };
            plant.step(torque, TICK_S);
            height
        })
        .collect()
}

/// The law with a true model and true measurements: what acts where a drive does not do as it is told.
struct Law<'a> {
    path: Path,
    scenario: &'a Scenario,
}

impl Law<'_> {
    fn torque(&self, plant: &Plant, t_s: f64) -> Joints {
        let (q, qd, desired) = (plant.q(), plant.qd(), self.path.at(t_s));
        let (k1, k2) = (self.scenario.controller.k1, self.scenario.controller.k2);
        let wanted = std::array::from_fn(|j| {
            let (e, rate) = (q[j] - desired.q[j], qd[j] - desired.qd[j]);
            desired.qdd[j] - (k1 + k2) * rate - (1.0 + k1 * k2) * e
        });
        let torque = plant.model().inverse_dynamics(&q, &qd, &wanted);
        std::array::from_fn(|j| {
            let limit = REFERENCE.limits[j].tau_max;
            (torque[j] + FRICTION[j] * qd[j]).clamp(-limit, limit)
        })
    }
}

/// Joint `j` is limp and gets its brake at the limit; the others stop along the path from then on.
fn isolated(trial: &Trial, from: usize, limit: u32, j: usize, scenario: &Scenario) -> Vec<f64> {
    let frame = &trial.frames[from];
    let t_s = frame.true_s - trial.start_s.unwrap_or(0.0);
    let path = Path::of(scenario);
    let mut model = Model::new(&REFERENCE);
    model.set_payload(scenario.plant.payload_kg);
    let (mut q, mut qd) = (frame.q[j], frame.qd[j]);
    let reacts_s = f64::from(limit) * TICK_S;
    let brakes_s = reacts_s + BRAKE_CLOSE_S;
    let h_s = TICK_S / f64::from(SUBSTEPS);
    let mut heights = Vec::new();
    for step in 0..(FOLLOWED_S / h_s) as u32 {
        let now_s = f64::from(step) * h_s;
        let (mut place, mut speed, mut change) = stopping(&path, t_s, now_s, reacts_s);
        (place[j], speed[j], change[j]) = (q, qd, 0.0);
        if step % SUBSTEPS == 0 {
            heights.push(model.tip(&place, &speed).0[2]);
        }
        let needed = model.inverse_dynamics(&place, &speed, &change)[j];
        change[j] = 1.0;
        let inertia = model.inverse_dynamics(&place, &speed, &change)[j] - needed;
        let free = -(needed + FRICTION[j] * qd) / inertia;
        let grip =
            if now_s >= brakes_s { BRAKE * REFERENCE.limits[j].tau_max / inertia } else { 0.0 };
        qd = braked(qd + h_s * free, h_s * grip);
        q += h_s * qd;
    }
    heights
}

/// A speed less what a brake takes of it.
fn braked(speed: f64, taken: f64) -> f64 {
    if speed.abs() <= taken { 0.0 } else { speed - taken * speed.signum() }
}

/// Duration of a stop, s.
const STOP_S: f64 = 0.15;

/// Position, speed and acceleration `now_s` after `t_s` on a path along which a stop begins `after_s` after `t_s`: the
/// path rate is 1 - 3x² + 2x³ over the stop's duration.
fn stopping(path: &Path, t_s: f64, now_s: f64, after_s: f64) -> (Joints, Joints, Joints) {
    if now_s < after_s {
        let at = path.at(t_s + now_s);
        return (at.q, at.qd, at.qdd);
    }
    let x = ((now_s - after_s) / STOP_S).min(1.0);
    let rate = 1.0 - x * x * (3.0 - 2.0 * x);
    let slope = if x < 1.0 { -6.0 * x * (1.0 - x) / STOP_S } else { 0.0 };
    let way_s = STOP_S * (x - x.powi(3) + 0.5 * x.powi(4));
    let at = path.at(t_s + after_s + way_s);
    let speed = at.qd.map(|v| v * rate);
    let change = std::array::from_fn(|j| at.qdd[j] * rate * rate + at.qd[j] * slope);
    (at.q, speed, change)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::pose::{PATH_S, Pose};

    #[test]
    fn stop_follows_its_path_without_a_step_and_comes_to_rest() {
        let poses = Pose::all().expect("good poses");
        let path = Path::of(&poses[1].scenario(PATH_S, 1));
        let (h_s, after_s) = (1e-5, 6e-3);
        let at = |now_s| stopping(&path, 1.0, now_s, after_s);
        for step in 0..20_000 {
            let now_s = f64::from(step) * h_s;
            let ((q, qd, qdd), (later, faster, _)) = (at(now_s), at(now_s + h_s));
            for j in 0..JOINTS {
                assert!((later[j] - q[j] - h_s * qd[j]).abs() < 2e-9, "{now_s} {j}");
                assert!((faster[j] - qd[j] - h_s * qdd[j]).abs() < 2e-7, "{now_s} {j}");
            }
        }
        assert_eq!(at(after_s + STOP_S + h_s).1, [0.0; JOINTS]);
    }

    #[test]
    fn brake_takes_speed_and_never_turns_it() {
        assert_eq!([braked(0.3, 0.1), braked(-0.3, 0.1)], [0.3 - 0.1, -0.3 + 0.1]);
        assert_eq!([braked(0.05, 0.1), braked(-0.05, 0.1)], [0.0, 0.0]);
    }
}
