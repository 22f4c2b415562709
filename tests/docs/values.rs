//! Numbers that documents quote: `` `name` = 1, 2 `` in prose, `` | `name` | 1, 2 | `` in a table.

use std::collections::BTreeMap;

use firmware::config::Safety;
use shared::arm::JOINTS;

use crate::markdown::{Document, Place};

/// Values of a field, one or one a joint.
pub trait Numbers {
    fn numbers(&self) -> Vec<f32>;
}

impl Numbers for f32 {
    fn numbers(&self) -> Vec<f32> {
        vec![*self]
    }
}

impl Numbers for u32 {
    fn numbers(&self) -> Vec<f32> {
        vec![*self as f32]
    }
}

impl<const N: usize> Numbers for [f32; N] {
    fn numbers(&self) -> Vec<f32> {
        self.to_vec()
    }
}

impl Numbers for [u32; JOINTS] {
    fn numbers(&self) -> Vec<f32> {
        self.map(|n| n as f32).to_vec()
    }
}

/// Names with their values.
pub type Values = BTreeMap<&'static str, Vec<f32>>;

macro_rules! fields {
    ($of:expr, $struct:ident { $($field:ident),* $(,)? }) => {{
        // Destructured without `..`, so that a new field does not compile before it has its row.
        let $struct { $($field),* } = $of;
        Values::from([$((stringify!($field), Numbers::numbers(&$field))),*])
    }};
}

/// The configuration's thresholds.
pub fn safety() -> Values {
    fields!(
        Safety::REFERENCE,
        Safety {
            stop_s,
            preload_s,
            brake_open_s,
            brake_set_s,
            torque_tail_s,
            test_move_s,
            test_move,
            link_timeout_s,
            jog_timeout_s,
            rest_pose,
            lowering_share,
            rated_payload_kg,
            torque_reserve,
            parked_tolerance,
            unforeseen,
            violent,
            torque_warn,
            torque_wrong,
            speed_error,
            swing,
            tracking,
            tracking_s,
            error_window,
            overspeed,
            overtravel,
            slip,
            clock_hz,
            budget,
            conversions_hz,
        }
    )
}

macro_rules! sources {
    ($($folder:literal: $($file:literal)*;)*) => {
        /// Files of constants, by the name that the document gives them.
        const SOURCES: &[(&str, &str)] =
            &[$($(($file, include_str!(concat!("../../", $folder, $file)))),*),*];
    };
}

sources! {
    "firmware/control/src/": "monitor/bucket.rs" "monitor/clock.rs" "monitor/encoder.rs"
        "monitor/motion.rs" "monitor/thresholds.rs" "monitor/torque.rs" "controller/control.rs"
        "controller/mod.rs" "controller/sample.rs"
        "supervisor/timing.rs";
    "firmware/src/": "drivers/ads131m04.rs";
}

/// Private constants with a plain number, as (file, name, value). `WORDS` and the like are arithmetic and not
/// among them.
pub fn constants() -> Vec<(&'static str, &'static str, f32)> {
    let of_file = |&(file, source): &(&'static str, &'static str)| {
        source.lines().filter_map(move |line| {
            let (name, rest) = line.strip_prefix("const ")?.split_once(": ")?;
            let (_, value) = rest.split_once(" = ")?;
            let value = value.strip_suffix(';')?.replace('_', "");
            Some((file, name, value.parse().ok()?))
        })
    };
    SOURCES.iter().flat_map(of_file).collect()
}

/// The numbers that `text` begins with, separated by commas, and none after the first other thing.
pub fn leading_numbers(text: &str) -> Vec<f32> {
    let mut numbers = Vec::new();
    let mut rest = text;
    loop {
        let longest = (1..=rest.len().min(16)).rev().filter(|end| rest.is_char_boundary(*end));
        let number = |end: usize| Some((rest[..end].trim_end().parse::<f32>().ok()?, end));
        let Some((value, end)) = longest.filter_map(number).next() else { return numbers };
        numbers.push(value);
        let Some(next) = rest[end..].strip_prefix(", ") else { return numbers };
        rest = next;
    }
}

/// Every `` `name` = 1, 2 `` of a document.
pub fn quotes(document: Document) -> impl Iterator<Item = (Place, &'static str, Vec<f32>)> {
    document.lines().flat_map(|(place, line)| {
        let pieces: Vec<_> = line.split('`').collect();
        let pairs = pieces.windows(2).enumerate().filter(|(i, _)| i % 2 == 1);
        let quote = |pair: &[&'static str]| {
            let numbers = leading_numbers(pair[1].strip_prefix(" = ")?);
            (!numbers.is_empty()).then_some((place, pair[0], numbers))
        };
        pairs.filter_map(|(_, pair)| quote(pair)).collect::<Vec<_>>()
    })
}

/// What is wrong with a quoted value.
pub fn complaint(place: Place, name: &str, written: &[f32], value: &[f32]) -> Option<String> {
    let list =
        |numbers: &[f32]| numbers.iter().map(|n| format!("{n}")).collect::<Vec<_>>().join(", ");
    // One number may stand for all joints.
    let fits = written == value || matches!(written, [one] if value.iter().all(|v| v == one));
    (!fits)
        .then(|| format!("{place}: `{name}` is {} in the code, not {}", list(value), list(written)))
}

#[test]
fn numbers_end_where_words_begin() {
    assert_eq!(leading_numbers("0.150 s, and 3"), [0.15]);
    assert_eq!(leading_numbers("4e-4, 1e-3, 2e-3 rad"), [4e-4, 1e-3, 2e-3]);
    assert_eq!(leading_numbers("1, -1.1, each"), [1.0, -1.1]);
    assert_eq!(leading_numbers("every"), [] as [f32; 0]);
}
