//! The campaign's page: the table, and for each row how the tip sinks and how the path ends, pose by pose.

use std::fs;
use std::path::{Path, PathBuf};

use super::axis::Axis;
use super::figures::Figure;
use super::page::{figure, framed, html_table};
use super::plot::{self, Curve, PANEL_PX};
use super::style::{FAILED, LIMIT, PASSED, Stroke};
use super::{ReportError, at};
use crate::campaign::{Campaign, Cell, HEADER, Left, OVERVIEW_HEADER, line, overview};

/// Writes `dir`/report.html (the folder is made if missing) and returns its path.
///
/// # Errors
/// Where it cannot be drawn or written.
pub fn write_campaign(dir: &Path, campaign: &Campaign) -> Result<PathBuf, ReportError> {
    let html = render(campaign)?;
    fs::create_dir_all(dir).map_err(at(dir))?;
    let path = dir.join("report.html");
    fs::write(&path, html).map_err(at(&path))?;
    Ok(path)
}

fn render(campaign: &Campaign) -> Result<String, ReportError> {
    let mut numbers = campaign.cells.iter().map(|cell| cell.row).collect::<Vec<_>>();
    numbers.dedup();
    let mut body = summary(campaign);
    for number in numbers {
        let cells = campaign.cells.iter().filter(|cell| cell.row == number).collect::<Vec<_>>();
        body += &figure(&pictures(&cells)?);
        let rows = cells.iter().map(|cell| line(cell).to_vec()).collect::<Vec<_>>();
        body += &html_table(&HEADER.map(String::from), &rows);
    }
    Ok(framed("Lifting arm, fault campaign", &body))
}

fn summary(campaign: &Campaign) -> String {
    let (passed, total) = (campaign.passed(), campaign.cells.len());
    let left = |left: &Left| vec![left.row.to_string(), left.pose.clone(), left.why.to_owned()];
    let left = campaign.left.iter().map(left).collect::<Vec<_>>();
    let header = ["row", "pose", "why it is left out"].map(String::from);
    let left = if left.is_empty() { String::new() } else { html_table(&header, &left) };
    let rows = overview(campaign).into_iter().map(Vec::from).collect::<Vec<_>>();
    let rows = html_table(&OVERVIEW_HEADER.map(String::from), &rows);
    format!("<p>{passed} of {total} cells pass, seed {}.</p>\n{rows}{left}", campaign.seed)
}

/// Two panels a pose, every way of the row in each.
fn pictures(cells: &[&Cell]) -> Result<Figure, ReportError> {
    let first = cells[0];
    let mut poses = cells.iter().map(|cell| cell.pose.as_str()).collect::<Vec<_>>();
    poses.dedup();
    let mut panels = Vec::new();
    for pose in poses {
        let shown = cells.iter().filter(|cell| cell.pose == pose && !cell.verdict.curve.is_empty());
        let shown = shown.copied().collect::<Vec<_>>();
        if !shown.is_empty() {
            panels.push(panel(pose, "tip below its reference", "m", &shown, |point| {
                point.sinking_m
            })?);
            panels.push(panel(pose, "path rate", "1", &shown, |point| point.path_rate)?);
        }
    }
    let legend = [("passes", PASSED), ("falls short", FAILED), ("bound of the drop", LIMIT)];
    Ok(Figure {
        title: format!("Row {}. {}", first.row, first.title),
        caption: "Time counts from when the fault's condition is complete. The reference is the stop along the \
                  path that begins then, or the path itself where nothing is stopped."
            .into(),
        legend: legend.map(|(name, stroke)| (name.to_owned(), stroke)).into(),
        panels,
        dropped: 0,
    })
}

type Value = fn(&crate::campaign::Point) -> f64;

fn panel(
    pose: &str,
    quantity: &str,
    unit: &str,
    cells: &[&Cell],
    value: Value,
) -> Result<String, ReportError> {
    let curve = |cell: &&Cell| Curve {
        stroke: stroke(cell),
        points: cell.verdict.curve.iter().map(|point| (point.t_s, value(point))).collect(),
    };
    let mut curves = cells.iter().map(curve).collect::<Vec<_>>();
    if unit == "m" {
        curves.extend(limits(cells));
    }
    let times = || curves.iter().flat_map(|c| &c.points).map(|point| point.0);
    let (start, end) = (times().fold(0.0, f64::min), times().fold(1e-3, f64::max));
    let values = curves.iter().flat_map(|c| &c.points).map(|point| point.1);
    let axes = (Axis::over("time, s", start..end), Axis::linear(quantity, unit, values));
    let title = format!("{pose}: {quantity}");
    plot::draw(&title, PANEL_PX, axes, &curves)
        .map_err(|reason| ReportError::Plot { figure: title.clone(), reason })
}

fn stroke(cell: &Cell) -> Stroke {
    if cell.verdict.passes() { PASSED } else { FAILED }
}

/// The bound that all ways share, if they do.
fn limits(cells: &[&Cell]) -> Option<Curve> {
    let bound = cells[0].verdict.bound_m;
    let ends = cells[0].verdict.curve.iter().map(|point| (point.t_s, bound));
    let shared = cells.iter().all(|cell| cell.verdict.bound_m == bound);
    shared.then(|| Curve { stroke: LIMIT, points: ends.collect() })
}
