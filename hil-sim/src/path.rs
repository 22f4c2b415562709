//! The desired path in `f64`, which metrics compare with, and the command that asks for it.

use std::f64::consts::PI;

use shared::arm::{Arm, JOINTS};
use shared::command::{Profile, Trajectory};

use crate::plant::Model;
use crate::scenario::Scenario;

/// Desired motion at one instant; SI units.
#[derive(Clone, Copy, Debug)]
pub struct Desired {
    /// Positions.
    pub q: [f64; JOINTS],
    /// Speeds.
    pub qd: [f64; JOINTS],
    /// Accelerations.
    pub qdd: [f64; JOINTS],
}

/// Desired tip.
#[derive(Clone, Copy, Debug)]
pub struct Tip {
    /// World axes, m.
    pub position_m: [f64; 3],
    /// Norm of the velocity, m/s.
    pub speed_m_s: f64,
}

/// q_d = q0 + amplitude · s(t / duration).
#[derive(Clone, Debug)]
pub struct Path {
    profile: Profile,
    q0: [f64; JOINTS],
    amplitude: [f64; JOINTS],
    duration_s: f64,
    ticks: u32,
    allow_velocity_step: bool,
    model: Model,
}

impl Path {
    /// The scenario's path.
    pub fn of(scenario: &Scenario) -> Self {
        let t = &scenario.trajectory;
        let ticks = (scenario.duration_s * f64::from(scenario.tick_hz)).round();
        Self {
            profile: t.profile,
            q0: t.q0,
            amplitude: t.amplitude,
            duration_s: ticks / f64::from(scenario.tick_hz),
            ticks: ticks as u32,
            allow_velocity_step: t.allow_velocity_step,
            model: Model::new(&shared::arm::REFERENCE),
        }
    }

    /// Desired motion `t_s` after the start, within the duration.
    pub fn at(&self, t_s: f64) -> Desired {
        let x = (t_s / self.duration_s).min(1.0);
        let (s, ds, dds) = match self.profile {
            Profile::Quintic => (
                x.powi(3) * (10.0 + x * (6.0 * x - 15.0)),
                30.0 * (x * (1.0 - x)).powi(2),
                60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
            ),
            Profile::HalfSine => {
                let (s, c) = (PI * x).sin_cos();
                (s, PI * c, -PI * PI * s)
            }
        };
        let along = |factor: f64| self.amplitude.map(|a| a * factor);
        let start = along(s);
        Desired {
            q: std::array::from_fn(|j| self.q0[j] + start[j]),
            qd: along(ds / self.duration_s),
            qdd: along(dds / self.duration_s.powi(2)),
        }
    }

    /// Tip position and speed of a desired motion.
    pub fn tip(&self, desired: &Desired) -> Tip {
        let (position_m, velocity) = self.model.tip(&desired.q, &desired.qd);
        Tip { position_m, speed_m_s: velocity.map(|v| v * v).iter().sum::<f64>().sqrt() }
    }

    /// The path as a command in encoder counts.
    pub fn command(&self, arm: &Arm) -> Trajectory {
        Trajectory {
            profile: self.profile,
            allow_velocity_step: self.allow_velocity_step,
            speed_limit_percent: 100,
            duration_ticks: self.ticks,
            origin_q6: std::array::from_fn(|j| {
                let encoder = &arm.encoders[j];
                ((self.q0[j] - encoder.zero) / encoder.lsb * 64.0).round() as u32
            }),
            amplitude_q5: std::array::from_fn(|j| {
                (self.amplitude[j] / arm.encoders[j].lsb * 32.0).round() as i32
            }),
        }
    }
}
