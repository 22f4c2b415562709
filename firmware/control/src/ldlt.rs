//! Solution of a symmetric positive definite 4x4 system by a written-out LDLᵀ factorisation: no square
//! root, no pivoting, no loop.

use crate::{JointMatrix, JointVector};

/// Solves M x = b for a symmetric positive definite M, of which the lower triangle is read.
#[inline(always)]
pub fn solve(m: &JointMatrix, b: &JointVector) -> JointVector {
    let d1 = 1.0 / m.m11;
    let l21 = m.m21 * d1;
    let l31 = m.m31 * d1;
    let l41 = m.m41 * d1;

    let a22 = m.m22 - l21 * m.m21;
    let a32 = m.m32 - l31 * m.m21;
    let a42 = m.m42 - l41 * m.m21;
    let a33 = m.m33 - l31 * m.m31;
    let a43 = m.m43 - l41 * m.m31;
    let a44 = m.m44 - l41 * m.m41;

    let d2 = 1.0 / a22;
    let l32 = a32 * d2;
    let l42 = a42 * d2;

    let b33 = a33 - l32 * a32;
    let b43 = a43 - l42 * a32;
    let b44 = a44 - l42 * a42;

    let d3 = 1.0 / b33;
    let l43 = b43 * d3;
    let d4 = 1.0 / (b44 - l43 * b43);

    let y1 = b.x;
    let y2 = b.y - l21 * y1;
    let y3 = b.z - l31 * y1 - l32 * y2;
    let y4 = b.w - l41 * y1 - l42 * y2 - l43 * y3;

    let x4 = y4 * d4;
    let x3 = y3 * d3 - l43 * x4;
    let x2 = y2 * d2 - l32 * x3 - l42 * x4;
    let x1 = y1 * d1 - l21 * x2 - l31 * x3 - l41 * x4;
    JointVector::new(x1, x2, x3, x4)
}
