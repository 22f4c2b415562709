//! A second route to the arm's energy: textbook transforms of the printed table and geometric Jacobians.

use core::f64::consts::{FRAC_PI_2, PI};

use shared::arm::{Arm, GRAVITY_M_S2, Inertial, PAYLOAD};

type Joints = [f64; 4];
type Transform = [[f64; 4]; 3];

/// Parent-to-link transform of one row of the modified Denavit-Hartenberg table, multiplied on.
fn then_row(t: Transform, theta: f64, d: f64, a: f64, alpha: f64) -> Transform {
    let ((st, ct), (sa, ca)) = (theta.sin_cos(), alpha.sin_cos());
    let row = [
        [ct, -st, 0.0, a],
        [st * ca, ct * ca, -sa, -d * sa],
        [st * sa, ct * sa, ca, d * ca],
        [0.0, 0.0, 0.0, 1.0],
    ];
    t.map(|left| core::array::from_fn(|j| (0..4).map(|i| left[i] * row[i][j]).sum()))
}

/// World transforms of the four link frames from the printed table.
fn frames(arm: &Arm, q: &Joints) -> [Transform; 4] {
    let g = &arm.geometry;
    let world = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let column = then_row(world, q[0], 0.0, 0.0, 0.0);
    let turned = then_row(column, FRAC_PI_2, g.d1_m, 0.0, 0.0);
    let boom = then_row(turned, q[1], 0.0, g.a1_m, FRAC_PI_2);
    let forearm = then_row(boom, q[2], g.d3_m, g.a2_m, 0.0);
    [column, boom, forearm, then_row(forearm, PI, q[3], g.a3_m, FRAC_PI_2)]
}

fn point(t: &Transform, p: [f64; 3]) -> [f64; 3] {
    t.map(|row| row[0] * p[0] + row[1] * p[1] + row[2] * p[2] + row[3])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Kinetic energy of the motion in joint space, link by link: m v²/2 + w^T R I R^T w / 2 with v and w from
/// geometric Jacobians; and potential energy from the heights of the centres of mass.
///
/// Joint states as everywhere (rad, m, rad/s, m/s); result in J.
pub fn energy(arm: &Arm, payload_kg: f64, q: &Joints, qd: &Joints) -> (f64, f64) {
    let frames = frames(arm, q);
    let (mut kinetic, mut potential) = (0.0, 0.0);
    for (link, part) in parts(arm, payload_kg) {
        let com_m = point(&frames[link], part.com_m);
        let (mut v, mut w) = ([0.0; 3], [0.0; 3]);
        for j in 0..=link {
            let axis = frames[j].map(|row| row[2]);
            let lever = core::array::from_fn(|i| com_m[i] - frames[j][i][3]);
            let swing = if j == 3 { axis } else { cross(axis, lever) };
            for i in 0..3 {
                v[i] += swing[i] * qd[j];
                w[i] += if j == 3 { 0.0 } else { axis[i] * qd[j] };
            }
        }
        let local: [f64; 3] =
            core::array::from_fn(|k| (0..3).map(|i| frames[link][i][k] * w[i]).sum());
        let [ixx, iyy, izz, ixy, ixz, iyz] = part.inertia_com_kg_m2;
        let [x, y, z] = local;
        kinetic += 0.5 * part.mass_kg * v.iter().map(|v| v * v).sum::<f64>()
            + 0.5 * (ixx * x * x + iyy * y * y + izz * z * z)
            + (ixy * x * y + ixz * x * z + iyz * y * z);
        potential += part.mass_kg * GRAVITY_M_S2 * com_m[2];
    }
    (kinetic, potential)
}

/// Every rigid body with the link that carries it.
fn parts(arm: &Arm, payload_kg: f64) -> impl Iterator<Item = (usize, Inertial)> {
    let k = payload_kg / PAYLOAD.mass_kg;
    let payload = Inertial {
        mass_kg: payload_kg,
        com_m: PAYLOAD.com_m,
        inertia_com_kg_m2: PAYLOAD.inertia_com_kg_m2.map(|i| k * i),
    };
    arm.links.into_iter().enumerate().chain([(3, payload)])
}
