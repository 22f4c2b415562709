//! Ten runs with random faults, random commands and garbage on the operator link: no reaction is missed, no counter
//! grows beyond its bound, and in the end everything fits together.

mod demand;
mod dice;
mod faults;
mod hand;
mod judge;

use std::convert::Infallible;

use firmware::controller::Core;
use hil_sim::run::{Software, kept_of};
use hil_sim::session::{Controller, Session};
use rayon::prelude::*;
use shared::command::Command;
use shared::fault::{Fault, Mode};
use shared::link::{Counters, Kind, QueryKind, WIRE_BYTES};
use shared::pil::{LINK_BYTES, Release};
use shared::telemetry::Record;

use dice::Dice;
use hand::Hand;
use judge::{Judge, Tally};

/// The last fault is over and what it led to, s.
const END_S: f64 = faults::UNTIL_S + 5.0;
/// Time for a stop or for boot and arming, ticks.
const SETTLED: u32 = 4_000;
/// An arm that is being lowered may take this long, ticks.
const LOWERED: u32 = 200_000;

/// The board behind a link on which there is garbage.
struct Noisy<'m> {
    board: Software<'m>,
    dice: Dice,
    /// A frame that was sent, and comes again or spoilt.
    heard: Vec<u8>,
    /// Frames sent by the console, and pieces of garbage, which are no more than two frames each.
    frames: u64,
    garbage: u64,
    /// Sent before anything else.
    extra: Vec<u8>,
}

impl Controller for Noisy<'_> {
    type Error = Infallible;

    fn tick(&mut self, release: &Release) -> Result<Record, Infallible> {
        let mut bytes = release.link().to_vec();
        self.frames += (bytes.len() / WIRE_BYTES) as u64;
        if bytes.is_empty() {
            bytes = std::mem::take(&mut self.extra);
        } else {
            self.heard = bytes[..WIRE_BYTES].to_vec();
        }
        if self.dice.happens(0.02) && bytes.len() + WIRE_BYTES <= LINK_BYTES {
            self.garbage += 1;
            let mut garbage = match self.dice.below(3) {
                0 => self.heard.clone(),
                1 => {
                    let length = self.dice.below(WIRE_BYTES);
                    self.dice.bytes(length)
                }
                _ => {
                    let mut spoilt = self.heard.clone();
                    let length = spoilt.len().max(1);
                    let (at, byte) = (self.dice.below(length), self.dice.below(256) as u8);
                    spoilt.get_mut(at).into_iter().for_each(|slot| *slot = byte);
                    spoilt
                }
            };
            // In front of what is sent: its zero ends the garbage.
            garbage.extend(bytes);
            bytes = garbage;
        }
        self.board.tick(&release.with_link(&bytes))
    }

    fn said(&mut self) -> Vec<u8> {
        self.board.said()
    }
}

/// A run under judgement.
struct Run<'a> {
    session: Session<'a>,
    board: Noisy<'a>,
    judge: Judge,
    happened: usize,
}

