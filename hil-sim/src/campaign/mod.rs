//! The fault campaign: every row of the fault table in every pose, measured against what it must come to.
//!
//! A cell is one way of a row's fault in one pose. It is run from power-up through arming and a path into the fault,
//! until the arm has stood still for a second; beside it a twin that must not trip, and the run that the tip's height
//! is compared with.

mod bound;
mod case;
mod judge;
mod measure;
mod onset;
mod pose;
mod row;
mod rows;
#[cfg(test)]
mod synthetic;
mod table;
mod trial;
mod verdict;
mod witness;

use std::path::PathBuf;

use rayon::prelude::*;
use serde::Serialize;

use crate::scenario::Scenario;

pub use measure::Reaction;
pub use pose::{Pose, PoseError};
pub use table::{HEADER, OVERVIEW_HEADER, line, overview, table};
pub use verdict::{Point, Verdict};

use case::Case;
use row::Variant;
use rows::{ROWS, pairs};

/// Numbers of the table's rows.
pub const NUMBERS: std::ops::RangeInclusive<u8> = 1..=27;

/// One way of a row's fault in one pose, and what came of it.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Number of the row.
    pub row: u8,
    /// Its title.
    pub title: &'static str,
    /// Name of the pose.
    pub pose: String,
    /// The way.
    pub variant: String,
    /// What came of it.
    pub verdict: Verdict,
}

/// A row that makes no sense in a pose.
#[derive(Clone, Debug)]
pub struct Left {
    /// Number of the row.
    pub row: u8,
    /// Name of the pose.
    pub pose: String,
    /// Why not.
    pub why: &'static str,
}

/// All of a campaign.
#[derive(Clone, Debug)]
pub struct Campaign {
    /// First seed of every cell.
    pub seed: u64,
    /// Cells in the table's order.
    pub cells: Vec<Cell>,
    /// What was left out.
    pub left: Vec<Left>,
}

/// Cells that are to be run.
struct Work {
    row: u8,
    pose: Pose,
    variant: Variant,
}

/// What to run, and how.
#[derive(Clone, Debug)]
pub struct Options {
    /// This row alone.
    pub only: Option<u8>,
    /// First seed of every cell.
    pub seed: u64,
    /// The emulated board's image.
    pub image: PathBuf,
}

/// Runs the campaign; `progress` is told the cells done and the cells planned.
///
/// # Errors
/// Where the poses cannot be used.
pub fn run(options: &Options, progress: &(dyn Fn(u64, u64) + Sync)) -> Result<Campaign, PoseError> {
    let Options { only, seed, ref image } = *options;
    let (works, left) = planned(only)?;
    let done = std::sync::atomic::AtomicU64::new(0);
    let cells = works.par_iter().map(|work| {
        let verdict = judge::judge(&work.variant, &work.pose, seed, image);
        let done = 1 + done.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        progress(done, works.len() as u64);
        Cell {
            row: work.row,
            title: ROWS[usize::from(work.row) - 1].title,
            pose: work.pose.name.clone(),
            variant: work.variant.name.clone(),
            verdict,
        }
    });
    Ok(Campaign { seed, cells: cells.collect(), left })
}

fn planned(only: Option<u8>) -> Result<(Vec<Work>, Vec<Left>), PoseError> {
    let (mut works, mut left) = (Vec::new(), Vec::new());
    let poses = Pose::all()?;
    for row in ROWS.iter().filter(|row| only.is_none_or(|only| only == row.number)) {
        for pose in &poses {
            match (row.variants)(pose) {
                Ok(ways) => {
                    let of_pairs =
                        pairs(pose).into_iter().filter(|(number, _)| *number == row.number);
                    let all = ways.into_iter().chain(of_pairs.map(|(_, way)| way));
                    works.extend(all.map(|variant| Work {
                        row: row.number,
                        pose: pose.clone(),
                        variant,
                    }));
                }
                Err(why) => left.push(Left { row: row.number, pose: pose.name.clone(), why }),
            }
        }
    }
    Ok((works, left))
}

/// Ways of a row in a pose as scenarios, by their names: what can be run anywhere, as no orders belong to it.
///
/// # Errors
/// Where the poses cannot be used.
pub fn scenarios(row: u8, pose: &str, seed: u64) -> Result<Vec<(String, Scenario)>, PoseError> {
    let (works, _) = planned(Some(row))?;
    let works = works.iter().filter(|work| work.pose.name == pose);
    let plans = works.map(|work| {
        let case = Case { variant: &work.variant, pose: &work.pose, seed };
        (work.variant.name.clone(), case.faulty())
    });
    let plain = plans.filter(|(_, plan)| plan.orders.is_empty());
    Ok(plain.map(|(name, plan)| (name, plan.scenario)).collect())
}

impl Campaign {
    /// Cells that pass.
    pub fn passed(&self) -> usize {
        self.cells.iter().filter(|cell| cell.verdict.passes()).count()
    }

    /// As JSON.
    pub fn json(&self) -> Json<'_> {
        let rows = self.cells.iter().map(|cell| {
            let v = &cell.verdict;
            JsonRow {
                fault: cell.row,
                pose: &cell.pose,
                reaction: v.reaction.name(),
                detect_ticks: v.detect_ticks,
                react_ticks: v.react_ticks,
                drop_m: v.drop_m,
                bound_m: v.bound_m,
                twin_tripped: v.twin_tripped,
                pass: v.passes(),
            }
        });
        Json { rows: rows.collect(), passed: self.passed(), total: self.cells.len() }
    }
}

/// A campaign for machines.
#[derive(Debug, Serialize)]
pub struct Json<'a> {
    rows: Vec<JsonRow<'a>>,
    passed: usize,
    total: usize,
}

#[derive(Debug, Serialize)]
struct JsonRow<'a> {
    fault: u8,
    pose: &'a str,
    reaction: &'static str,
    detect_ticks: Option<u32>,
    react_ticks: Option<u32>,
    drop_m: f64,
    bound_m: f64,
    twin_tripped: bool,
    pass: bool,
}
