//! Linear equations with the mass matrix.

use super::{Joints, Matrix};

/// M = L D Lᵀ of a symmetric positive definite matrix.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ldlt {
    l10: f64,
    l20: f64,
    l21: f64,
    l30: f64,
    l31: f64,
    l32: f64,
    d_inverse: Joints,
}

impl Ldlt {
    /// Reads the lower triangle.
    pub fn new(m: &Matrix) -> Self {
        let r0 = 1.0 / m[0][0];
        let (l10, l20, l30) = (m[1][0] * r0, m[2][0] * r0, m[3][0] * r0);
        let r1 = 1.0 / (m[1][1] - l10 * m[1][0]);
        let (u21, u31) = (m[2][1] - l20 * m[1][0], m[3][1] - l30 * m[1][0]);
        let (l21, l31) = (u21 * r1, u31 * r1);
        let r2 = 1.0 / (m[2][2] - l20 * m[2][0] - l21 * u21);
        let u32 = m[3][2] - l30 * m[2][0] - l31 * u21;
        let l32 = u32 * r2;
        let r3 = 1.0 / (m[3][3] - l30 * m[3][0] - l31 * u31 - l32 * u32);
        Self { l10, l20, l21, l30, l31, l32, d_inverse: [r0, r1, r2, r3] }
    }

    /// M⁻¹ b.
    pub fn solve(&self, b: &Joints) -> Joints {
        let y0 = b[0];
        let y1 = b[1] - self.l10 * y0;
        let y2 = b[2] - self.l20 * y0 - self.l21 * y1;
        let y3 = b[3] - self.l30 * y0 - self.l31 * y1 - self.l32 * y2;
        let d = &self.d_inverse;
        let x3 = y3 * d[3];
        let x2 = y2 * d[2] - self.l32 * x3;
        let x1 = y1 * d[1] - self.l21 * x2 - self.l31 * x3;
        let x0 = y0 * d[0] - self.l10 * x1 - self.l20 * x2 - self.l30 * x3;
        [x0, x1, x2, x3]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solution_satisfies_the_equations() {
        let m = [
            [9.0, 1.0, -2.0, 0.5],
            [1.0, 7.0, 3.0, -1.5],
            [-2.0, 3.0, 11.0, 2.5],
            [0.5, -1.5, 2.5, 4.0],
        ];
        let b = [1.0, -2.0, 3.0, -4.0];
        let x = Ldlt::new(&m).solve(&b);
        for (row, b) in m.iter().zip(b) {
            let product: f64 = row.iter().zip(x).map(|(m, x)| m * x).sum();
            assert!((product - b).abs() < 1e-14, "{product} is not {b}");
        }
    }
}
