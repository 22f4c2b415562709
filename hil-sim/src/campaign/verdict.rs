//! What a cell showed.

use shared::fault::Fault;
use shared::telemetry::PATH_RATE_ONE;

use super::measure::{self, Reaction, Track};
use super::trial::{TICK_S, Trial};

/// What a cell showed.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// What was done.
    pub reaction: Reaction,
    /// Ticks to the sign, if there had to be one and it came.
    pub detect_ticks: Option<u32>,
    /// Ticks to the reaction.
    pub react_ticks: Option<u32>,
    /// How far the tip sank, m.
    pub drop_m: f64,
    /// How far it might, m.
    pub bound_m: f64,
    /// The twin was stopped.
    pub twin_tripped: bool,
    /// The fault that was reported.
    pub fault: Fault,
    /// What fell short, each as a sentence.
    pub short: Vec<String>,
    /// From shortly before the fault on, for the picture.
    pub curve: Vec<Point>,
}

/// A point of a cell's picture.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Since the fault's condition is complete, s.
    pub t_s: f64,
    /// How far the tip is below its reference, m.
    pub sinking_m: f64,
    /// Rate at which the path is followed.
    pub path_rate: f64,
}

/// Drop that is allowed where the table says 5 mm, m.
pub const TIGHT_M: f64 = 5e-3;
/// Drop, or distance from the run without the fault, that counts as none, m.
pub const ZERO_M: f64 = 1e-4;

impl Verdict {
    /// Of a cell that could not be run.
    pub fn not_run(why: &str) -> Self {
        Self {
            reaction: Reaction::None,
            detect_ticks: None,
            react_ticks: None,
            drop_m: 0.0,
            bound_m: TIGHT_M,
            twin_tripped: false,
            fault: Fault::None,
            short: vec![format!("not run: {why}")],
            curve: Vec::new(),
        }
    }

    /// Whether nothing fell short.
    pub fn passes(&self) -> bool {
        self.short.is_empty()
    }
}

/// Before the fault, s.
const BEFORE_S: f64 = 0.05;
/// Longest stretch of a picture, s.
const SHOWN_S: f64 = 1.0;
/// Each tick is drawn for this long after the fault, s, then one in so many.
const CLOSELY_S: f64 = 0.02;
/// See [`CLOSELY_S`].
const EVERY: usize = 20;

/// The picture of a run whose fault is complete at step `from`.
pub fn curve(trial: &Trial, from: usize, reference: &Track, by_ticks: bool) -> Vec<Point> {
    let first = from.saturating_sub((BEFORE_S / TICK_S) as usize);
    let sinking = measure::sinking(trial, first, reference, by_ticks);
    let zero_s = trial.frames[from].true_s;
    let points = trial.frames[first..].iter().zip(sinking).enumerate();
    points
        .map(|(i, (frame, sinking_m))| {
            let path_rate = f64::from(frame.record.path_rate) / f64::from(PATH_RATE_ONE);
            (i, Point { t_s: frame.true_s - zero_s, sinking_m, path_rate })
        })
        .take_while(|(_, point)| point.t_s < SHOWN_S)
        .filter(|(i, point)| (0.0..CLOSELY_S).contains(&point.t_s) || i % EVERY == 0)
        .map(|(_, point)| point)
        .collect()
}
