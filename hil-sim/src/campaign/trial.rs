//! One run of the campaign: a pose with faults and orders in it, from power-up until the arm has stood still for a
//! second.

use firmware::controller::Core;
use shared::arm::JOINTS;
use shared::command::{Command, Trajectory};
use shared::fault::Mode;

use super::witness::{Seen, Witness};
use crate::path::Path;
use crate::run::{RunError, Software, arm_of, kept_of};
use crate::scenario::Scenario;
use crate::session::{Event, Frame, Session, Tape};

/// One tick, s.
pub const TICK_S: f64 = 0.5e-3;
/// Ticks a second.
pub const TICK_HZ: u32 = 2_000;
/// The run goes on this long after the arm has come to rest, s.
const REST_S: f64 = 1.0;
/// And no longer than this after its path and all its orders, s.
const PATIENCE_S: f64 = 3.0;
/// Longer while the arm is lowered, at a tenth of the speed, but not beyond this, s.
const LOWERING_S: f64 = 120.0;
/// Boot and arming before the path, s.
const START_UP_S: f64 = 3.0;
/// Traffic is read from this long before t = 0 of the fault on, s.
const FORESIGHT_S: f64 = 0.01;

/// What an operator asks for.
#[derive(Clone, Copy, Debug)]
pub enum Ask {
    /// This.
    Plain(Command),
    /// The path once more, as it was planned before the start, changed.
    Path(fn(&mut Trajectory)),
}

/// An order with its time since the path's start, s.
#[derive(Clone, Copy, Debug)]
pub struct Order {
    /// When.
    pub at_s: f64,
    /// What.
    pub ask: Ask,
}

/// What to run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Pose, path, faults.
    pub scenario: Scenario,
    /// Beside arming and starting the path.
    pub orders: Vec<Order>,
    /// Run the whole path although the arm stands still before.
    pub whole: bool,
}

/// What a run left behind.
#[derive(Debug)]
pub struct Trial {
    /// From power-up on, step by step.
    pub frames: Vec<Frame>,
    /// Traffic of each step, where it was read.
    pub seen: Vec<Seen>,
    /// Feedback contacts of the brakes at each step.
    pub brakes_open: Vec<[bool; JOINTS]>,
    /// Index of the step at the path's start.
    pub start: Option<usize>,
    /// From power-up to the path's start, s.
    pub start_s: Option<f64>,
    /// Times since power-up and events.
    pub events: Vec<(f64, Event)>,
}

/// A run, or the controller's refusal of its configuration.
///
/// # Errors
/// [`RunError::Config`].
pub fn run(plan: &Plan) -> Result<Trial, RunError> {
    let scenario = &plan.scenario;
    let mut session = Session::new(scenario, false);
    session.keep_tape();
    let mut core = Core::new();
    let bench = session.bench();
    let mut software = Software::new(kept_of(scenario), &bench, session.retained(), &mut core)?;
    let witness = Witness::new(&arm_of(scenario));
    let path = Path::of(scenario).command(&arm_of(scenario));
    let watch_s =
        scenario.faults.iter().map(|fault| fault.at_s).fold(f64::INFINITY, f64::min) - FORESIGHT_S;
    let mut orders = plan.orders.iter().peekable();
    let (mut seen, mut brakes_open) = (Vec::new(), Vec::new());
    let mut ends = Ends::new(plan);
    let mut watched = false;
    loop {
        let t_s = next_s(&session);
        if let Some(order) =
            orders.next_if(|order| t_s.is_some_and(|t_s| t_s > order.at_s - 0.5 * TICK_S))
        {
            session.order(order.ask.command(&path));
        }
        if !watched && (watch_s < -1.0 || t_s.is_some_and(|t_s| t_s > watch_s)) {
            bench.borrow_mut().keep_traffic();
            watched = true;
        }
        let Ok(_) = session.tick(&mut software);
        seen.push(witness.see(&bench.borrow_mut().take_traffic()));
        brakes_open.push(bench.borrow().brake_open);
        let Some(last) = session.tape().and_then(|tape| tape.frames.last()) else { break };
        if ends.at(last, session.start_s()) {
            break;
        }
    }
    let tape = session.tape().cloned().unwrap_or_default();
    let events = session.happenings().iter().map(|one| (one.true_s, one.event)).collect();
    Ok(Trial {
        frames: tape.frames,
        seen,
        brakes_open,
        start: tape.start,
        start_s: session.start_s(),
        events,
    })
}

