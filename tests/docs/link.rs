//! `docs/link.md` names every kind of frame and every refusal by its number.

use shared::fault::LinkRefusal;
use shared::link::{CODED_BYTES, FRAME_BYTES, Kind, WIRE_BYTES};

const TEXT: &str = include_str!("../../docs/link.md");

/// First two cells of every row of the tables.
fn rows() -> Vec<(String, String)> {
    let cells = |line: &str| {
        let mut cells = line.strip_prefix('|')?.split('|').map(|cell| cell.trim().to_owned());
        Some((cells.next()?, cells.next()?))
    };
    TEXT.lines().filter_map(cells).collect()
}

#[test]
fn kinds_and_refusals_stand_in_the_tables() {
    let kinds = Kind::ALL.iter().map(|kind| (*kind as u8, kind.name()));
    let refusals = LinkRefusal::ALL.iter().map(|refusal| (*refusal as u8, refusal.name()));
    let expected: Vec<_> =
        kinds.chain(refusals).map(|(number, name)| (number.to_string(), name.to_owned())).collect();
    let is_coded = |number: &str| number.parse::<u8>().is_ok();
    // The table of bytes has a range in all rows but those of kind and version.
    let found: Vec<_> = rows()
        .into_iter()
        .filter(|(number, name)| is_coded(number) && !matches!(name.as_str(), "kind" | "version"))
        .collect();
    assert_eq!(found, expected);
}

#[test]
fn sizes_are_those_of_the_code() {
    assert_eq!((FRAME_BYTES, WIRE_BYTES, CODED_BYTES), (68, 71, 48));
    assert!(TEXT.contains("68 bytes") && TEXT.contains("71 bytes") && TEXT.contains("0 to 47"));
}
