//! `docs/faults.md` against the codes that telemetry carries and the reactions to them.

use firmware::supervisor::{Reaction, clears};
use shared::fault::{Fault, Limit, Refusal};

use crate::markdown::{Document, Place, compare, conclude, document};

const DOCUMENT: Document = document!("faults.md");

/// What every entry has to tell.
const PARTS: [&str; 4] = ["Seen by", "Reaction", "Likely causes", "What to do"];

/// A fault's entry.
struct Entry {
    place: Place,
    /// Number and name as written.
    title: &'static str,
    /// Hundred that its section is of.
    band: &'static str,
    lines: Vec<&'static str>,
}

impl Entry {
    fn part(&self, name: &str) -> Option<&'static str> {
        let head = format!("- **{name}:** ");
        self.lines.iter().find_map(|line| line.strip_prefix(head.as_str()))
    }

    fn fault(&self) -> Option<Fault> {
        Fault::ALL.iter().copied().find(|fault| title(*fault) == self.title)
    }

    fn complaints(&self) -> Vec<String> {
        let Some(fault) = self.fault() else { return Vec::new() };
        let missing = PARTS.iter().filter(|part| self.part(part).is_none_or(str::is_empty));
        let mut complaints: Vec<_> = missing.map(|part| format!("no \"{part}\"")).collect();
        let written = self.part("Reaction").unwrap_or_default();
        let reaction = name(Reaction::to(fault));
        let first = written.split([' ', ';', ':', '.', ',']).next().unwrap_or_default();
        if first != reaction {
            complaints.push(format!("its reaction is {reaction} in the code, not \"{first}\""));
        }
        let locked = written.contains("Locked out");
        if locked == clears(fault) {
            let is = if clears(fault) { "can be cleared" } else { "is locked out" };
            complaints.push(format!("by the code it {is}"));
        }
        if self.band.parse() != Ok(fault as u16 / 100 * 100) {
            complaints.push(format!("it stands among the {}s", self.band));
        }
        let of_entry = |what| format!("{}: {}: {what}", self.place, self.title);
        complaints.into_iter().map(of_entry).collect()
    }
}

fn title(fault: Fault) -> String {
    format!("{} {}", fault as u16, fault.name())
}

/// The reaction's name in the document.
fn name(reaction: Reaction) -> &'static str {
    match reaction {
        Reaction::None => "none",
        Reaction::Ss1 => "SS1",
        Reaction::Isolate => "isolate",
        Reaction::Sto => "STO",
    }
}

fn entries() -> Vec<Entry> {
    let mut entries: Vec<Entry> = Vec::new();
    let mut band = "";
    for (place, line) in DOCUMENT.lines() {
        if let Some(heading) = line.strip_prefix("## ") {
            band = heading.split(':').next().unwrap_or_default();
        } else if let Some(title) = line.strip_prefix("### ") {
            entries.push(Entry { place, title, band, lines: Vec::new() });
        } else if let Some(entry) = entries.last_mut() {
            entry.lines.push(line);
        }
    }
    entries
}

#[test]
fn every_fault_has_one_entry() {
    let written: Vec<_> = entries().iter().map(|entry| entry.title.to_owned()).collect();
    let expected: Vec<_> = Fault::ALL.iter().map(|fault| title(*fault)).collect();
    conclude(&compare(DOCUMENT.name, "entry", &written, &expected));
}

#[test]
fn entries_are_whole_and_tell_the_reaction_of_the_code() {
    conclude(&entries().iter().flat_map(Entry::complaints).collect::<Vec<_>>());
}

#[test]
fn the_table_of_reactions_has_all_of_them() {
    let rows = DOCUMENT.rows("# Faults");
    let written: Vec<_> = rows.iter().take(4).map(|row| row.cells[0].to_owned()).collect();
    let all = [Reaction::None, Reaction::Ss1, Reaction::Isolate, Reaction::Sto];
    assert_eq!(written, all.map(name));
}

/// Compares a table's first two columns with codes.
fn check(heading: &str, what: &str, expected: &[String]) {
    let rows = DOCUMENT.rows(heading);
    let written: Vec<_> = rows.iter().map(|row| row.cells[..2].join(" ")).collect();
    conclude(&compare(DOCUMENT.name, what, &written, expected));
}

#[test]
fn every_limit_has_one_row() {
    let codes: Vec<_> = Limit::ALL.iter().map(|l| format!("{} {}", *l as u8, l.name())).collect();
    check("## Limits", "limit", &codes);
}

#[test]
fn every_refusal_has_one_row() {
    let codes: Vec<_> = Refusal::ALL.iter().map(|r| format!("{} {}", *r as u8, r.name())).collect();
    check("## Refusals", "refusal", &codes);
}