/// Time of the coming step since the path's start, s.
fn next_s(session: &Session<'_>) -> Option<f64> {
    let last = session.tape().and_then(|tape| tape.frames.last())?;
    Some(last.true_s + TICK_S - session.start_s()?)
}

impl Ask {
    fn command(self, path: &Trajectory) -> Command {
        match self {
            Self::Plain(command) => command,
            Self::Path(change) => {
                let mut path = *path;
                change(&mut path);
                Command::Start(path)
            }
        }
    }
}

/// When a run is over.
struct Ends {
    /// Not before this after the start, s.
    earliest_s: f64,
    /// An arm that holds its pose has stood still for a second then, s.
    armed_s: f64,
    /// After this in any case, s.
    latest_s: f64,
    still: u32,
}

impl Ends {
    fn new(plan: &Plan) -> Self {
        let Scenario { faults, duration_s, trajectory, .. } = &plan.scenario;
        let faults = faults.iter().map(|fault| fault.at_s + fault.for_s.unwrap_or(0.0));
        let orders = plan.orders.iter().map(|order| order.at_s);
        let path_s = if plan.whole { *duration_s } else { 0.0 };
        let earliest_s = faults.chain(orders).fold(path_s, f64::max);
        let moves = trajectory.amplitude.iter().any(|a| *a != 0.0);
        let armed_s = earliest_s.max(*duration_s) + if moves { REST_S } else { 0.0 };
        Self { earliest_s, armed_s, latest_s: armed_s + PATIENCE_S, still: 0 }
    }

    fn at(&mut self, last: &Frame, start_s: Option<f64>) -> bool {
        self.still = if is_safe(last) && is_still(last) { self.still + 1 } else { 0 };
        let Some(start_s) = start_s else { return last.true_s > START_UP_S };
        let t_s = last.true_s - start_s;
        let mode = Mode::from_number(last.record.mode);
        let rested = f64::from(self.still) * TICK_S > REST_S && t_s > self.earliest_s;
        let armed = mode == Some(Mode::Holding) && t_s >= self.armed_s;
        if mode == Some(Mode::Lowering) && t_s < LOWERING_S {
            self.latest_s = self.latest_s.max(t_s + PATIENCE_S);
        }
        rested || armed || t_s > self.latest_s
    }
}

/// Whether no torque can flow and no brake is held open.
pub fn is_safe(frame: &Frame) -> bool {
    let pins = &frame.pins;
    frame.torque == [0.0; JOINTS]
        && (!frame.chain_closed
            || !pins.sto
            || (pins.drive_enable == [false; JOINTS] && pins.brake_release == [false; JOINTS]))
}

/// Whether every joint stands in its brake.
pub fn is_still(frame: &Frame) -> bool {
    frame.qd == [0.0; JOINTS]
}

impl Trial {
    /// A run of which only the tape is known.
    pub fn of_tape(tape: Tape) -> Self {
        let count = tape.frames.len();
        Self {
            start_s: tape.start.map(|start| tape.frames[start].true_s),
            start: tape.start,
            frames: tape.frames,
            seen: vec![Seen::default(); count],
            brakes_open: vec![[false; JOINTS]; count],
            events: Vec::new(),
        }
    }

    /// Index of the first step at or after `t_s` since the start.
    pub fn index_at(&self, t_s: f64) -> usize {
        let from_s = self.start_s.unwrap_or(0.0) + t_s - 0.1 * TICK_S;
        self.frames.partition_point(|frame| frame.true_s < from_s)
    }

    /// Index of the first step with a tick, at `index` or later.
    pub fn ticked_from(&self, index: usize) -> Option<usize> {
        (index..self.frames.len()).find(|i| self.frames[*i].ticked)
    }

    /// Periods from one step to another, the first counting as one.
    pub fn ticks(&self, from: usize, to: usize) -> u32 {
        let passed_s = self.frames[to].true_s - self.frames[from].true_s;
        (passed_s / TICK_S).round() as u32 + 1
    }
}
