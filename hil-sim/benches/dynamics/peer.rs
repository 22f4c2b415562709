//! The arm in `dynibo`, a general rigid-body library, and proof that it is the same arm.

use std::f64::consts::{FRAC_PI_2, PI};
use std::fmt::Write as _;
use std::io::Write as _;

use dynibo::Robot;
use firmware::dynamics::Constants;
use serde::Deserialize;
use shared::arm::{Arm, JOINTS};
use tempfile::NamedTempFile;

use crate::samples::Samples;

/// Gravity of `dynibo`, which has no setting for it, m/s².
pub const GRAVITY_M_S2: f64 = 9.80665;

/// Largest error of `dynibo` against the reference, of the largest number in the row.
const EXACT: f64 = 1e-9;
/// Largest error of the firmware's `f32` against `dynibo`, of the largest number in the row.
const SINGLE: f64 = 4e-6;

/// The library's robot with room for its results.
pub struct Peer {
    robot: Robot,
    /// M(q), kg m² (row and column 4: kg m and kg).
    pub mass: [f64; JOINTS * JOINTS],
    /// C(q, qd) qd + G(q), N m and N.
    pub bias: [f64; JOINTS],
}

/// The part of a reference state that is compared.
#[derive(Deserialize)]
struct Reference {
    q: [f64; JOINTS],
    qd: [f64; JOINTS],
    #[serde(rename = "M_row_major")]
    mass: [f64; JOINTS * JOINTS],
    #[serde(rename = "Cqd")]
    coriolis: [f64; JOINTS],
    #[serde(rename = "G")]
    gravity: [f64; JOINTS],
}

#[derive(Deserialize)]
struct References {
    inertial_set: InertialSet,
    states: Vec<Reference>,
}

#[derive(Deserialize)]
struct InertialSet {
    gravity: f64,
}

impl Peer {
    /// Loads the arm without a payload.
    pub fn new(arm: &Arm) -> Self {
        let mut file = NamedTempFile::new().expect("a temporary file can be made");
        file.write_all(urdf(arm).as_bytes()).expect("a temporary file can be written");
        let robot = Robot::from_urdf(file.path()).expect("dynibo takes the arm");
        Self { robot, mass: [0.0; JOINTS * JOINTS], bias: [0.0; JOINTS] }
    }

    /// M, and C qd + G, by the library's two cheapest calls: with no acceleration its inverse dynamics
    /// are the bias, Coriolis and gravity in one pass.
    pub fn compute(&mut self, q: &[f64; JOINTS], qd: &[f64; JOINTS]) {
        let rest = [0.0; JOINTS];
        self.robot.mass_matrix(q, &mut self.mass).expect("finite");
        self.robot.inverse_dynamics(q, qd, &rest, &[], &mut self.bias).expect("finite");
    }

    /// Refuses to go on unless M, C qd and G are those of the reference data.
    pub fn must_agree_with_reference(&mut self) {
        let text = include_str!("../../../tests/data/vectors.json");
        let references: References = serde_json::from_str(text).expect("the file is well formed");
        let more_gravity = references.inertial_set.gravity / GRAVITY_M_S2 - 1.0;
        let mut gravity = [0.0; JOINTS];
        for want in references.states {
            self.compute(&want.q, &want.qd);
            self.robot.gravity(&want.q, &[], &mut gravity).expect("finite");
            let bias = add(self.bias, gravity.map(|g| g * more_gravity));
            close("M", &self.mass, &want.mass, EXACT);
            close("C qd + G", &bias, &add(want.coriolis, want.gravity), EXACT);
        }
    }

    /// Refuses to go on unless the closed form computes the same for all samples.
    pub fn must_agree_with(&mut self, constants: &Constants, samples: &Samples) {
        for (exact, state) in samples.exact.iter().zip(&samples.firmware) {
            self.compute(&exact.q, &exact.qd);
            let terms = constants.at(&state.q);
            let mass = Vec::from_iter(terms.inertia_matrix().iter().map(|&m| f64::from(m)));
            let bias = terms.coriolis(&state.qd) + terms.gravity();
            close("M", &mass, &self.mass, SINGLE);
            close("C qd + G", bias.map(f64::from).as_slice(), &self.bias, SINGLE);
        }
    }
}

fn add(a: [f64; JOINTS], b: [f64; JOINTS]) -> [f64; JOINTS] {
    core::array::from_fn(|j| a[j] + b[j])
}

fn close(name: &str, got: &[f64], want: &[f64], tolerance: f64) {
    let scale = want.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    for (got, want) in got.iter().zip(want) {
        assert!((got - want).abs() <= tolerance * scale, "{name}: {got} against {want}");
    }
}

/// The modified Denavit-Hartenberg table as joint origins; every joint moves about or along its z axis.
fn urdf(arm: &Arm) -> String {
    let g = &arm.geometry;
    let joints = [
        ("continuous", [0.0; 3], [0.0; 3]),
        ("continuous", [0.0, g.a1_m, g.d1_m], [FRAC_PI_2, 0.0, FRAC_PI_2]),
        ("continuous", [g.a2_m, 0.0, g.d3_m], [0.0; 3]),
        // Rx(pi/2) Rz(pi) is Rz(pi) Rx(-pi/2), the order that roll, pitch and yaw have.
        ("prismatic", [g.a3_m, 0.0, 0.0], [-FRAC_PI_2, 0.0, PI]),
    ];
    let mut text = String::from("<robot name=\"arm\"><link name=\"l0\"/>");
    for (j, ((kind, xyz, rpy), link)) in joints.iter().zip(&arm.links).enumerate() {
        let child = j + 1;
        let ([cx, cy, cz], m) = (link.com_m, link.mass_kg);
        let [xx, yy, zz, xy, xz, yz] = link.inertia_com_kg_m2;
        let ([x, y, z], [roll, pitch, yaw]) = (xyz, rpy);
        write!(
            text,
            "<link name=\"l{child}\"><inertial><origin xyz=\"{cx} {cy} {cz}\"/><mass value=\"{m}\"/>\
             <inertia ixx=\"{xx}\" iyy=\"{yy}\" izz=\"{zz}\" ixy=\"{xy}\" ixz=\"{xz}\" iyz=\"{yz}\"/>\
             </inertial></link><joint name=\"j{child}\" type=\"{kind}\"><parent link=\"l{j}\"/>\
             <child link=\"l{child}\"/><origin xyz=\"{x} {y} {z}\" rpy=\"{roll} {pitch} {yaw}\"/>\
             <axis xyz=\"0 0 1\"/><limit lower=\"0\" upper=\"9\" effort=\"0\" velocity=\"9\"/></joint>"
        )
        .expect("a string takes text");
    }
    text + "</robot>"
}
