//! Processor in the loop: the board's image in the emulator, in lock-step with the plant, compared bit for
//! bit with the same firmware run as software.

mod compare;
mod crash;
mod debugger;
mod emulator;
mod process;

use std::path::Path;

use firmware::controller::Core;
use shared::pil::Release;
use shared::telemetry::Record;
use thiserror::Error;

pub use compare::Difference;
use compare::Shown;
pub use crash::{Breakable, Crash, Crashed, Fall, crash};
pub use emulator::{Emulator, End};
pub use process::EmulatorError;

use crate::outcome::Outcome;
use crate::run::{RunError, Software, kept_of};
use crate::scenario::Scenario;
use crate::session::{Controller, Session};

/// Why a comparison could not be finished.
#[derive(Debug, Error)]
pub enum PilError {
    /// The scenario cannot run at all.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The emulator failed.
    #[error(transparent)]
    Emulator(#[from] EmulatorError),
    /// The board was to be broken too late.
    #[error("the run was over before {at_s} s, when the board was to break down")]
    OverBefore {
        /// Since the trajectory's start.
        at_s: f64,
    },
    /// The board went on.
    #[error("the board was to break down and did not")]
    Survived,
}

/// What a comparison found.
#[derive(Debug)]
pub struct Verdict {
    /// The emulated run.
    pub outcome: Outcome,
    /// The first difference; the run ends there.
    pub difference: Option<Difference>,
    /// High-water mark of the board's stack, bytes.
    pub stack_bytes: u16,
}

/// Runs `scenario` on `image` and as software, tick by tick, until the end or the first difference.
///
/// # Errors
/// [`PilError`] where the emulator fails or the controller refuses the scenario.
pub fn run(
    scenario: &Scenario,
    image: &Path,
    progress: &dyn Fn(u64, u64),
) -> Result<Verdict, PilError> {
    let started = std::time::Instant::now();
    let mut board_side = Session::new(scenario, false);
    let mut host_side = Session::new(scenario, false);
    let kept = kept_of(scenario);
    let mut core = Core::new();
    let mut software = Software::new(kept, &host_side.bench(), host_side.retained(), &mut core)?;
    let mut board = Emulator::start(image, kept, board_side.retained(), board_side.bench())?;
    for bench in [board_side.bench(), host_side.bench()] {
        bench.borrow_mut().keep_traffic();
    }
    let mut difference = compare::coefficients(board.coefficients(), &software.parameter_bytes());
    while difference.is_none() && !board_side.is_over() {
        let on_board = board_side.tick(&mut board)?;
        let Ok(on_host) = host_side.tick(&mut software);
        let (done, planned) = board_side.progress();
        difference =
            compare::tick(done - 1, &shown(&board_side, on_board), &shown(&host_side, on_host));
        progress(done, planned);
    }
    let mut outcome = board_side.outcome(started.elapsed().as_secs_f64());
    let End { stack_bytes, evidence } = board.stop()?;
    let difference = difference.or_else(|| compare::evidence(&evidence, software.evidence()));
    outcome.keep_evidence(&evidence);
    Ok(Verdict { outcome, difference, stack_bytes })
}

/// What `side` shows of the tick that left `record`.
fn shown<'a>(side: &'a Session<'_>, record: Record) -> Shown<'a> {
    let traffic = side.bench().borrow_mut().take_traffic();
    Shown { traffic, said: side.said(), record }
}

impl Controller for Emulator {
    type Error = EmulatorError;

    fn tick(&mut self, release: &Release) -> Result<Record, EmulatorError> {
        self.exchange(release)
    }

    fn said(&mut self) -> Vec<u8> {
        self.said()
    }
}
