//! Run folder: summary.json, log.csv and report.html; after a fault, evidence.csv and evidence.json.

mod arm_view;
mod axis;
mod campaign;
mod evidence;
mod figures;
mod log;
mod page;
mod plot;
mod style;
mod table;

use std::collections::HashSet;
use std::fs::{self, File};
use std::io::{BufWriter, ErrorKind};
use std::path::{Path, PathBuf};

pub use campaign::write_campaign;
use clap::ValueEnum;
pub use table::table3;

use crate::outcome::{Adaptation, Law, Outcome};

/// Joint-wise units of position, speed and effort; joint 4 is prismatic.
const POSITION: [&str; shared::arm::JOINTS] = ["rad", "rad", "rad", "m"];
const SPEED: [&str; shared::arm::JOINTS] = ["rad/s", "rad/s", "rad/s", "m/s"];
const EFFORT: [&str; shared::arm::JOINTS] = ["N m", "N m", "N m", "N"];

/// Why a run folder could not be written.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// There is nothing to report.
    #[error("a report needs at least one run")]
    Empty,
    /// Two runs would share a log file and a legend entry.
    #[error("two runs of one report have the same controller: {0}")]
    SameController(&'static str),
    /// The folder or a file of it could not be written.
    #[error("cannot write {}", path.display())]
    Io {
        /// What was to be written.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// A figure could not be drawn.
    #[error("cannot draw \"{figure}\": {reason}")]
    Plot {
        /// Title of the figure.
        figure: String,
        /// What the plotter said.
        reason: String,
    },
}

/// Writes the run folder `dir` (made if missing) and returns the path of `report.html`.
///
/// `summary.json` is one object for one run and an array for more. `log.csv` has a row a tick; with
/// several runs each has its own `log-<law>-<adaptation>.csv`, and so with what [`write_evidence`] writes.
pub fn write(dir: &Path, outcomes: &[Outcome]) -> Result<PathBuf, ReportError> {
    check(outcomes)?;
    let html = page::render(outcomes)?;
    fs::create_dir_all(dir).map_err(at(dir))?;
    clear(dir)?;
    write_summary(&dir.join("summary.json"), outcomes)?;
    for outcome in outcomes {
        let path = dir.join(file_name("log", outcome, outcomes.len(), "csv"));
        log::write(&path, outcome).map_err(at(&path))?;
        write_evidence_as(dir, outcome, outcomes.len())?;
    }
    let path = dir.join("report.html");
    fs::write(&path, html).map_err(at(&path))?;
    Ok(path)
}

/// Removes what an earlier run has written, so that nobody takes it for this one's.
fn clear(dir: &Path) -> Result<(), ReportError> {
    let laws = Law::value_variants().iter().map(|law| value_name(*law));
    let adaptations = || Adaptation::value_variants().iter().map(|one| value_name(*one));
    let of_one = laws.flat_map(|law| adaptations().map(move |one| format!("-{law}-{one}")));
    for run in of_one.chain([String::new()]) {
        for (what, ending) in [("log", "csv"), ("evidence", "csv"), ("evidence", "json")] {
            let path = dir.join(format!("{what}{run}.{ending}"));
            match fs::remove_file(&path) {
                Err(error) if error.kind() != ErrorKind::NotFound => return Err(at(&path)(error)),
                _ => {}
            }
        }
    }
    Ok(())
}

/// Writes what the controller kept, if the run ended in a fault, into `dir` (made if missing): `evidence.csv` with
/// the ticks, whose path it returns, and `evidence.json` with the errors.
pub fn write_evidence(dir: &Path, outcome: &Outcome) -> Result<Option<PathBuf>, ReportError> {
    if outcome.evidence.is_some() {
        fs::create_dir_all(dir).map_err(at(dir))?;
    }
    write_evidence_as(dir, outcome, 1)
}

fn write_evidence_as(
    dir: &Path,
    outcome: &Outcome,
    runs: usize,
) -> Result<Option<PathBuf>, ReportError> {
    let Some(image) = &outcome.evidence else { return Ok(None) };
    let [ticks, errors] =
        ["csv", "json"].map(|ending| dir.join(file_name("evidence", outcome, runs, ending)));
    evidence::write_ticks(&ticks, image).map_err(at(&ticks))?;
    evidence::write_summary(&errors, image).map_err(at(&errors))?;
    Ok(Some(ticks))
}

fn check(outcomes: &[Outcome]) -> Result<(), ReportError> {
    if outcomes.is_empty() {
        return Err(ReportError::Empty);
    }
    let mut seen = HashSet::new();
    match outcomes.iter().map(Outcome::label).find(|label| !seen.insert(*label)) {
        Some(label) => Err(ReportError::SameController(label)),
        None => Ok(()),
    }
}

fn write_summary(path: &Path, outcomes: &[Outcome]) -> Result<(), ReportError> {
    let file = BufWriter::new(File::create(path).map_err(at(path))?);
    match outcomes {
        [outcome] => serde_json::to_writer_pretty(file, outcome),
        _ => serde_json::to_writer_pretty(file, outcomes),
    }
    .map_err(|error| at(path)(error.into()))
}

fn file_name(what: &str, outcome: &Outcome, runs: usize, ending: &str) -> String {
    if runs == 1 {
        return format!("{what}.{ending}");
    }
    let (law, adaptation) = (value_name(outcome.law), value_name(outcome.adaptation));
    format!("{what}-{law}-{adaptation}.{ending}")
}

fn value_name(value: impl ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |named| named.get_name().into())
}

fn at(path: &Path) -> impl FnOnce(std::io::Error) -> ReportError {
    move |source| ReportError::Io { path: path.into(), source }
}
