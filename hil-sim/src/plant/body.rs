//! Rigid bodies by their moments about a frame's origin, so that they add and move without a centre of mass.

use shared::arm::Inertial;

use super::chain::{Frame, TELESCOPE};
use super::{Vector, add, cross, dot, scale};

/// Symmetric matrix of second moments, ∫ r rᵀ dm, kg m². The inertia tensor is its trace times 1 less itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Second {
    pub xx: f64,
    pub yy: f64,
    pub zz: f64,
    pub xy: f64,
    pub xz: f64,
    pub yz: f64,
}

impl Second {
    fn plus(&self, b: &Self) -> Self {
        Self {
            xx: self.xx + b.xx,
            yy: self.yy + b.yy,
            zz: self.zz + b.zz,
            xy: self.xy + b.xy,
            xz: self.xz + b.xz,
            yz: self.yz + b.yz,
        }
    }

    /// a bᵀ + b aᵀ.
    fn outer(a: Vector, b: Vector) -> Self {
        Self {
            xx: 2.0 * a[0] * b[0],
            yy: 2.0 * a[1] * b[1],
            zz: 2.0 * a[2] * b[2],
            xy: a[0] * b[1] + a[1] * b[0],
            xz: a[0] * b[2] + a[2] * b[0],
            yz: a[1] * b[2] + a[2] * b[1],
        }
    }

    fn rows(&self) -> [Vector; 3] {
        [[self.xx, self.xy, self.xz], [self.xy, self.yy, self.yz], [self.xz, self.yz, self.zz]]
    }
}

/// Force and moment about a frame's origin, N and N m.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wrench {
    force_n: Vector,
    moment_nm: Vector,
}

impl Wrench {
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            force_n: add(self.force_n, other.force_n),
            moment_nm: add(self.moment_nm, other.moment_nm),
        }
    }

    /// The same wrench in the parent's axes about the parent's origin.
    pub fn to_parent<const J: usize>(self, frame: &Frame<J>) -> Self {
        let force_n = frame.rotate(self.force_n);
        let moment_nm = add(frame.rotate(self.moment_nm), cross(frame.origin_m, force_n));
        Self { force_n, moment_nm }
    }

    /// What joint `J` has to supply: the moment about z, of the prismatic one the force along z.
    pub fn effort<const J: usize>(&self) -> f64 {
        if J == TELESCOPE { self.force_n[2] } else { self.moment_nm[2] }
    }
}

/// Motion of a link frame in its own axes; gravity is an upward acceleration of the base.
#[derive(Clone, Copy, Debug)]
pub(super) struct Motion {
    pub rate_rad_s: Vector,
    pub rate_dot_rad_s2: Vector,
    pub acceleration_m_s2: Vector,
}

impl Motion {
    /// Matrix B of rigid motion: a point fixed at r accelerates by B r more than the origin;
    /// B = [w']x + [w]x[w]x.
    pub fn field(&self) -> [Vector; 3] {
        let [x, y, z] = self.rate_rad_s;
        let [xd, yd, zd] = self.rate_dot_rad_s2;
        let (xx, yy, zz, xy, xz, yz) = (x * x, y * y, z * z, x * y, x * z, y * z);
        [[-yy - zz, xy - zd, xz + yd], [xy + zd, -xx - zz, yz - xd], [xz - yd, yz + xd, -xx - yy]]
    }
}

/// Mass, first and second moments of a rigid body about the origin of its frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Body {
    pub mass_kg: f64,
    first_kg_m: Vector,
    second: Second,
}

impl Body {
    pub fn new(part: &Inertial) -> Self {
        let [ixx, iyy, izz, ixy, ixz, iyz] = part.inertia_com_kg_m2;
        let half = 0.5 * (ixx + iyy + izz);
        let about_com =
            Second { xx: half - ixx, yy: half - iyy, zz: half - izz, xy: -ixy, xz: -ixz, yz: -iyz };
        let first_kg_m = scale(part.mass_kg, part.com_m);
        let steiner = Second::outer(scale(0.5, first_kg_m), part.com_m);
        Self { mass_kg: part.mass_kg, first_kg_m, second: about_com.plus(&steiner) }
    }

    /// Both bodies as one.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            mass_kg: self.mass_kg + other.mass_kg,
            first_kg_m: add(self.first_kg_m, other.first_kg_m),
            second: self.second.plus(&other.second),
        }
    }

    /// The same shape with `k` times the density.
    pub fn scaled(&self, k: f64) -> Self {
        let s = &self.second;
        Self {
            mass_kg: k * self.mass_kg,
            first_kg_m: scale(k, self.first_kg_m),
            second: Second {
                xx: k * s.xx,
                yy: k * s.yy,
                zz: k * s.zz,
                xy: k * s.xy,
                xz: k * s.xz,
                yz: k * s.yz,
            },
        }
    }

    /// The same body about the parent's origin.
    pub fn to_parent<const J: usize>(self, frame: &Frame<J>) -> Self {
        let turned_kg_m = frame.rotate(self.first_kg_m);
        let shift_kg_m = scale(self.mass_kg, frame.origin_m);
        let lever_kg_m = add(turned_kg_m, scale(0.5, shift_kg_m));
        Self {
            mass_kg: self.mass_kg,
            first_kg_m: add(turned_kg_m, shift_kg_m),
            second: frame
                .rotate_second(&self.second)
                .plus(&Second::outer(frame.origin_m, lever_kg_m)),
        }
    }

    /// Wrench that gives the body this motion; `field` is [`Motion::field`].
    pub fn wrench(&self, motion: &Motion, field: &[Vector; 3]) -> Wrench {
        let h = self.first_kg_m;
        let s = self.second.rows();
        let inertial = scale(self.mass_kg, motion.acceleration_m_s2);
        let turning = [
            dot(field[2], s[1]) - dot(field[1], s[2]),
            dot(field[0], s[2]) - dot(field[2], s[0]),
            dot(field[1], s[0]) - dot(field[0], s[1]),
        ];
        Wrench {
            force_n: add(inertial, field.map(|row| dot(row, h))),
            moment_nm: add(turning, cross(h, motion.acceleration_m_s2)),
        }
    }

    /// Wrench that gives the body, at rest, a unit acceleration of joint `J`.
    pub fn unit_wrench<const J: usize>(&self) -> Wrench {
        let [x, y, _] = self.first_kg_m;
        let s = &self.second;
        if J == TELESCOPE {
            Wrench { force_n: [0.0, 0.0, self.mass_kg], moment_nm: [y, -x, 0.0] }
        } else {
            Wrench { force_n: [-y, x, 0.0], moment_nm: [-s.xz, -s.yz, s.xx + s.yy] }
        }
    }
}
