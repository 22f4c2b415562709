//! One look for every figure: Okabe-Ito colours, line widths and dash patterns.

use std::fmt::Write;

use plotters::style::RGBColor;

use crate::outcome::{Adaptation, Law, Outcome};

/// How a curve is drawn. The dash pattern is applied by the page's style sheet, keyed by colour.
#[derive(Clone, Copy)]
pub(super) struct Stroke {
    pub color: RGBColor,
    pub width_px: u32,
    dash: &'static str,
}

const INERTIA: Stroke = stroke(0x0072B2, 3, "none");
const PD: Stroke = stroke(0xD55E00, 3, "14 7");
const PAPER: Stroke = stroke(0xCC79A7, 3, "4 6");
const FIXED: Stroke = stroke(0x009E73, 3, "16 6 3 6");

/// A controller looks the same in every report.
pub(super) const fn controller(outcome: &Outcome) -> Stroke {
    match (outcome.law, outcome.adaptation) {
        (Law::Pd, _) => PD,
        (Law::Backstepping, Adaptation::Inertia) => INERTIA,
        (Law::Backstepping, Adaptation::Paper) => PAPER,
        (Law::Backstepping, Adaptation::None) => FIXED,
    }
}

/// What a controller should have followed: wide and pale, so that the curves on it stay visible.
pub(super) const REFERENCE: Stroke = stroke(0xBBBBBB, 9, "none");

pub(super) const LIMIT: Stroke = stroke(0x000000, 2, "10 6");

/// Poses of the side view, from start (pale) to end (dark).
pub(super) const POSES: [Stroke; 3] =
    [stroke(0xA6CBE6, 4, "none"), stroke(0x4A8FC4, 4, "none"), stroke(0x0B3C66, 4, "none")];

/// Cells of the fault campaign.
pub(super) const PASSED: Stroke = stroke(0x56B4E9, 2, "none");
/// See [`PASSED`].
pub(super) const FAILED: Stroke = stroke(0xA01C00, 3, "8 4");

pub(super) const TIP_PATH: Stroke = stroke(0xE69F00, 3, "none");

const fn stroke(rgb: u32, width_px: u32, dash: &'static str) -> Stroke {
    let [_, red, green, blue] = rgb.to_be_bytes();
    Stroke { color: RGBColor(red, green, blue), width_px, dash }
}

impl Stroke {
    /// The same line, `factor` times as wide.
    pub(super) const fn widened(self, factor: u32) -> Self {
        Self { width_px: self.width_px * factor, ..self }
    }

    fn hex(self) -> String {
        let RGBColor(red, green, blue) = self.color;
        format!("#{red:02X}{green:02X}{blue:02X}")
    }

    /// A short sample of the line for a legend.
    pub(super) fn swatch(self) -> String {
        format!(
            "<svg class=\"swatch\" viewBox=\"0 0 64 12\" aria-hidden=\"true\"><polyline fill=\"none\" \
             stroke=\"{}\" stroke-width=\"{}\" points=\"0,6 64,6\"/></svg>",
            self.hex(),
            self.width_px,
        )
    }
}

/// Style sheet rules that give each dashed colour its pattern.
pub(super) fn dash_rules() -> String {
    [INERTIA, PD, PAPER, FIXED, LIMIT, FAILED].into_iter().fold(
        String::new(),
        |mut rules, stroke| {
            let _ = writeln!(
                rules,
                "polyline[stroke=\"{}\"] {{ stroke-dasharray: {}; }}",
                stroke.hex(),
                stroke.dash
            );
            rules
        },
    )
}
