//! Closed-form dynamics M(q) qdd + C(q, qd) qd + G(q) in `f32`.
//!
//! The arm is a planar three-joint chain on a slewing column. With the absolute angles q2 and
//! w = q2 + q3 its kinetic energy is
//!
//! T = H ω² + ω (P2 u + Pw v + P4 r) + ½ (u, v, r) N (u, v, r)ᵀ,
//!
//! where ω = qd1, u = qd2, v = qd2 + qd3, r = qd4, H is half of M11, P the gradient of the lateral
//! moment Σ m L X (L lateral offset, X radius) and N the planar inertia matrix. Lagrange's equations in
//! these coordinates need H's gradient, P's second derivatives and one planar product; the torques of
//! joints 2 and 3 are Q2 + Qw and Qw. Formulas by this derivation; checked against independent reference
//! vectors and against the simulator's recursive Newton-Euler.

mod collect;

pub use collect::Constants;

use crate::math::sin_cos;
use crate::{JointMatrix, JointVector};

/// Configuration-dependent terms of the dynamics at one pose.
///
/// Names follow the module's documentation; indices 2, w, 4 stand for q2, w and q4.
#[derive(Clone, Copy, Debug)]
pub struct Terms<'a> {
    k: &'a Constants,
    m11: f32,
    h2: f32,
    hw: f32,
    h4: f32,
    p2: f32,
    pw: f32,
    p4: f32,
    p22: f32,
    pww: f32,
    pw4: f32,
    n2w: f32,
    nww: f32,
    n24: f32,
    /// a2 (C2 V - S2 U): what couples boom and forearm by their centrifugal forces.
    centrifugal: f32,
    /// m4 a2 sin q3.
    telescope_lever: f32,
    /// Telescope's first moment along the forearm, kg m.
    telescope_moment: f32,
    g2: f32,
    gw: f32,
    g4: f32,
}

impl Constants {
    /// Evaluates all terms at the pose `q` (rad; q4 in m). The slewing angle does not matter.
    #[inline(always)]
    pub fn at(&self, q: &JointVector) -> Terms<'_> {
        let k = self;
        let q4 = q.w;
        let (s2, c2) = sin_cos(q.y);
        let (sw, cw) = sin_cos(q.y + q.z);

        let my4 = k.tele_y - k.m4 * q4;
        let my = k.fore_y - k.m4 * q4;
        let sxy = k.sxy - k.mx4 * q4;
        let syy = k.syy + q4 * (k.m4 * q4 - k.tele_y2);
        let mly = k.mly - k.ml4 * q4;

        let u = k.mx * cw - my * sw;
        let v = k.mx * sw + my * cw;
        let u4 = k.mx4 * cw - my4 * sw;
        let reach = k.a1 + k.a2 * c2;
        let boom = k.beta * c2 - k.by * s2;
        let boom_slope = k.beta * s2 + k.by * c2;
        let twist = k.half_delta_b * s2 + k.bxy * c2;
        let ux = k.sxx * cw - sxy * sw;
        let uy = sxy * cw - syy * sw;
        let m4_sw = k.m4 * sw;
        let m4_cw = k.m4 * cw;

        let half_w = 0.5 * (cw * ux - sw * uy);
        let h = k.half_j0 + k.a1 * boom - s2 * twist + reach * u + half_w;
        Terms {
            k,
            m11: h + h,
            h2: -(k.a1 * boom_slope
                + c2 * twist
                + s2 * (k.half_delta_b * c2 - k.bxy * s2 + k.a2 * u)),
            hw: -(reach * v + sw * ux + cw * uy),
            h4: sw * (k.m4 * reach + u4),
            p2: -(k.lbeta * s2 + k.ly * c2),
            pw: -(k.mlx * sw + mly * cw),
            p4: k.ml4 * sw,
            p22: k.ly * s2 - k.lbeta * c2,
            pww: mly * sw - k.mlx * cw,
            pw4: k.ml4 * cw,
            n2w: k.a2 * (c2 * u + s2 * v),
            nww: k.sxx + syy,
            n24: -k.a2 * (m4_cw * c2 + m4_sw * s2),
            centrifugal: k.a2 * (c2 * v - s2 * u),
            telescope_lever: k.a2 * (m4_sw * c2 - m4_cw * s2),
            telescope_moment: my4,
            g2: k.gravity * boom,
            gw: k.gravity * u,
            g4: -k.gravity * m4_cw,
        }
    }
}

impl Constants {
    /// M(q) `a` + C(q, qd) qd + G(q), for where it is wanted outside the law.
    #[inline(never)]
    pub fn torque(&self, q: &JointVector, qd: &JointVector, a: &JointVector) -> JointVector {
        let terms = self.at(q);
        terms.inertia_times(a) + terms.coriolis(qd) + terms.gravity()
    }
}

impl Terms<'_> {
    /// M(q) `a`, N m and N for `a` in rad/s² and m/s².
    #[inline(always)]
    pub fn inertia_times(&self, a: &JointVector) -> JointVector {
        let (a1, a2, aw, a4) = (a.x, a.y, a.y + a.z, a.w);
        let k = self.k;
        let t1 = self.m11 * a1 + self.p2 * a2 + self.pw * aw + self.p4 * a4;
        let t2 = self.p2 * a1 + k.n22 * a2 + self.n2w * aw + self.n24 * a4;
        let tw = self.pw * a1 + self.n2w * a2 + self.nww * aw - k.mx4 * a4;
        let t4 = self.p4 * a1 + self.n24 * a2 - k.mx4 * aw + k.m4 * a4;
        JointVector::new(t1, t2 + tw, tw, t4)
    }

    /// C(q, qd) qd, N m and N.
    #[inline(always)]
    pub fn coriolis(&self, qd: &JointVector) -> JointVector {
        let (omega, u, v, r) = (qd.x, qd.y, qd.y + qd.z, qd.w);
        let (omega2, u2, v2, vr2) = (omega * omega, u * u, v * v, 2.0 * v * r);
        let c1 = 2.0 * omega * (self.h2 * u + self.hw * v + self.h4 * r)
            + self.p22 * u2
            + self.pww * v2
            + self.pw4 * vr2;
        let c2 = self.telescope_lever * vr2 - self.centrifugal * v2 - self.h2 * omega2;
        let cw = self.centrifugal * u2 - self.telescope_moment * vr2 - self.hw * omega2;
        let c4 = self.telescope_moment * v2 - self.telescope_lever * u2 - self.h4 * omega2;
        JointVector::new(c1, c2 + cw, cw, c4)
    }

    /// G(q), N m and N.
    #[inline(always)]
    pub fn gravity(&self) -> JointVector {
        JointVector::new(0.0, self.g2 + self.gw, self.gw, self.g4)
    }

    /// M(q), symmetric positive definite, kg m² (row and column 4: kg m and kg).
    #[inline(always)]
    pub fn inertia_matrix(&self) -> JointMatrix {
        let k = self.k;
        let m12 = self.p2 + self.pw;
        let m23 = self.n2w + self.nww;
        let m22 = k.n22 + self.n2w + m23;
        let m24 = self.n24 - k.mx4;
        #[rustfmt::skip]
        let rows = JointMatrix::new(
            self.m11, m12, self.pw, self.p4,
            m12, m22, m23, m24,
            self.pw, m23, self.nww, -k.mx4,
            self.p4, m24, -k.mx4, k.m4,
        );
        rows
    }
}
