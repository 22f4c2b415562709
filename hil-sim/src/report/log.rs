//! log.csv: one row a tick, units in the header names.

use std::path::Path;

use shared::arm::{JOINTS, REFERENCE};

use super::{EFFORT, POSITION, SPEED};
use crate::outcome::{Outcome, TickRow};

/// One column: its header beside the value it holds, so that they cannot drift apart.
struct Column {
    header: String,
    index: usize,
    value: fn(&TickRow, usize) -> f64,
}

pub(super) fn write(path: &Path, outcome: &Outcome) -> std::io::Result<()> {
    let columns = columns();
    let mut file = csv::Writer::from_path(path)?;
    file.write_record(columns.iter().map(|column| &column.header))?;
    for row in &outcome.rows {
        file.write_record(columns.iter().map(|column| cell((column.value)(row, column.index))))?;
    }
    file.flush()
}

fn columns() -> Vec<Column> {
    let mut all = vec![
        one("tick", |r, _| f64::from(r.record.tick)),
        one("phase_ticks", |r, _| f64::from(r.record.phase)),
        one("t_s", |r, _| r.t_s),
        one("mode", |r, _| f64::from(r.record.mode)),
        one("fault", |r, _| f64::from(r.record.fault)),
        one("refusal", |r, _| f64::from(r.record.refusal)),
    ];
    all.extend(truth());
    all.extend(telemetry());
    all
}

/// The plant's own state: what the metrics are taken from.
fn truth() -> impl Iterator<Item = Column> {
    const AXES: [&str; 3] = ["x_m", "y_m", "z_m"];
    let lyapunov = [one("v_lyapunov", |r, _| r.v), one("va_lyapunov", |r, _| r.va)];
    joints("q", POSITION, |r, j| r.q[j])
        .chain(joints("qd", SPEED, |r, j| r.qd[j]))
        .chain(joints("q_desired", POSITION, |r, j| r.q_d[j]))
        .chain(joints("qd_desired", SPEED, |r, j| r.qd_d[j]))
        .chain(each("tip_", AXES, |r, axis| r.tip_m[axis]))
        .chain(each("tip_error_", AXES, |r, axis| r.tip_error_m[axis]))
        .chain(joints("tau", EFFORT, |r, j| r.torque[j]))
        .chain(joints("disturbance", EFFORT, |r, j| r.disturbance[j]))
        .chain(lyapunov)
}

/// What the controller reported in the same tick.
fn telemetry() -> impl Iterator<Item = Column> {
    let counts = ["count"; JOINTS];
    let flags = [
        one("saturated_bits", |r, _| f64::from(r.record.saturated)),
        one("adaptation_bound_bits", |r, _| f64::from(r.record.adaptation_bound)),
        one("rejected_bits", |r, _| f64::from(r.record.rejected)),
        one("dropped_records", |r, _| f64::from(r.record.dropped)),
    ];
    joints("e_controller", POSITION, |r, j| r.record.e1[j].into())
        .chain(joints("qd_controller", SPEED, |r, j| r.record.qd[j].into()))
        .chain(joints("ed_controller", SPEED, |r, j| r.record.e1_dot[j].into()))
        .chain(joints("tau_command", EFFORT, |r, j| REFERENCE.commanded(j, r.record.dac[j])))
        .chain(joints("d_hat", EFFORT, |r, j| r.record.d_hat[j].into()))
        .chain(joints("encoder", counts, |r, j| r.record.code[j].into()))
        .chain(joints("adc", counts, |r, j| r.record.adc[j].into()))
        .chain(flags)
}

fn one(header: &str, value: fn(&TickRow, usize) -> f64) -> Column {
    Column { header: header.into(), index: 0, value }
}

/// One column for each end of a header, numbered by its place.
fn each<const N: usize>(
    start: &str,
    ends: [&str; N],
    value: fn(&TickRow, usize) -> f64,
) -> impl Iterator<Item = Column> {
    let column = move |(index, end)| Column { header: format!("{start}{end}"), index, value };
    ends.into_iter().enumerate().map(column)
}

/// One column a joint, its unit in lower case without blanks: `q1_rad`, `qd4_m_s`, `tau1_nm`.
fn joints(
    name: &str,
    units: [&str; JOINTS],
    value: fn(&TickRow, usize) -> f64,
) -> impl Iterator<Item = Column> {
    let column = move |(index, unit): (usize, &str)| {
        let unit = unit.to_lowercase().replace(' ', "").replace('/', "_");
        Column { header: format!("{name}{}_{unit}", index + 1), index, value }
    };
    units.into_iter().enumerate().map(column)
}

/// Plain digits where they are short, an exponent where they are not.
fn cell(value: f64) -> String {
    if value == 0.0 || (1e-3..1e15).contains(&value.abs()) {
        value.to_string()
    } else {
        format!("{value:e}")
    }
}
