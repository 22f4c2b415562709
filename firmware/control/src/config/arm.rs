//! The arm as the controller believes it to be: lengths and rigid bodies.

use core::slice;

use bytemuck::{Pod, Zeroable};
use shared::arm::{Arm, Inertial, JOINTS, PAYLOAD};

use super::check::Check;
use super::fields::Field;

/// Lengths of the MDH table, m; see [`shared::arm::Geometry`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Geometry {
    /// Row 2, a.
    pub a1_m: f32,
    /// Row 3, a.
    pub a2_m: f32,
    /// Row 4, a.
    pub a3_m: f32,
    /// Row 1', d.
    pub d1_m: f32,
    /// Row 3, d.
    pub d3_m: f32,
}

/// A rigid body in its link's MDH frame; see [`Inertial`].
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Body {
    /// Mass, kg.
    pub mass_kg: f32,
    /// Centre of mass, m.
    pub com_m: [f32; 3],
    /// Tensor entries `[Ixx, Iyy, Izz, Ixy, Ixz, Iyz]` about the centre of mass, kg m².
    pub inertia_com_kg_m2: [f32; 6],
}

/// The arm as the controller believes it to be.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct ArmModel {
    /// MDH lengths.
    pub geometry: Geometry,
    /// Column, boom, forearm, telescope.
    pub links: [Body; JOINTS],
    /// What hangs at the tip, in the telescope's frame.
    pub payload: Body,
    /// Gravity, m/s².
    pub gravity_m_s2: f32,
}

const fn body(b: &Inertial, scale: f32) -> Body {
    let c = b.com_m;
    let i = b.inertia_com_kg_m2;
    Body {
        mass_kg: b.mass_kg as f32 * scale,
        com_m: [c[0] as f32, c[1] as f32, c[2] as f32],
        inertia_com_kg_m2: [
            i[0] as f32 * scale,
            i[1] as f32 * scale,
            i[2] as f32 * scale,
            i[3] as f32 * scale,
            i[4] as f32 * scale,
            i[5] as f32 * scale,
        ],
    }
}

impl Body {
    /// A payload of this mass, shaped like [`PAYLOAD`].
    pub const fn payload(mass_kg: f32) -> Self {
        body(&PAYLOAD, mass_kg / PAYLOAD.mass_kg as f32)
    }
}

impl ArmModel {
    /// The controller's model of `arm`, every mass and inertia times `mass_scale`, carrying `payload_kg`.
    pub const fn new(arm: &Arm, mass_scale: f32, payload_kg: f32) -> Self {
        let g = &arm.geometry;
        let l = &arm.links;
        Self {
            geometry: Geometry {
                a1_m: g.a1_m as f32,
                a2_m: g.a2_m as f32,
                a3_m: g.a3_m as f32,
                d1_m: g.d1_m as f32,
                d3_m: g.d3_m as f32,
            },
            links: [
                body(&l[0], mass_scale),
                body(&l[1], mass_scale),
                body(&l[2], mass_scale),
                body(&l[3], mass_scale),
            ],
            payload: Body::payload(payload_kg),
            gravity_m_s2: shared::arm::GRAVITY_M_S2 as f32,
        }
    }
}

impl ArmModel {
    #[inline(never)]
    pub(super) fn validate(&self, check: &mut Check) {
        const GEOMETRY: Field = Field::named("geometry_m");
        const LINK: Field = Field::named("links.mass_kg");
        const PAYLOAD: Field = Field::named("payload.mass_kg");
        const GRAVITY: Field = Field::named("gravity_m_s2");
        check.group(GEOMETRY, 0, bytemuck::cast_slice(slice::from_ref(&self.geometry)));
        check.group(GRAVITY, 0, &[self.gravity_m_s2.to_bits()]);
        for (i, link) in self.links.iter().enumerate() {
            check.group(LINK, i, bytemuck::cast_slice(slice::from_ref(link)));
        }
        check.group(PAYLOAD, 0, bytemuck::cast_slice(slice::from_ref(&self.payload)));
    }
}
