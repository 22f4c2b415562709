//! Side view of the lift: a few poses and the tip's path in the vertical plane of the boom.
//!
//! X points outward from the slewing axis, Z upward. With w = q2 + q3 (modified DH, Table 1):
//! pivot (a1, d1), elbow pivot + a2 (cos q2, sin q2), tip elbow + a3 (cos w, sin w) + q4 (sin w, -cos w).

use std::ops::Range;

use shared::arm::{JOINTS, REFERENCE};

use super::ReportError;
use super::axis::Axis;
use super::figures::Figure;
use super::plot::{self, Curve, FRAME_PX, PANEL_PX};
use super::style::{POSES, TIP_PATH};
use crate::outcome::Outcome;

type Point = (f64, f64);

/// Length of the forearm's outer box from the elbow, m.
const FOREARM_M: f64 = 2.7;

/// Length of the telescope's inner section, which ends at the tip, m.
const TELESCOPE_M: f64 = 2.8;

/// Room around the arm, m.
const MARGIN_M: f64 = 0.25;

/// The figure for the first run; the others cannot be told apart at this scale.
pub(super) fn figure(outcomes: &[Outcome]) -> Result<Figure, ReportError> {
    let first = &outcomes[0];
    let last = first.rows.len().saturating_sub(1);
    let moments = [0, last / 2, last].map(|tick| first.rows.get(tick));
    let mut curves = Vec::new();
    let mut legend = Vec::new();
    for (row, stroke) in moments.into_iter().flatten().zip(POSES) {
        let [column, boom, forearm, telescope] = parts(&row.q);
        let lines = [(column, 3), (boom, 3), (forearm, 2), (telescope, 1)];
        curves
            .extend(lines.map(|(points, factor)| Curve { stroke: stroke.widened(factor), points }));
        legend.push((format!("arm at {:.1} s", row.t_s), stroke));
    }
    curves.push(Curve {
        stroke: TIP_PATH,
        points: first.rows.iter().map(|row| tip(&row.q)).collect(),
    });
    legend.push(("path of the tip".into(), TIP_PATH));
    let (x, z) = (span(&curves, |point| point.0), span(&curves, |point| point.1));
    let dropped = curves.iter().map(plot::not_finite).sum();
    let title = format!("plane of the boom, {}", first.label());
    let svg = draw(&title, x, z, &curves)?;
    let caption =
        "Column, boom, forearm and telescope, thinner outward. Radius counts from the slewing \
                   axis, height from the base."
            .into();
    Ok(Figure {
        title: "Figure 1. The lift from the side".into(),
        caption,
        legend,
        panels: vec![svg],
        dropped,
    })
}

/// Draws with one metre as long along X as along Z.
fn draw(
    title: &str,
    x: Range<f64>,
    z: Range<f64>,
    curves: &[Curve],
) -> Result<String, ReportError> {
    let inner_px = f64::from(PANEL_PX.0 - FRAME_PX.0);
    let height_px = (inner_px * (z.end - z.start) / (x.end - x.start)).clamp(100.0, 2_000.0);
    let size_px = (PANEL_PX.0, height_px as u32 + FRAME_PX.1);
    let axes = (Axis::over("radius, m", x), Axis::over("height, m", z));
    plot::draw(title, size_px, axes, curves)
        .map_err(|reason| ReportError::Plot { figure: title.into(), reason })
}

/// Column, boom, forearm and telescope as lines.
fn parts(q: &[f64; JOINTS]) -> [Vec<Point>; 4] {
    let g = REFERENCE.geometry;
    let (sin_w, cos_w) = (q[1] + q[2]).sin_cos();
    let elbow = elbow(q);
    let guide = (elbow.0 + g.a3_m * cos_w, elbow.1 + g.a3_m * sin_w);
    let along = |length_m: f64| (guide.0 + length_m * sin_w, guide.1 - length_m * cos_w);
    [
        vec![(0.0, 0.0), (0.0, g.d1_m), (g.a1_m, g.d1_m)],
        vec![(g.a1_m, g.d1_m), elbow],
        vec![elbow, guide, along(FOREARM_M)],
        vec![along(q[3] - TELESCOPE_M), along(q[3])],
    ]
}

fn elbow(q: &[f64; JOINTS]) -> Point {
    let g = REFERENCE.geometry;
    (g.a1_m + g.a2_m * q[1].cos(), g.d1_m + g.a2_m * q[1].sin())
}

fn tip(q: &[f64; JOINTS]) -> Point {
    let (sin_w, cos_w) = (q[1] + q[2]).sin_cos();
    let (x, z) = elbow(q);
    let a3_m = REFERENCE.geometry.a3_m;
    (x + a3_m * cos_w + q[3] * sin_w, z + a3_m * sin_w - q[3] * cos_w)
}

/// The finite coordinates of all curves with a margin, and no less than the base.
fn span(curves: &[Curve], coordinate: fn(&Point) -> f64) -> Range<f64> {
    let points = curves.iter().flat_map(|curve| &curve.points).map(coordinate);
    let range = points
        .filter(|v| v.is_finite())
        .fold(0.0..0.0, |r: Range<f64>, v| r.start.min(v)..r.end.max(v));
    range.start - MARGIN_M..range.end + MARGIN_M
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn telescope_ends_at_the_tip_of_the_world_frame() {
        // Kinematics of Eq 1 at q0: X = 4.00 m and Z = 1.65 m by hand.
        let q = shared::arm::Q0;
        let [.., telescope] = parts(&q);
        let end = telescope[1];
        assert!((end.0 - tip(&q).0).abs() < 1e-12 && (end.1 - tip(&q).1).abs() < 1e-12);
        assert!((end.0 - 3.995).abs() < 0.01 && (end.1 - 1.653).abs() < 0.01, "{end:?}");
    }
}
