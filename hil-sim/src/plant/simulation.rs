//! The moving arm: M qdd + C qd + G = tau - d + brakes, integrated by the classical Runge-Kutta method.

use shared::arm::{Arm, JOINTS};

use super::brake::{BrakeFault, Brakes};
use super::disturbance::Disturbance;
use super::model::{Dynamics, Model};
use super::{Joints, Pose, ahead};

/// State of the arm, its load, its brakes and what disturbs it.
#[derive(Clone, Debug)]
pub struct Plant {
    model: Model,
    payload_kg: f64,
    q: Joints,
    qd: Joints,
    brakes: Brakes,
    release: [bool; JOINTS],
    disturbance: Disturbance,
    /// At the present state, so that the first stage of a step and the latch times of sensors share it.
    dynamics: Dynamics,
    substeps: u32,
}

impl Plant {
    /// At rest in closed brakes; every step is integrated in `substeps` equal parts.
    pub fn at_rest(arm: &Arm, q: Joints, disturbance: Disturbance, substeps: u32) -> Self {
        let brakes = Brakes::closed(&arm.limits);
        Self::new(arm, (q, [0.0; 4]), (brakes, false), disturbance, substeps)
    }

    /// Moving freely, brakes open and commanded open.
    pub fn in_motion(
        arm: &Arm,
        q: Joints,
        qd: Joints,
        disturbance: Disturbance,
        substeps: u32,
    ) -> Self {
        let brakes = Brakes::open(&arm.limits);
        Self::new(arm, (q, qd), (brakes, true), disturbance, substeps)
    }

    fn new(
        arm: &Arm,
        (q, qd): (Joints, Joints),
        (brakes, release): (Brakes, bool),
        disturbance: Disturbance,
        substeps: u32,
    ) -> Self {
        let model = Model::new(arm);
        let dynamics = model.at(&q, &qd, &brakes.locked());
        let release = [release; JOINTS];
        Self { model, payload_kg: 0.0, q, qd, brakes, release, disturbance, dynamics, substeps }
    }

    /// Joint positions, rad and m.
    pub fn q(&self) -> Joints {
        self.q
    }

    /// Joint speeds, rad/s and m/s.
    pub fn qd(&self) -> Joints {
        self.qd
    }

    /// Pose of the tip.
    pub fn tip(&self) -> Pose {
        self.model.forward(&self.q)
    }

    /// The true model, payload included.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// True disturbance d (Eq 27 and 28) at this instant, N m and N.
    pub fn disturbance(&self) -> Joints {
        ahead(&self.disturbance.friction(&self.qd), 1.0, &self.disturbance.external(0.0))
    }

    /// Makes this instant t = 0 of Eq 28, which is zero before.
    pub fn start_disturbance(&mut self) {
        self.disturbance.start();
    }

    /// Picks up, with the tip's own velocity, or drops a payload; joint speeds do not change.
    pub fn set_payload(&mut self, mass_kg: f64) {
        self.model.set_payload(mass_kg);
        self.payload_kg = mass_kg;
        self.refresh();
    }

    /// The payload that it carries, kg.
    pub fn payload_kg(&self) -> f64 {
        self.payload_kg
    }

    /// Commands the brakes, `true` to open.
    pub fn set_brake_release(&mut self, release: [bool; JOINTS]) {
        self.release = release;
    }

    /// Makes the brake of a joint faulty, or sound again.
    pub fn set_brake_fault(&mut self, joint: usize, fault: BrakeFault) {
        self.brakes.set_fault(joint, fault);
    }

    /// Feedback contacts of the brakes, `true` while open.
    pub fn brake_released(&self) -> [bool; JOINTS] {
        self.brakes.released()
    }

    /// Acceleration at this instant under this drive torque, rad/s² and m/s². Within a tick a joint is at
    /// q + qd t + qdd t²/2.
    pub fn acceleration(&self, torque: &Joints) -> Joints {
        let drive = self.drive(torque);
        self.solve(&self.dynamics, &self.qd, &ahead(&drive, -1.0, &self.disturbance.external(0.0)))
    }

