//! Reference states of the arm's kinematics and dynamics from Pinocchio.

use serde::Deserialize;

/// `data/vectors.json`.
#[derive(Debug, Deserialize)]
pub struct Vectors {
    /// The parameters that the states were computed with.
    pub inertial_set: InertialSet,
    /// States with everything that follows from them.
    pub states: Vec<State>,
}

/// Parameters, named as in the file; SI units.
#[derive(Debug, Deserialize)]
pub struct InertialSet {
    /// Gravity, m/s².
    pub gravity: f64,
    /// MDH lengths.
    pub kinematics: Kinematics,
    /// Column, boom, forearm, telescope.
    pub links: [Part; 4],
    /// Payload in the telescope's frame.
    pub payload: Part,
}

/// MDH lengths, m.
#[derive(Debug, Deserialize)]
pub struct Kinematics {
    /// Boom pin from the slewing axis.
    pub a1: f64,
    /// Boom length.
    pub a2: f64,
    /// Telescope from the forearm pin.
    pub a3: f64,
    /// Height of the boom pin.
    pub d1: f64,
    /// Lateral offset of the forearm.
    pub d3: f64,
}

/// One rigid body in its link's MDH frame.
#[derive(Debug, Deserialize)]
pub struct Part {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of mass, m.
    pub com: [f64; 3],
    /// Inertia tensor about the centre of mass, `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]`, kg m².
    pub inertia_com: [f64; 6],
}

/// One state; rad and m, N m and N.
#[derive(Debug, Deserialize)]
pub struct State {
    /// Joint positions.
    pub q: [f64; 4],
    /// Joint speeds.
    pub qd: [f64; 4],
    /// Joint accelerations.
    pub qdd: [f64; 4],
    /// Tip position, world axes.
    #[serde(rename = "pos")]
    pub position_m: [f64; 3],
    /// Rotation of the telescope's frame, row-major.
    #[serde(rename = "rot_row_major")]
    pub rotation: [f64; 9],
    /// Jacobian at the tip, row-major: linear x, y, z, then angular x, y, z, world axes.
    #[serde(rename = "jac_6x4_world_rows_lin_ang")]
    pub jacobian: [f64; 24],
    /// Mass matrix, row-major.
    #[serde(rename = "M_row_major")]
    pub mass: [f64; 16],
    /// C(q, qd) qd.
    #[serde(rename = "Cqd")]
    pub coriolis: [f64; 4],
    /// G(q).
    #[serde(rename = "G")]
    pub gravity: [f64; 4],
    /// Torque that gives qdd.
    #[serde(rename = "tau")]
    pub torque: [f64; 4],
}

/// Reads the reference states.
pub fn load() -> Vectors {
    serde_json::from_str(include_str!("../data/vectors.json")).expect("vectors.json is well formed")
}
