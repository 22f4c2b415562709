//! Collects masses, centres of mass and inertia tensors into the constants of the closed form.

use crate::config::{ArmModel, Body};
use bytemuck::{Pod, Zeroable};

/// Constants of the closed form. Moments are about the joint frames, in the plane of the boom.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Constants {
    /// MDH lengths a1 and a2, m.
    pub(super) a1: f32,
    pub(super) a2: f32,
    /// Gravity, m/s².
    pub(super) gravity: f32,
    /// First moments of boom with all it carries at its end, along and across, kg m.
    pub(super) beta: f32,
    pub(super) by: f32,
    /// Half the difference of the boom's second moments along and across, and its product, kg m².
    pub(super) half_delta_b: f32,
    pub(super) bxy: f32,
    /// What of H does not depend on the pose, kg m².
    pub(super) half_j0: f32,
    /// First moments of forearm and telescope at q4 = 0, kg m.
    pub(super) mx: f32,
    pub(super) fore_y: f32,
    /// Second moments of forearm and telescope at q4 = 0, kg m².
    pub(super) sxx: f32,
    pub(super) sxy: f32,
    pub(super) syy: f32,
    /// Telescope: mass, kg; first moments at q4 = 0, kg m; twice the one along the forearm.
    pub(super) m4: f32,
    pub(super) mx4: f32,
    pub(super) tele_y: f32,
    pub(super) tele_y2: f32,
    /// Lateral moments of the boom with all it carries (L X), kg m².
    pub(super) lbeta: f32,
    pub(super) ly: f32,
    /// Lateral moments of forearm and telescope at q4 = 0, kg m²; telescope's own, kg m.
    pub(super) mlx: f32,
    pub(super) mly: f32,
    pub(super) ml4: f32,
    /// Inertia about the boom pin with forearm and telescope as a point at its end, kg m².
    pub(super) n22: f32,
}

/// Moments of a body about the origin of its frame.
struct Moments {
    m: f32,
    /// ∫x, ∫y, ∫z dm.
    first: [f32; 3],
    /// ∫x², ∫y², ∫z² dm.
    square: [f32; 3],
    /// ∫yz, ∫xz, ∫xy dm.
    product: [f32; 3],
}

impl Moments {
    #[inline(never)]
    fn of(body: &Body) -> Self {
        let m = body.mass_kg;
        let [x, y, z] = body.com_m;
        let [ixx, iyy, izz, ixy, ixz, iyz] = body.inertia_com_kg_m2;
        Self {
            m,
            first: [m * x, m * y, m * z],
            square: [
                0.5 * (iyy + izz - ixx) + m * x * x,
                0.5 * (ixx + izz - iyy) + m * y * y,
                0.5 * (ixx + iyy - izz) + m * z * z,
            ],
            product: [m * y * z - iyz, m * x * z - ixz, m * x * y - ixy],
        }
    }

    /// Another body joins this one.
    #[inline(never)]
    fn add(&mut self, other: &Self) {
        self.m += other.m;
        for i in 0..3 {
            self.first[i] += other.first[i];
            self.square[i] += other.square[i];
            self.product[i] += other.product[i];
        }
    }

    /// The origin moves so that every point gains `by`.
    #[inline(never)]
    fn shift(&mut self, by: [f32; 3]) {
        let [x, y, z] = self.first;
        let m = self.m;
        let [dx, dy, dz] = by;
        self.product[0] += y * dz + z * dy + m * dy * dz;
        self.product[1] += x * dz + z * dx + m * dx * dz;
        self.product[2] += x * dy + y * dx + m * dx * dy;
        for ((square, first), by) in self.square.iter_mut().zip(&mut self.first).zip(by) {
            *square += 2.0 * *first * by + m * by * by;
            *first += m * by;
        }
    }

    /// Telescope frame to forearm axes: (x, y, z) -> (-x, -z, -y), from rows 3 and 4 of the MDH table.
    fn turn_to_forearm(&mut self) {
        let [x, y, z] = self.first;
        let [xx, yy, zz] = self.square;
        let [yz, xz, xy] = self.product;
        (self.first, self.square, self.product) = ([-x, -z, -y], [xx, zz, yy], [yz, xy, xz]);
    }
}

impl Constants {
    /// The constants of `arm`.
    pub fn new(arm: &ArmModel) -> Self {
        let mut constants = Self::zeroed();
        constants.collect(arm, &arm.payload);
        constants
    }

    /// Collects the constants of `arm` with this payload in place of its own.
    #[inline(never)]
    pub fn collect(&mut self, arm: &ArmModel, payload: &Body) {
        let g = &arm.geometry;
        let [column, boom, forearm, telescope] = &arm.links;
        let column_izz = {
            let column = Moments::of(column);
            column.square[0] + column.square[1]
        };
        let mut telescope = Moments::of(telescope);
        telescope.add(&Moments::of(payload));
        telescope.turn_to_forearm();
        telescope.shift([g.a3_m, 0.0, g.d3_m]);
        let mut outer = Moments::of(forearm);
        outer.shift([0.0, 0.0, g.d3_m]);
        outer.add(&telescope);
        let boom = Moments::of(boom);

        let beta = boom.first[0] + outer.m * g.a2_m;
        let along = boom.square[0] + outer.m * g.a2_m * g.a2_m;
        let across = boom.square[1];
        let lateral = boom.square[2] + outer.square[2];
        let j0 = column_izz + lateral + (boom.m + outer.m) * g.a1_m * g.a1_m + along;
        *self = Self {
            a1: g.a1_m,
            a2: g.a2_m,
            gravity: arm.gravity_m_s2,
            beta,
            by: boom.first[1],
            half_delta_b: 0.5 * (along - across),
            bxy: boom.product[2],
            half_j0: 0.5 * j0,
            mx: outer.first[0],
            fore_y: outer.first[1],
            sxx: outer.square[0],
            sxy: outer.product[2],
            syy: outer.square[1],
            m4: telescope.m,
            mx4: telescope.first[0],
            tele_y: telescope.first[1],
            tele_y2: 2.0 * telescope.first[1],
            lbeta: boom.product[1] + outer.first[2] * g.a2_m,
            ly: boom.product[0],
            mlx: outer.product[1],
            mly: outer.product[0],
            ml4: telescope.first[2],
            n22: along + across,
        };
    }
}