    /// Applies the drive torque (N m and N) for `dt_s`.
    pub fn step(&mut self, torque: Joints, dt_s: f64) {
        self.break_away(&torque);
        for _ in 0..self.substeps {
            self.advance(&torque, dt_s / f64::from(self.substeps));
        }
        self.brakes.advance(&self.release, dt_s, &self.qd);
        self.disturbance.redraw();
        self.refresh_locks();
    }

    /// Checks the stuck brakes against the torque that they have to give.
    fn break_away(&mut self, torque: &Joints) {
        if self.brakes.locked().contains(&true) {
            let held = self.acceleration(torque);
            let required = self.model.inverse_dynamics(&self.q, &self.qd, &held);
            let given = ahead(&self.drive(torque), -1.0, &self.disturbance());
            self.brakes.break_away(&ahead(&required, -1.0, &given));
            self.refresh_locks();
        }
    }

    /// Integrates up to `dt_s`, cut where a sliding joint comes to rest. Each cut locks one joint, so there
    /// are at most as many as joints.
    fn advance(&mut self, torque: &Joints, dt_s: f64) {
        let mut left_s = dt_s;
        loop {
            let (q, qd) = self.runge_kutta(torque, left_s);
            let Some((joint, share)) = self.brakes.first_stop(&self.qd, &qd) else {
                self.accept(q, qd, left_s);
                return;
            };
            let until_stop_s = share * left_s;
            let (q, mut qd) = self.runge_kutta(torque, until_stop_s);
            qd[joint] = 0.0;
            self.brakes.stick(joint);
            self.accept(q, qd, until_stop_s);
            left_s -= until_stop_s;
        }
    }

    fn accept(&mut self, q: Joints, qd: Joints, dt_s: f64) {
        self.q = q;
        self.qd = qd;
        self.disturbance.advance(dt_s);
        self.refresh();
    }

    fn refresh(&mut self) {
        self.dynamics = self.model.at(&self.q, &self.qd, &self.brakes.locked());
    }

    fn refresh_locks(&mut self) {
        if self.brakes.locked() != self.dynamics.locked {
            self.refresh();
        }
    }

    /// Torque of the drives and of sliding brakes.
    fn drive(&self, torque: &Joints) -> Joints {
        ahead(torque, 1.0, &self.brakes.drag())
    }

    /// Acceleration under `load`, which friction reduces.
    fn solve(&self, dynamics: &Dynamics, qd: &Joints, load: &Joints) -> Joints {
        dynamics.acceleration(&ahead(load, -1.0, &self.disturbance.friction(qd)))
    }

    /// Position and speed after `h_s`.
    fn runge_kutta(&self, torque: &Joints, h_s: f64) -> (Joints, Joints) {
        let (half_s, locked) = (0.5 * h_s, self.dynamics.locked);
        let drive = self.drive(torque);
        let load = |later_s| ahead(&drive, -1.0, &self.disturbance.external(later_s));
        let stage = |q: &Joints, qd: &Joints, load: &Joints| {
            self.solve(&self.model.at(q, qd, &locked), qd, load)
        };
        let (start, middle, end) = (load(0.0), load(half_s), load(h_s));

        let (q, v1) = (&self.q, self.qd);
        let a1 = self.solve(&self.dynamics, &v1, &start);
        let v2 = ahead(&v1, half_s, &a1);
        let a2 = stage(&ahead(q, half_s, &v1), &v2, &middle);
        let v3 = ahead(&v1, half_s, &a2);
        let a3 = stage(&ahead(q, half_s, &v2), &v3, &middle);
        let v4 = ahead(&v1, h_s, &a3);
        let a4 = stage(&ahead(q, h_s, &v3), &v4, &end);

        let sixth_s = h_s / 6.0;
        let mean = |k1: &Joints, k2: &Joints, k3: &Joints, k4: &Joints| {
            core::array::from_fn(|j| k1[j] + 2.0 * (k2[j] + k3[j]) + k4[j])
        };
        (
            ahead(q, sixth_s, &mean(&v1, &v2, &v3, &v4)),
            ahead(&v1, sixth_s, &mean(&a1, &a2, &a3, &a4)),
        )
    }
}

#[cfg(test)]
mod tests;
