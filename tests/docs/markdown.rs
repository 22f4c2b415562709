//! The parts of a document that tests compare.

use std::fmt;

/// A document by its name in `docs/`.
#[derive(Clone, Copy)]
pub struct Document {
    pub name: &'static str,
    pub text: &'static str,
}

macro_rules! document {
    ($name:literal) => {
        crate::markdown::Document {
            name: concat!("docs/", $name),
            text: include_str!(concat!("../../docs/", $name)),
        }
    };
}
pub(crate) use document;

/// A line of a document, told as an editor wants it.
#[derive(Clone, Copy)]
pub struct Place {
    pub document: &'static str,
    pub line: usize,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}", self.document, self.line)
    }
}

/// A row of a table, without its head.
pub struct Row {
    pub place: Place,
    pub cells: Vec<&'static str>,
}

impl Document {
    /// Every line with its place.
    pub fn lines(self) -> impl Iterator<Item = (Place, &'static str)> {
        let place = move |i| Place { document: self.name, line: i + 1 };
        self.text.lines().enumerate().map(move |(i, line)| (place(i), line))
    }

    /// The lines below a heading, up to the next one that is as high.
    pub fn section(self, heading: &str) -> Vec<(Place, &'static str)> {
        let level = |line: &str| line.bytes().take_while(|b| *b == b'#').count();
        let below = self.lines().skip_while(|(_, line)| *line != heading).skip(1);
        let ends = |line: &str| (1..=level(heading)).contains(&level(line));
        let lines: Vec<_> = below.take_while(|(_, line)| !ends(line)).collect();
        assert!(!lines.is_empty(), "{} has no section \"{heading}\"", self.name);
        lines
    }

    /// The rows of all tables below a heading.
    pub fn rows(self, heading: &str) -> Vec<Row> {
        let lines = self.section(heading);
        let is_row = |line: &str| line.starts_with('|');
        let is_rule = |line: &str| line.starts_with("|---");
        let mut rows = Vec::new();
        for (i, (place, line)) in lines.iter().enumerate() {
            let is_head = lines.get(i + 1).is_some_and(|(_, next)| is_rule(next));
            if is_row(line) && !is_rule(line) && !is_head {
                let cells = line.trim_matches('|').split('|').map(str::trim).collect();
                rows.push(Row { place: *place, cells });
            }
        }
        rows
    }
}

/// Fails with everything that was found at once, so that a document is mended in one go.
pub fn conclude(complaints: &[String]) {
    assert!(complaints.is_empty(), "\n{}\n", complaints.join("\n"));
}

/// Compares names in a document with those in the code: what is missing, unknown, or there twice.
pub fn compare(document: &str, what: &str, written: &[String], expected: &[String]) -> Vec<String> {
    let count = |all: &[String], one: &String| all.iter().filter(|other| *other == one).count();
    let mut complaints = Vec::new();
    for one in expected {
        match count(written, one) {
            1 => {}
            0 => complaints.push(format!("{document}: {what} \"{one}\" is missing")),
            n => complaints.push(format!("{document}: {what} \"{one}\" is there {n} times")),
        }
    }
    for one in written.iter().filter(|one| !expected.contains(one)) {
        complaints.push(format!("{document}: {what} \"{one}\" is not in the code"));
    }
    complaints
}
