//! Axes: range, ticks and labels in engineering units.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// An axis for data in SI units.
pub(super) struct Axis {
    /// Quantity and prefixed unit.
    pub label: String,
    /// Ends in the coordinate of the scale.
    range: Range<f64>,
    /// Ticks in the coordinate of the scale.
    ticks: Vec<f64>,
    scale: Scale,
    decimals: usize,
}

enum Scale {
    /// Data times this factor.
    Linear(f64),
    /// Decades; the axis shows the common logarithm.
    Log,
}

/// A logarithmic axis shows at most this many decades below its top; the rest lies on its lower edge.
const DECADES: f64 = 10.0;

/// About this many ticks an axis.
const TICKS: f64 = 7.0;

/// Metric prefixes and their factors.
const PREFIXES: [(f64, &str); 5] = [(1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n")];

impl Axis {
    /// An axis that spans `values` (finite ones count) of `quantity` in `unit` with a metric prefix.
    pub(super) fn linear(quantity: &str, unit: &str, values: impl Iterator<Item = f64>) -> Self {
        let Range { start, end } = span(values);
        let largest = start.abs().max(end.abs());
        let (size, prefix) = prefix(largest);
        // A constant gets a band about itself instead of its rounding noise blown up.
        let half = ((end - start) / 2.0 * 1.08).max(largest * 5e-4);
        let half = if half > 0.0 { half } else { size };
        let middle = f64::midpoint(start, end);
        let label = format!("{quantity}, {prefix}{unit}");
        Self::ruled(label, (middle - half) / size..(middle + half) / size, 1.0 / size)
    }

    /// An axis over exactly `range`, in its own unit.
    pub(super) fn over(label: &str, range: Range<f64>) -> Self {
        Self::ruled(label.into(), range, 1.0)
    }

    /// A logarithmic axis over whole decades that spans the positive ones among `values`.
    pub(super) fn log(quantity: &str, unit: &str, values: impl Iterator<Item = f64>) -> Self {
        let exponents = span(values.filter(|value| *value > 0.0).map(f64::log10));
        let top = exponents.end.ceil();
        let bottom = exponents.start.floor().max(top - DECADES).min(top - 1.0);
        let step = if top - bottom > TICKS { 2 } else { 1 };
        let ticks = (bottom as i32..=top as i32).rev().step_by(step).map(f64::from).collect();
        let label = format!("{quantity}, {unit}");
        Self { label, range: bottom..top, ticks, scale: Scale::Log, decimals: 0 }
    }

    /// Ticks at 1, 2 or 5 times a power of ten.
    fn ruled(label: String, range: Range<f64>, factor: f64) -> Self {
        let rough = (range.end - range.start) / TICKS;
        let power = 10f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= rough);
        let step = step.unwrap_or(rough);
        let first = (range.start / step - 1e-9).ceil() as i64;
        let last = (range.end / step + 1e-9).floor() as i64;
        let ticks = (first..=last).map(|i| i as f64 * step).collect();
        let decimals = (-(step.log10() + 1e-9).floor()).max(0.0) as usize;
        Self { label, range, ticks, scale: Scale::Linear(factor), decimals }
    }

    /// Where a value lies in the coordinate of the scale.
    fn place(&self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear(factor) => value * factor,
            Scale::Log if value > 0.0 => value.log10().max(self.range.start),
            Scale::Log => self.range.start,
        }
    }

    fn value(&self, place: f64) -> f64 {
        match self.scale {
            Scale::Linear(factor) => place / factor,
            Scale::Log => 10f64.powf(place),
        }
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (first_px, last_px): (i32, i32)) -> i32 {
        let share = (self.place(*value) - self.range.start) / (self.range.end - self.range.start);
        first_px + (f64::from(last_px - first_px) * share).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|tick| self.value(*tick)).collect()
    }

    fn range(&self) -> Range<f64> {
        self.value(self.range.start)..self.value(self.range.end)
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        let place = self.place(*value);
        match self.scale {
            Scale::Linear(_) => {
                // Adding zero turns a rounded -0 into 0.
                let power = 10f64.powi(self.decimals as i32);
                let rounded = (place * power).round() / power + 0.0;
                format!("{rounded:.*}", self.decimals).replace('-', "\u{2212}")
            }
            Scale::Log => format!("10{}", superscript(place.round() as i32)),
        }
    }
}

/// Lowest and highest finite value; 0..0 without any.
fn span(values: impl Iterator<Item = f64>) -> Range<f64> {
    let grow = |range: Option<Range<f64>>, value: f64| {
        let range = range.unwrap_or(value..value);
        Some(range.start.min(value)..range.end.max(value))
    };
    values.filter(|value| value.is_finite()).fold(None, grow).unwrap_or(0.0..0.0)
}

/// The prefix that writes `largest` as a number from 0.2 up to 200, and thousands above kilo.
fn prefix(largest: f64) -> (f64, &'static str) {
    let fits = |(factor, _): &&(f64, &str)| largest >= 0.2 * factor;
    match PREFIXES.iter().find(fits) {
        Some(found) => *found,
        None => (1.0, ""),
    }
}

fn superscript(exponent: i32) -> String {
    let raise = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    exponent.to_string().chars().map(raise).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &Axis) -> Vec<String> {
        axis.key_points(9).iter().map(|tick| axis.format_ext(tick)).collect()
    }

    #[test]
    fn values_map_to_pixels_between_the_ends() {
        let linear = Axis::over("t", 0.0..10.0);
        assert_eq!([0.0, 2.5, 10.0].map(|v| linear.map(&v, (100, 300))), [100, 150, 300]);
        let log = Axis::log("V", "1", [1e-4, 1.0].into_iter());
        assert_eq!([0.0, 1e-2, 1.0].map(|v| log.map(&v, (400, 0))), [400, 200, 0]);
    }

    #[test]
    fn linear_axis_takes_a_prefix_and_round_ticks() {
        let axis = Axis::linear("error", "rad", [-3.1e-7, f64::NAN, 2.2e-7].into_iter());
        assert_eq!(axis.label, "error, µrad");
        assert_eq!(labels(&axis), ["−0.3", "−0.2", "−0.1", "0.0", "0.1", "0.2"]);
        assert!((axis.place(-3.1e-7) + 0.31).abs() < 1e-12);
        assert_eq!(Axis::linear("torque", "N m", [13_917.0].into_iter()).label, "torque, kN m");
        assert_eq!(Axis::linear("torque", "N m", [106.0].into_iter()).label, "torque, N m");
        assert_eq!(Axis::linear("position", "rad", [0.2129].into_iter()).label, "position, rad");
    }

    #[test]
    fn log_axis_spans_decades_and_holds_what_lies_below() {
        let axis = Axis::log("V", "1", [0.0, 3e-20, 2e-3, f64::INFINITY].into_iter());
        assert_eq!(axis.range, -12.0..-2.0);
        assert_eq!(labels(&axis), ["10⁻²", "10⁻⁴", "10⁻⁶", "10⁻⁸", "10⁻¹⁰", "10⁻¹²"]);
        assert_eq!([axis.place(0.0), axis.place(1e-30), axis.place(1e-4)], [-12.0, -12.0, -4.0]);
    }

    #[test]
    fn an_axis_without_data_still_has_a_range() {
        for axis in [
            Axis::linear("e", "m", [f64::NAN].into_iter()),
            Axis::linear("e", "m", [0.0].into_iter()),
            Axis::log("e", "m", [0.0].into_iter()),
        ] {
            assert!(axis.range.end > axis.range.start && axis.ticks.len() >= 2, "{}", axis.label);
        }
    }
}
