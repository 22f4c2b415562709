//! A campaign for a terminal.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use shared::fault::Fault;

use super::{Campaign, Cell, Verdict};

/// Heads of [`line`]'s texts.
pub const HEADER: [&str; 8] = [
    "row",
    "fault",
    "pose",
    "reaction",
    "detect / react, ticks",
    "drop, mm",
    "bound, mm",
    "verdict",
];

/// Heads of [`overview`]'s texts.
pub const OVERVIEW_HEADER: [&str; 6] =
    ["row", "fault", "cells that pass", "reactions", "slowest, ticks", "nearest to its bound, mm"];

/// Cells, what was left out, a line a row, and the count of cells that pass.
pub fn table(campaign: &Campaign) -> String {
    let cells = framed(&HEADER, campaign.cells.iter().map(line), &[0, 4, 5, 6]);
    let rows = framed(&OVERVIEW_HEADER, overview(campaign).into_iter(), &[0, 2, 4, 5]);
    let left = campaign
        .left
        .iter()
        .map(|left| format!("  row {} in pose {}: {}\n", left.row, left.pose, left.why));
    let left = left.collect::<String>();
    let left = if left.is_empty() { left } else { format!("Left out:\n{left}") };
    let (passed, total) = (campaign.passed(), campaign.cells.len());
    format!("{cells}\n{left}{rows}\n{passed} of {total} cells pass (seed {})\n", campaign.seed)
}

fn framed<const N: usize>(
    header: &[&str; N],
    rows: impl Iterator<Item = [String; N]>,
    right: &[usize],
) -> Table {
    let mut table = Table::new();
    table
        .load_style(presets::UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(header)
        .add_rows(rows);
    for &column in right {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// A line a row of the fault table: what its cells came to together.
pub fn overview(campaign: &Campaign) -> Vec<[String; 6]> {
    let rows = campaign.cells.chunk_by(|a, b| a.row == b.row);
    rows.map(|cells| {
        let verdicts = || cells.iter().map(|cell| &cell.verdict);
        let passed = verdicts().filter(|v| v.passes()).count();
        let mut reactions = Vec::new();
        for name in verdicts().map(|v| v.reaction.name()) {
            if !reactions.contains(&name) {
                reactions.push(name);
            }
        }
        let slowest = verdicts().filter_map(|v| v.react_ticks).max();
        let share = |v: &Verdict| v.drop_m / v.bound_m;
        let nearest = verdicts().max_by(|a, b| share(a).total_cmp(&share(b)));
        [
            cells[0].row.to_string(),
            cells[0].title.to_owned(),
            format!("{passed} of {}", cells.len()),
            reactions.join(", "),
            slowest.map_or("-".into(), |ticks| ticks.to_string()),
            nearest
                .map_or("-".into(), |v| format!("{:.3} of {:.3}", v.drop_m * 1e3, v.bound_m * 1e3)),
        ]
    })
    .collect()
}

/// The texts of a cell in the header's order.
pub fn line(cell: &Cell) -> [String; 8] {
    let v = &cell.verdict;
    let ticks = |ticks: Option<u32>| ticks.map_or("-".into(), |ticks| ticks.to_string());
    let reaction = match v.fault {
        Fault::None => v.reaction.name().to_owned(),
        fault => format!("{}, {}", v.reaction.name(), fault.name()),
    };
    [
        cell.row.to_string(),
        format!("{}: {}", cell.title, cell.variant),
        cell.pose.clone(),
        reaction,
        format!("{} / {}", ticks(v.detect_ticks), ticks(v.react_ticks)),
        format!("{:.3}", v.drop_m * 1e3),
        format!("{:.3}", v.bound_m * 1e3),
        if v.passes() { "pass".into() } else { v.short.join("; ") },
    ]
}
