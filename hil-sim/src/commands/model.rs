//! `model`: the firmware's closed form beside the plant's recursion, in one state.

use comfy_table::{CellAlignment, Table, presets};
use firmware::config::Config;
use firmware::dynamics::Constants;
use firmware::{JointVector, kinematics};
use serde::Serialize;
use shared::arm::{JOINTS, REFERENCE};

use crate::cli::ModelArgs;
use crate::plant::Model;

/// One side's answer; SI units, matrices row-major.
#[derive(Serialize)]
struct Side {
    position_m: Vec<f64>,
    rotation: Vec<f64>,
    inertia: Vec<f64>,
    coriolis: Vec<f64>,
    gravity: Vec<f64>,
    torque: Vec<f64>,
}

/// Both sides.
#[derive(Serialize)]
struct Both {
    firmware: Side,
    plant: Side,
}

/// Prints both sides as a table or as JSON.
pub fn model(args: &ModelArgs) -> miette::Result<bool> {
    let both = Both { firmware: firmware_side(args), plant: plant_side(args) };
    if args.json {
        super::print_json(&both)?;
    } else {
        print_side_by_side(&both);
    }
    Ok(true)
}

fn firmware_side(args: &ModelArgs) -> Side {
    let arm = Config::default().arm;
    let joints = |x: &[f64; JOINTS]| JointVector::from_fn(|j, _| x[j] as f32);
    let (q, qd, qdd) = (joints(&args.q), joints(&args.qd), joints(&args.qdd));
    let pose = kinematics::forward(&arm.geometry, &q);
    let constants = Constants::new(&arm);
    let terms = constants.at(&q);
    let (coriolis, gravity) = (terms.coriolis(&qd), terms.gravity());
    let torque = terms.inertia_times(&qdd) + coriolis + gravity;
    let list = |values: &[f32]| values.iter().map(|&v| f64::from(v)).collect();
    Side {
        position_m: list(pose.position_m.as_slice()),
        rotation: list(pose.rotation.transpose().as_slice()),
        inertia: list(terms.inertia_matrix().as_slice()),
        coriolis: list(coriolis.as_slice()),
        gravity: list(gravity.as_slice()),
        torque: list(torque.as_slice()),
    }
}

fn plant_side(args: &ModelArgs) -> Side {
    let ModelArgs { q, qd, qdd, .. } = args;
    let model = Model::new(&REFERENCE);
    let pose = model.forward(q);
    Side {
        position_m: pose.position_m.to_vec(),
        rotation: pose.rotation.concat(),
        inertia: model.mass_matrix(q).concat(),
        coriolis: model.coriolis(q, qd).to_vec(),
        gravity: model.gravity(q).to_vec(),
        torque: model.inverse_dynamics(q, qd, qdd).to_vec(),
    }
}

/// Name, both sides' numbers and what each number is called.
type Row<'a> = (&'a str, &'a [f64], &'a [f64], &'a [&'a str]);

fn print_side_by_side(both: &Both) {
    let mut table = Table::new();
    table.load_style(presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(["", "", "firmware (f32)", "plant (f64)", "difference"]);
    for column in table.column_iter_mut().skip(2) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    let (f, p) = (&both.firmware, &both.plant);
    let rows: [Row<'_>; 6] = [
        ("position, m", &f.position_m, &p.position_m, &["x", "y", "z"]),
        (
            "rotation",
            &f.rotation,
            &p.rotation,
            &["R11", "R12", "R13", "R21", "R22", "R23", "R31", "R32", "R33"],
        ),
        (
            "M",
            &f.inertia,
            &p.inertia,
            &[
                "11", "12", "13", "14", "21", "22", "23", "24", "31", "32", "33", "34", "41", "42",
                "43", "44",
            ],
        ),
        ("C qd, N m and N", &f.coriolis, &p.coriolis, &["1", "2", "3", "4"]),
        ("G, N m and N", &f.gravity, &p.gravity, &["1", "2", "3", "4"]),
        ("torque, N m and N", &f.torque, &p.torque, &["1", "2", "3", "4"]),
    ];
    for (name, firmware, plant, labels) in rows {
        for (i, (label, (a, b))) in labels.iter().zip(firmware.iter().zip(plant)).enumerate() {
            let name = if i == 0 { name } else { "" };
            table.add_row([
                name.to_owned(),
                (*label).to_owned(),
                format!("{a:.6}"),
                format!("{b:.6}"),
                format!("{:.1e}", a - b),
            ]);
        }
    }
    say!("{table}");
}
