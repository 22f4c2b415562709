//! Table 3: this run's figures beside the paper's.

use comfy_table::{CellAlignment, ContentArrangement, Table, presets};

use crate::outcome::{Metrics, Outcome};

/// A controller's row of the paper's Table 3, in m and s.
struct Printed {
    name: &'static str,
    rms_m: [f64; 3],
    rse_m: f64,
    rho_s: f64,
    e_max_m: f64,
}

const PAPER_TAU: Printed = Printed {
    name: "paper, τ",
    rms_m: [8.4101e-6, 2.6113e-6, 1.4869e-5],
    rse_m: 2.7134e-6,
    rho_s: 1.2635e-3,
    e_max_m: 2.8703e-4,
};

const PAPER_PD: Printed = Printed {
    name: "paper, τ_PD",
    rms_m: [1.2333e-4, 5.6889e-4, 3.9024e-4],
    rse_m: 8.6740e-5,
    rho_s: 4.49e-2,
    e_max_m: 1.8e-3,
};

const QUANTITIES: [&str; 7] =
    ["RMS x, m", "RMS y, m", "RMS z, m", "RSE, m", "ρ, s", "e_max, m", "e_max / ρ, m/s"];

/// Rows that the paper's impossible figure reaches.
const E_MAX: usize = 5;
const SPEED: usize = 6;

impl Printed {
    fn figures(&self) -> [f64; 7] {
        let [x, y, z] = self.rms_m;
        [x, y, z, self.rse_m, self.rho_s, self.e_max_m, self.e_max_m / self.rho_s]
    }
}

/// Cells of the table, each row led by its quantity; the page and the terminal show the same.
pub(super) struct Cells {
    pub header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

pub(super) fn cells(outcomes: &[Outcome]) -> Cells {
    let ours = outcomes.iter().map(|outcome| outcome.label().to_string());
    let names = ours.chain([PAPER_TAU.name.into(), PAPER_PD.name.into()]);
    let rows = QUANTITIES.iter().enumerate().map(|(i, quantity)| {
        let ours = outcomes.iter().map(|outcome| match figures(&outcome.metrics)[i] {
            speed if i == SPEED => Metrics::speed(speed),
            figure => Metrics::figure(figure),
        });
        let tau = printed(&PAPER_TAU, i);
        let pd = printed(&PAPER_PD, i) + if i >= E_MAX { " *" } else { "" };
        [quantity.to_string()].into_iter().chain(ours).chain([tau, pd]).collect()
    });
    Cells { header: ["quantity".into()].into_iter().chain(names).collect(), rows: rows.collect() }
}

/// The paper's digits; the derived last row has no more than they allow.
fn printed(row: &Printed, quantity: usize) -> String {
    let value = row.figures()[quantity];
    if quantity == SPEED { format!("{value:.4}") } else { format!("{value:e}") }
}

fn figures(metrics: &Metrics) -> [f64; 7] {
    let [x, y, z] = metrics.rms_m;
    [x, y, z, metrics.rse_m, metrics.rho_s, metrics.e_max_m, metrics.v_max_m_s]
}

/// Which of the printed figures cannot be right, and why.
pub(super) fn impossible() -> String {
    let Printed { rse_m, rho_s, e_max_m, .. } = PAPER_PD;
    let speed = PAPER_TAU.e_max_m / PAPER_TAU.rho_s;
    format!(
        "* The paper's e_max of {e_max_m:e} m for the PD is impossible: the mean square of the error (its \
         RMS squared, summed over the axes) is {:.1e} m² and cannot exceed e_max · RSE = {:.2e} m². \
         With the top speed of {speed:.4} m/s that its first controller implies, ρ gives an e_max of \
         {:.1e} m.",
        mean_square(&PAPER_PD),
        e_max_m * rse_m,
        rho_s * speed,
    )
}

fn mean_square(row: &Printed) -> f64 {
    row.rms_m.iter().map(|rms| rms * rms).sum()
}

/// Table 3 for a terminal: the runs' figures beside the paper's, and what is wrong in print.
pub fn table3(outcomes: &[Outcome]) -> String {
    let Cells { header, rows } = cells(outcomes);
    let mut table = Table::new();
    table
        .load_style(presets::UTF8_FULL_CONDENSED)
        .set_content_arrangement(ContentArrangement::Dynamic)
        .set_header(header)
        .add_rows(rows);
    for column in table.column_iter_mut().skip(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    format!("{table}\n{}\n", impossible())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_printed_pd_row_contradicts_itself() {
        // mean(e²) <= e_max · mean(e) for any error.
        let possible = |row: &Printed| mean_square(row) <= row.e_max_m * row.rse_m;
        assert!(possible(&PAPER_TAU));
        assert!(!possible(&PAPER_PD));
        let mended = Printed { e_max_m: 1.0e-2, ..PAPER_PD };
        assert!(possible(&mended));
        let note = impossible();
        for figure in ["1.8e-3", "4.9e-7", "1.56e-7", "0.2272", "1.0e-2"] {
            assert!(note.contains(figure), "{figure} is not in: {note}");
        }
    }
}
