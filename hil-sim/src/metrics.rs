//! The four metrics of the paper's Section 4.

use crate::outcome::Metrics;

/// Accumulates the metrics tick by tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct Meter {
    ticks: u32,
    square_sum: [f64; 3],
    norm_sum: f64,
    error_max: f64,
    speed_max: f64,
}

impl Meter {
    /// Adds a tick: tip error (world axes, m) and desired tip speed, m/s.
    pub fn add(&mut self, error_m: &[f64; 3], speed_m_s: f64) {
        let square: [f64; 3] = error_m.map(|e| e * e);
        for (sum, e2) in self.square_sum.iter_mut().zip(square) {
            *sum += e2;
        }
        let norm = square.iter().sum::<f64>().sqrt();
        self.norm_sum += norm;
        self.error_max = self.error_max.max(norm);
        self.speed_max = self.speed_max.max(speed_m_s);
        self.ticks += 1;
    }

    /// The metrics so far; rho only of a tip that was to move.
    pub fn metrics(&self) -> Metrics {
        if self.ticks == 0 {
            return Metrics::NONE;
        }
        let n = f64::from(self.ticks);
        Metrics {
            rms_m: self.square_sum.map(|sum| (sum / n).sqrt()),
            rse_m: self.norm_sum / n,
            rho_s: if self.speed_max > 0.0 { self.error_max / self.speed_max } else { f64::NAN },
            e_max_m: self.error_max,
            v_max_m_s: self.speed_max,
        }
    }
}
