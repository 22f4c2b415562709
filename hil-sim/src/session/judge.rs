//! What a run is judged by: the tip's error at each tick of the desired motion.

use shared::arm::JOINTS;
use shared::telemetry::Record;

use crate::metrics::Meter;
use crate::outcome::{Metrics, TickRow};
use crate::path::Path;
use crate::plant::Plant;
use crate::scenario::Scenario;
use crate::truth::Truth;

/// Metrics so far, and rows if they are kept.
pub struct Judge {
    path: Path,
    meter: Meter,
    truth: Option<Truth>,
    rows: Vec<TickRow>,
}

impl Judge {
    /// Of motion along `path`; `keep_rows` asks for one row a tick.
    pub fn new(scenario: &Scenario, path: Path, keep_rows: bool) -> Self {
        Self {
            path,
            meter: Meter::default(),
            truth: keep_rows.then(|| Truth::new(scenario)),
            rows: Vec::new(),
        }
    }

    /// Judges the tick `t_s` after the start, whose drives give `torque`.
    pub fn add(&mut self, t_s: f64, plant: &Plant, torque: &[f64; JOINTS], record: &Record) {
        let desired = self.path.at(t_s);
        let tip = plant.tip().position_m;
        let wanted = self.path.tip(&desired);
        let error = std::array::from_fn(|axis| tip[axis] - wanted.position_m[axis]);
        self.meter.add(&error, wanted.speed_m_s);
        if let Some(truth) = &self.truth {
            let (v, va, disturbance) = truth.at(plant, torque, &desired, record);
            self.rows.push(TickRow {
                t_s,
                q: plant.q(),
                qd: plant.qd(),
                q_d: desired.q,
                qd_d: desired.qd,
                tip_m: tip,
                tip_error_m: error,
                torque: *torque,
                disturbance,
                v,
                va,
                record: *record,
            });
        }
    }

    /// Metrics so far.
    pub fn metrics(&self) -> Metrics {
        self.meter.metrics()
    }

    /// The rows kept.
    pub fn into_rows(self) -> Vec<TickRow> {
        self.rows
    }
}