impl Run<'_> {
    fn step(&mut self, command: Option<Command>) -> Record {
        if let Some(command) = command {
            self.judge.told(&command);
            self.session.order(command);
        }
        let Ok(record) = self.session.tick(&mut self.board);
        let events = self.session.happenings()[self.happened..].iter().map(|one| one.event);
        let tape = self.session.tape().expect("it is kept");
        self.judge.see(tape.frames.last().expect("a step"), events);
        self.happened = self.session.happenings().len();
        record
    }

    /// Steps on until `mode`, at most so many.
    fn until(&mut self, mode: Mode, most: u32) -> Record {
        let mut record = self.step(None);
        for _ in 0..most {
            if record.mode == mode as u8 {
                break;
            }
            record = self.step(None);
        }
        record
    }

    /// Stops the arm, if it is not stopped yet, and sees it at rest.
    fn stop(&mut self) -> Record {
        // In boot nothing has to be stopped; an encoder that failed may have left a wrong pose behind.
        let mut record = self.step(None);
        for i in 0..SETTLED {
            if record.mode != Mode::Boot as u8 {
                break;
            }
            record = self.step((i % 100 == 99).then_some(Command::ConfirmPose));
        }
        self.step(Some(Command::Stop));
        self.until(Mode::Latched, LOWERED);
        (0..SETTLED).for_each(|_| _ = self.step(None));
        let frame = *self.session.tape().and_then(|tape| tape.frames.last()).expect("a step");
        let open = self.session.plant().brake_released();
        self.judge.see_end(&frame, open);
        frame.record
    }

    /// A sound arm comes back, and can be stopped again.
    fn revive(&mut self, last: Record) {
        let locked = [Fault::BrakeSlipped, Fault::ParametersLost];
        if locked.iter().any(|fault| last.fault == *fault as u16) {
            return;
        }
        self.step(Some(Command::Clear));
        self.until(Mode::Standby, SETTLED / 4);
        self.step(Some(Command::ConfirmPose));
        let ready = self.until(Mode::Standby, SETTLED);
        self.step(Some(Command::Arm));
        let closed = self.session.bench().borrow().chain_closed();
        let holds = self.until(Mode::Holding, SETTLED);
        if ready.mode != Mode::Standby as u8 || closed != (holds.mode == Mode::Holding as u8) {
            self.judge.complaints.push(format!("no way back: {ready:?}, {holds:?}, {closed}"));
        }
        self.stop();
    }

    /// What the board counted on its link is no more than what was sent.
    fn count(&mut self) {
        let query = self.session.console().query(QueryKind::Counters, 0);
        self.session.console().heard();
        self.board.extra = query.to_wire().to_vec();
        (0..100).for_each(|_| _ = self.step(None));
        let heard = self.session.console().heard();
        let Some(frame) = heard.iter().find(|frame| frame.kind == Kind::Counters as u8) else {
            self.judge.complaints.push("the board does not tell its counters".into());
            return;
        };
        let c: Counters = frame.payload();
        let refused = c.malformed + c.unauthentic + c.stale + c.meaningless;
        // A piece of garbage is cut by its own zeros into as many frames as it has.
        let sent = self.board.frames + 1 + self.board.garbage * WIRE_BYTES as u64;
        let fits = u64::from(c.taken) <= self.board.frames + 1
            && u64::from(c.taken + refused) <= sent
            && c.refused <= c.orders
            && c.orders <= c.taken
            && refused > 0;
        if !fits {
            self.judge.complaints.push(format!("{c:?} of {sent} frames"));
        }
    }
}

/// One run; what it came to, and what was wrong.
fn run(seed: u64) -> (Tally, Vec<String>) {
    let mut dice = Dice::new(seed);
    let scenario = faults::scenario(&mut dice, seed);
    let mut session = Session::new(&scenario, false);
    session.keep_tape();
    let mut core = Core::new();
    let (kept, bench) = (kept_of(&scenario), session.bench());
    let board = Software::new(kept, &bench, session.retained(), &mut core).expect("a good one");
    let (heard, extra) = (Vec::new(), Vec::new());
    let noise = Dice::new(!seed);
    let board = Noisy { board, dice: noise, heard, frames: 0, garbage: 0, extra };
    let mut run = Run { session, board, judge: Judge::default(), happened: 0 };
    let mut hand = Hand::default();
    let mut last = Record::default();
    loop {
        let since_s = run.session.start_s().map(|start_s| {
            run.session.tape().and_then(|t| t.frames.last()).map_or(0.0, |f| f.true_s) - start_s
        });
        let command = match since_s {
            Some(s) if s > END_S => break,
            Some(_) => hand.command(&mut dice, &last),
            // Before the first path the session's own operator arms and starts.
            None => {
                if matches!(Mode::from_number(last.mode), Some(Mode::Standby)) {
                    run.judge.told(&Command::Arm);
                }
                None
            }
        };
        last = run.step(command);
    }
    let last = run.stop();
    run.revive(last);
    run.count();
    (run.judge.tally, run.judge.complaints)
}

#[test]
fn ten_runs_with_random_faults_and_commands_miss_no_reaction() {
    let runs = (1..=10_u64).into_par_iter().map(|seed| (seed, run(seed))).collect::<Vec<_>>();
    let mut wrong = 0;
    for (seed, (tally, complaints)) in &runs {
        println!("seed {seed}: {tally:?}");
        complaints.iter().take(5).for_each(|complaint| println!("  {complaint}"));
        wrong += complaints.len();
    }
    assert_eq!(wrong, 0, "complaints");
    let busy = |tally: &Tally| tally.faults > 40 && tally.demands > 10 && tally.arms > 10;
    assert!(runs.iter().all(|(_, (tally, _))| busy(tally)), "too little happened");
}
