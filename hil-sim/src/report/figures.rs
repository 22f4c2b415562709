//! The figures over time: the paper's Figures 2 to 5 and what its text argues with.

use shared::arm::JOINTS;

use super::axis::Axis;
use super::plot::{self, Curve, PANEL_PX};
use super::style::{LIMIT, REFERENCE, Stroke, controller};
use super::{EFFORT, POSITION, ReportError, SPEED, arm_view};
use crate::outcome::{Adaptation, Law, Outcome, TickRow};

/// Drawn panels with what a reader needs beside them.
pub(super) struct Figure {
    pub title: String,
    pub caption: String,
    pub legend: Vec<(String, Stroke)>,
    /// SVG drawings.
    pub panels: Vec<String>,
    /// Samples left out because they are not finite.
    pub dropped: usize,
}

/// What a panel shows; its axes follow from the curves.
struct Panel {
    title: String,
    quantity: &'static str,
    unit: &'static str,
    y_axis: YAxis,
    curves: Vec<Curve>,
}

#[derive(Clone, Copy)]
enum YAxis {
    Linear,
    Log,
}

/// A number of one tick for joint or axis `usize`.
type Value = fn(&TickRow, usize) -> f64;

/// Every figure of the page in its order.
pub(super) fn all(outcomes: &[Outcome]) -> Result<Vec<Figure>, ReportError> {
    Ok(vec![
        arm_view::figure(outcomes)?,
        errors(outcomes, "2. Position errors", "q − q_d", POSITION, |r, j| r.q[j] - r.q_d[j])?,
        tracking(
            outcomes,
            "3. Position tracking",
            "position",
            POSITION,
            |r, j| r.q[j],
            |r, j| r.q_d[j],
        )?,
        errors(outcomes, "4. Velocity errors", "q̇ − q̇_d", SPEED, |r, j| r.qd[j] - r.qd_d[j])?,
        tracking(
            outcomes,
            "5. Velocity tracking",
            "velocity",
            SPEED,
            |r, j| r.qd[j],
            |r, j| r.qd_d[j],
        )?,
        tip_error(outcomes)?,
        torques(outcomes)?,
        disturbances(outcomes)?,
        lyapunov(outcomes)?,
    ])
}

