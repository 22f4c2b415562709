//! A campaign for a terminal.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};
use shared::fault::Fault;

use super::{Campaign, Cell};

const HEADER: [&str; 8] = [
    "row",
    "fault",
    "pose",
    "reaction",
    "detect / react, ticks",
    "drop, mm",
    "bound, mm",
    "verdict",
];

/// Cells, what was left out, and the count of those that pass.
pub fn table(campaign: &Campaign) -> String {
    let mut table = Table::new();
    table
        .load_style(presets::UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(HEADER);
    for cell in &campaign.cells {
        table.add_row(line(cell));
    }
    for column in [0, 4, 5, 6] {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    let left = campaign
        .left
        .iter()
        .map(|left| format!("  row {} in pose {}: {}\n", left.row, left.pose, left.why));
    let left = left.collect::<String>();
    let left = if left.is_empty() { left } else { format!("Left out:\n{left}") };
    let (passed, total) = (campaign.passed(), campaign.cells.len());
    format!("{table}\n{left}{passed} of {total} cells pass (seed {})\n", campaign.seed)
}

/// The texts of a cell in the header's order.
pub fn line(cell: &Cell) -> [String; 8] {
    let v = &cell.verdict;
    let ticks = |ticks: Option<u32>| ticks.map_or("-".into(), |ticks| ticks.to_string());
    let reaction = match v.fault {
        (Fault::None, _) => v.reaction.name().to_owned(),
        (fault, _) => format!("{}, {}", v.reaction.name(), fault.name()),
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
