//! Upper limits that a scenario sets on a run's metrics.

use crate::outcome::{Adaptation, Law, Metrics};

/// Limits of one controller; what is absent is not judged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Highest mean tip error, m.
    pub rse_m: Option<f64>,
    /// Highest tip error, m.
    pub e_max_m: Option<f64>,
    /// Highest relative error rho = e_max / v_max, s.
    pub rho_s: Option<f64>,
    /// Highest root mean square error along any one axis, m.
    pub rms_m: Option<f64>,
}

/// Limits of each controller that a scenario judges.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Accept {
    /// `[accept.backstepping-inertia]`.
    pub backstepping_inertia: Option<Limits>,
    /// `[accept.backstepping-paper]`.
    pub backstepping_paper: Option<Limits>,
    /// `[accept.backstepping-none]`.
    pub backstepping_none: Option<Limits>,
    /// `[accept.pd]`.
    pub pd: Option<Limits>,
}

impl Accept {
    /// Limits of one controller; the PD has no adaptation, so it is ignored there.
    pub fn of(&self, law: Law, adaptation: Adaptation) -> Option<&Limits> {
        match (law, adaptation) {
            (Law::Pd, _) => self.pd.as_ref(),
            (Law::Backstepping, Adaptation::Inertia) => self.backstepping_inertia.as_ref(),
            (Law::Backstepping, Adaptation::Paper) => self.backstepping_paper.as_ref(),
            (Law::Backstepping, Adaptation::None) => self.backstepping_none.as_ref(),
        }
    }
}

impl Limits {
    /// One sentence for each limit that the metrics break; a metric that is not a number breaks its limit.
    pub fn broken(&self, metrics: &Metrics) -> Vec<String> {
        let [x, y, z] = metrics.rms_m;
        let judged = [
            ("mean tip error (RSE)", metrics.rse_m, self.rse_m, "m"),
            ("highest tip error", metrics.e_max_m, self.e_max_m, "m"),
            ("relative error rho", metrics.rho_s, self.rho_s, "s"),
            ("RMS tip error along x", x, self.rms_m, "m"),
            ("RMS tip error along y", y, self.rms_m, "m"),
            ("RMS tip error along z", z, self.rms_m, "m"),
        ];
        let sentence = |(name, value, limit, unit): (&str, f64, Option<f64>, &str)| {
            let limit = limit?;
            let above = || format!("{value:.3e} {unit} is above its limit of");
            let told = match value.is_nan() {
                true => "could not be measured; its limit is".into(),
                false => (value > limit).then(above)?,
            };
            Some(format!("{name} {told} {limit:.3e} {unit}"))
        };
        judged.into_iter().filter_map(sentence).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: Limits =
        Limits { rse_m: Some(2.7e-7), e_max_m: None, rho_s: Some(1e-3), rms_m: Some(1e-6) };

    #[test]
    fn a_metric_on_its_limit_passes_and_an_absent_limit_is_not_judged() {
        let metrics =
            Metrics { rse_m: 2.7e-7, e_max_m: 9.0, rms_m: [1e-6; 3], ..Metrics::default() };
        assert_eq!(LIMITS.broken(&metrics), Vec::<String>::new());
    }

    #[test]
    fn each_broken_limit_gives_a_sentence_with_both_figures() {
        let metrics = Metrics {
            rse_m: 3.1e-7,
            rho_s: f64::NAN,
            rms_m: [0.0, 2e-6, 0.0],
            ..Metrics::default()
        };
        let expected = [
            "mean tip error (RSE) 3.100e-7 m is above its limit of 2.700e-7 m",
            "relative error rho could not be measured; its limit is 1.000e-3 s",
            "RMS tip error along y 2.000e-6 m is above its limit of 1.000e-6 m",
        ];
        assert_eq!(LIMITS.broken(&metrics), expected);
    }

    #[test]
    fn each_controller_has_its_own_limits() {
        let limits = |rse_m| Some(Limits { rse_m: Some(rse_m), ..Limits::default() });
        let accept = Accept {
            backstepping_inertia: limits(1.0),
            backstepping_paper: limits(2.0),
            backstepping_none: None,
            pd: limits(4.0),
        };
        let rse_m = |law, adaptation| accept.of(law, adaptation).and_then(|limits| limits.rse_m);
        assert_eq!(rse_m(Law::Backstepping, Adaptation::Inertia), Some(1.0));
        assert_eq!(rse_m(Law::Backstepping, Adaptation::Paper), Some(2.0));
        assert_eq!(rse_m(Law::Backstepping, Adaptation::None), None);
        assert_eq!(rse_m(Law::Pd, Adaptation::Inertia), Some(4.0));
        assert_eq!(rse_m(Law::Pd, Adaptation::None), Some(4.0));
    }
}
