//! One panel of a figure as an SVG drawing.

use plotters::prelude::*;

use super::axis::Axis;
use super::style::Stroke;

/// A curve, as many samples as the run has; drawing thins it.
pub(super) struct Curve {
    pub stroke: Stroke,
    pub points: Vec<(f64, f64)>,
}

/// Size of a panel in SVG units; a page shows it at half to two thirds of that.
pub(super) const PANEL_PX: (u32, u32) = (800, 480);

/// Each curve is thinned to the lowest and the highest sample of this many stretches.
const STRETCHES: usize = 500;

const TEXT_PX: f64 = 27.0;
const AXIS_COLOR: RGBColor = RGBColor(0x44, 0x44, 0x44);
const GRID_COLOR: RGBColor = RGBColor(0xE3, 0xE3, 0xE3);
const LEFT_PX: u32 = 120;
const BOTTOM_PX: u32 = 68;
const TITLE_PX: u32 = 40;
const MARGIN_PX: u32 = 16;

/// Pixels that axis labels, title and margins take from a drawing's width and height.
pub(super) const FRAME_PX: (u32, u32) =
    (LEFT_PX + 2 * MARGIN_PX, BOTTOM_PX + TITLE_PX + 2 * MARGIN_PX);

/// Draws `curves` over the two axes; the error is the plotter's reason.
pub(super) fn draw(
    title: &str,
    size_px: (u32, u32),
    (x, y): (Axis, Axis),
    curves: &[Curve],
) -> Result<String, String> {
    let mut svg = String::new();
    draw_into(&mut svg, title, size_px, (x, y), curves).map_err(|error| error.to_string())?;
    let name = title.replace('"', "&quot;");
    Ok(svg.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{name}\" "), 1))
}

fn draw_into(
    svg: &mut String,
    title: &str,
    size_px: (u32, u32),
    (x, y): (Axis, Axis),
    curves: &[Curve],
) -> Result<(), Box<dyn std::error::Error>> {
    let area = SVGBackend::with_string(svg, size_px).into_drawing_area();
    let (x_label, y_label) = (x.label.clone(), y.label.clone());
    let text = ("sans-serif", TEXT_PX).into_font().color(&BLACK);
    let mut chart = ChartBuilder::on(&area)
        .margin(MARGIN_PX)
        .caption(title, text.clone())
        .x_label_area_size(BOTTOM_PX)
        .y_label_area_size(LEFT_PX)
        .build_cartesian_2d(x, y)?;
    chart
        .configure_mesh()
        .axis_style(AXIS_COLOR)
        .bold_line_style(GRID_COLOR)
        .light_line_style(TRANSPARENT)
        .label_style(text)
        .x_desc(x_label)
        .y_desc(y_label)
        .draw()?;
    for curve in curves {
        let style = curve.stroke.color.stroke_width(curve.stroke.width_px);
        for line in thinned(&curve.points) {
            chart.draw_series(LineSeries::new(line, style))?;
        }
    }
    area.present()?;
    Ok(())
}

/// How many samples of a curve cannot be drawn.
pub(super) fn not_finite(curve: &Curve) -> usize {
    curve.points.iter().filter(|point| !finite(point)).count()
}

fn finite((along, up): &(f64, f64)) -> bool {
    along.is_finite() && up.is_finite()
}

/// The lowest and highest finite point of each stretch in their order; a stretch without any parts the
/// line in two.
fn thinned(points: &[(f64, f64)]) -> Vec<Vec<(f64, f64)>> {
    let stretch = if points.len() <= 2 * STRETCHES { 1 } else { points.len().div_ceil(STRETCHES) };
    let mut lines = vec![Vec::new()];
    for part in points.chunks(stretch) {
        let known = || part.iter().filter(|point| finite(point)).enumerate();
        let by_height =
            |a: &(usize, &(f64, f64)), b: &(usize, &(f64, f64))| a.1.1.total_cmp(&b.1.1);
        let line = lines.last_mut().expect("never empty");
        match (known().min_by(by_height), known().max_by(by_height)) {
            (Some(low), Some(high)) if low.0 == high.0 => line.push(*low.1),
            (Some(low), Some(high)) if low.0 < high.0 => line.extend([*low.1, *high.1]),
            (Some(low), Some(high)) => line.extend([*high.1, *low.1]),
            _ => lines.push(Vec::new()),
        }
    }
    lines.retain(|line| !line.is_empty());
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_every_peak_in_its_place() {
        let mut points: Vec<_> = (0..20_000).map(|i| (f64::from(i), 0.0)).collect();
        points[7_777].1 = 5.0;
        points[7_778].1 = -6.0;
        let lines = thinned(&points);
        assert_eq!(lines.len(), 1);
        assert!(lines[0].len() <= 2 * STRETCHES);
        assert!(lines[0].contains(&points[7_777]) && lines[0].contains(&points[7_778]));
        assert!(lines[0].is_sorted_by(|a, b| a.0 < b.0));
    }

    #[test]
    fn what_is_not_finite_parts_the_line() {
        let points = [(0.0, 1.0), (1.0, f64::NAN), (2.0, 1.0), (3.0, f64::INFINITY)];
        assert_eq!(thinned(&points), [vec![points[0]], vec![points[2]]]);
        let curve = Curve { stroke: crate::report::style::LIMIT, points: points.to_vec() };
        assert_eq!(not_finite(&curve), 2);
    }
}
