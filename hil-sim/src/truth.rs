//! What only the simulator can know: the true disturbance as the controller's model sees it, and the
//! Lyapunov functions of the true state.

use shared::arm::{Arm, JOINTS, REFERENCE};
use shared::telemetry::Record;

use crate::outcome::{Adaptation, Law};
use crate::path::Desired;
use crate::plant::{Model, Plant};
use crate::scenario::{Controller, Scenario};

type Joints = [f64; JOINTS];

/// The controller's model and gains in `f64`.
#[derive(Clone, Debug)]
pub struct Truth {
    believed: Model,
    controller: Controller,
}

impl Truth {
    /// For the scenario's controller.
    pub fn new(scenario: &Scenario) -> Self {
        let mut arm: Arm = REFERENCE;
        for link in &mut arm.links {
            link.mass_kg *= scenario.model.mass_scale;
            link.inertia_com_kg_m2 = link.inertia_com_kg_m2.map(|i| i * scenario.model.mass_scale);
        }
        let mut believed = Model::new(&arm);
        believed.set_payload(scenario.model.payload_kg);
        Self { believed, controller: scenario.controller }
    }

    /// V (Eq 21), Va (Eq 25) and the true disturbance: what tau lacks or has over the believed model.
    pub fn at(
        &self,
        plant: &Plant,
        torque: &Joints,
        desired: &Desired,
        record: &Record,
    ) -> (f64, f64, Joints) {
        let (q, qd) = (plant.q(), plant.qd());
        let needed = self.believed.inverse_dynamics(&q, &qd, &plant.acceleration(torque));
        let disturbance: Joints = std::array::from_fn(|j| torque[j] - needed[j]);
        let z: Joints = std::array::from_fn(|j| {
            self.controller.k1 * (q[j] - desired.q[j]) + qd[j] - desired.qd[j]
        });
        let v = 0.5 * z.iter().map(|z| z * z).sum::<f64>();
        let wrong = std::array::from_fn(|j| f64::from(record.d_hat[j]) - disturbance[j]);
        (v, v + self.estimation_energy(&q, &wrong), disturbance)
    }

    /// ½ d̃ᵀ psi⁻¹ d̃; nothing where nothing adapts.
    fn estimation_energy(&self, q: &Joints, wrong: &Joints) -> f64 {
        let c = &self.controller;
        match (c.law, c.adaptation) {
            (Law::Backstepping, Adaptation::Inertia) if c.wa > 0.0 => {
                let solved = self.believed.forward_dynamics(q, &[0.0; JOINTS], &{
                    let gravity = self.believed.gravity(q);
                    std::array::from_fn(|j| wrong[j] + gravity[j])
                });
                0.5 * solved.iter().map(|x| x * x).sum::<f64>() / (c.wa * c.wa)
            }
            (Law::Backstepping, Adaptation::Paper) => {
                0.5 * wrong.iter().zip(c.psi).map(|(d, psi)| d * d / psi).sum::<f64>()
            }
            _ => 0.0,
        }
    }
}