fn errors(
    outcomes: &[Outcome],
    title: &str,
    quantity: &'static str,
    units: [&'static str; JOINTS],
    error: Value,
) -> Result<Figure, ReportError> {
    let panels = by_joint(quantity, units, |j| runs(outcomes, j, error));
    let caption = "True plant state less the desired one.".into();
    drawn(title, caption, legend(outcomes, None), panels)
}

fn tracking(
    outcomes: &[Outcome],
    title: &str,
    quantity: &'static str,
    units: [&'static str; JOINTS],
    actual: Value,
    desired: Value,
) -> Result<Figure, ReportError> {
    let panels = by_joint(quantity, units, |j| {
        let mut curves = vec![curve(&outcomes[0], j, desired, REFERENCE)];
        curves.extend(runs(outcomes, j, actual));
        curves
    });
    let caption = "True plant state over the desired one.".into();
    drawn(title, caption, legend(outcomes, Some(("desired", REFERENCE))), panels)
}

fn tip_error(outcomes: &[Outcome]) -> Result<Figure, ReportError> {
    let norm = Panel {
        title: "norm".into(),
        quantity: "error",
        unit: "m",
        y_axis: YAxis::Log,
        curves: runs(outcomes, 0, |r, _| r.tip_error_m.iter().map(|e| e * e).sum::<f64>().sqrt()),
    };
    let axes = ["x", "y", "z"].into_iter().enumerate().map(|(axis, name)| Panel {
        title: format!("along {name}"),
        quantity: "error",
        unit: "m",
        y_axis: YAxis::Linear,
        curves: runs(outcomes, axis, |r, axis| r.tip_error_m[axis]),
    });
    let caption = "Tip position less the desired one in world axes: what Table 3 is taken from. \
                   Zero lies on the lower edge of the logarithmic axis."
        .into();
    let panels = [norm].into_iter().chain(axes).collect();
    drawn("6. End-point error", caption, legend(outcomes, None), panels)
}

fn torques(outcomes: &[Outcome]) -> Result<Figure, ReportError> {
    let limit = outcomes[0].torque_limit;
    let panels = by_joint("effort", EFFORT, |j| {
        let line = |level: f64| Curve {
            stroke: LIMIT,
            points: outcomes[0].rows.iter().map(|row| (row.t_s, level)).collect(),
        };
        let mut curves = vec![line(limit[j]), line(-limit[j])];
        curves.extend(runs(outcomes, j, |r, j| r.torque[j]));
        curves
    });
    let caption = format!(
        "Torque and force that the drives apply. Highest share of the limit, joints 1 to 4: {}.",
        [0, 1, 2, 3].map(|j| format!("{:.1} %", 100.0 * peak(outcomes, j) / limit[j])).join(", "),
    );
    drawn("7. Joint torques", caption, legend(outcomes, Some(("limit", LIMIT))), panels)
}

/// Highest torque of a joint in any run, N m or N.
fn peak(outcomes: &[Outcome], joint: usize) -> f64 {
    let rows = outcomes.iter().flat_map(|outcome| &outcome.rows);
    rows.map(|row| row.torque[joint].abs()).fold(0.0, f64::max)
}

fn disturbances(outcomes: &[Outcome]) -> Result<Figure, ReportError> {
    let adapts = |o: &Outcome| o.law == Law::Backstepping && o.adaptation != Adaptation::None;
    let panels = by_joint("effort", EFFORT, |j| {
        let truth = outcomes.iter().map(|o| curve(o, j, |r, j| r.disturbance[j], REFERENCE));
        let adapting = outcomes.iter().filter(|o| adapts(o));
        let estimates =
            adapting.map(|o| curve(o, j, |r, j| r.record.d_hat[j].into(), controller(o)));
        truth.chain(estimates).collect()
    });
    let mut names = vec![("true disturbance d of each run".into(), REFERENCE)];
    let adapting = outcomes.iter().filter(|o| adapts(o));
    names.extend(adapting.map(|o| (format!("d̂, {}", o.label()), controller(o))));
    let caption = "Laws that do not adapt have no estimate.".into();
    drawn("8. Disturbance and its estimate", caption, names, panels)
}

fn lyapunov(outcomes: &[Outcome]) -> Result<Figure, ReportError> {
    let panel = |title: &str, quantity, value: Value| Panel {
        title: title.into(),
        quantity,
        unit: "(rad² + m²)/s²",
        y_axis: YAxis::Log,
        curves: runs(outcomes, 0, value),
    };
    let panels = vec![
        panel("V = zᵀz / 2 (Eq 21)", "V", |r, _| r.v),
        panel("Va, with the estimate's error (Eq 25)", "Va", |r, _| r.va),
    ];
    let caption =
        "With a disturbance that moves, theory promises that Va stays bounded, not that it \
                   falls. Where nothing adapts Va is V."
            .into();
    drawn("9. Lyapunov function", caption, legend(outcomes, None), panels)
}

fn by_joint(
    quantity: &'static str,
    units: [&'static str; JOINTS],
    curves: impl Fn(usize) -> Vec<Curve>,
) -> Vec<Panel> {
    const NAMES: [&str; JOINTS] = ["column", "boom", "forearm", "telescope"];
    let panel = |(j, (name, unit))| Panel {
        title: format!("joint {} ({name})", j + 1),
        quantity,
        unit,
        y_axis: YAxis::Linear,
        curves: curves(j),
    };
    NAMES.into_iter().zip(units).enumerate().map(panel).collect()
}

/// One curve a run.
fn runs(outcomes: &[Outcome], index: usize, value: Value) -> Vec<Curve> {
    outcomes.iter().map(|outcome| curve(outcome, index, value, controller(outcome))).collect()
}

fn curve(outcome: &Outcome, index: usize, value: Value, stroke: Stroke) -> Curve {
    let points = outcome.rows.iter().map(|row| (row.t_s, value(row, index))).collect();
    Curve { stroke, points }
}

fn legend(outcomes: &[Outcome], more: Option<(&str, Stroke)>) -> Vec<(String, Stroke)> {
    let runs = outcomes.iter().map(|outcome| (outcome.label().into(), controller(outcome)));
    runs.chain(more.map(|(name, stroke)| (name.into(), stroke))).collect()
}

fn drawn(
    title: &str,
    caption: String,
    legend: Vec<(String, Stroke)>,
    panels: Vec<Panel>,
) -> Result<Figure, ReportError> {
    let dropped = panels.iter().flat_map(|panel| &panel.curves).map(plot::not_finite).sum();
    let svgs = panels.iter().map(|panel| {
        let times = panel.curves.iter().flat_map(|c| &c.points).map(|point| point.0);
        let values = panel.curves.iter().flat_map(|c| &c.points).map(|point| point.1);
        let x = Axis::over("time, s", 0.0..times.fold(0.0, f64::max).max(1e-3));
        let y = match panel.y_axis {
            YAxis::Linear => Axis::linear(panel.quantity, panel.unit, values),
            YAxis::Log => Axis::log(panel.quantity, panel.unit, values),
        };
        plot::draw(&panel.title, PANEL_PX, (x, y), &panel.curves)
            .map_err(|reason| ReportError::Plot { figure: title.into(), reason })
    });
    Ok(Figure {
        title: format!("Figure {title}"),
        caption,
        legend,
        panels: svgs.collect::<Result<_, _>>()?,
        dropped,
    })
}
