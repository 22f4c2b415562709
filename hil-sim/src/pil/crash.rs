//! The board breaks down in the middle of a run: its own code takes a hard fault, switches off, resets itself.

use std::cell::RefCell;
use std::fs;
use std::io;
use std::path::Path;
use std::rc::Rc;

use firmware::executive::Retained;
use object::{Object, ObjectSymbol};
use shared::evidence::Image;
use shared::pil::Release;
use shared::telemetry::Record;
use tempfile::TempDir;

use super::debugger::Debugger;
use super::{Emulator, EmulatorError, End, PilError};
use crate::bench::{Bench, OutputLevels};
use crate::run::{Kept, kept_of};
use crate::scenario::Scenario;
use crate::session::{Controller, Session, Tape};

/// How the board breaks down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Crash {
    /// The tick jumps to where no code is.
    HardFault,
    /// The tick begins with next to no stack left.
    StackOverflow,
}

/// Where nothing can be executed (Armv7-M ARM B3.1, system address map).
const NO_CODE: u32 = 0xF000_0000;
/// Stack that is left, bytes: enough for the first few calls.
const LAST_STACK_BYTES: u32 = 256;
/// Numbers of the core registers.
const SP: u8 = 13;
const PC: u8 = 15;

/// The board with its debugging port: it can be broken at the entry of any tick. The image is the ordinary one.
pub struct Breakable {
    board: Emulator,
    bench: Rc<RefCell<Bench>>,
    debugger: Debugger,
    /// Addresses in the image.
    places: Places,
    /// Breaks in the next tick.
    due: Option<Crash>,
    last: Record,
    fall: Option<Fall>,
    _folder: TempDir,
}

/// Addresses in an image.
#[derive(Clone, Copy, Debug)]
struct Places {
    /// Function that a board passes through on [`shared::pil::HALT`] only.
    halt: u32,
    /// Function that is the tick.
    tick: u32,
    /// Lowest byte of the stack.
    stack_end: u32,
}

/// What a crash looked like from outside.
#[derive(Clone, Copy, Debug)]
pub struct Fall {
    /// Last record before it.
    pub last: Record,
    /// Fault status register (Armv7-M ARM B3.2.15, CFSR).
    pub status: u32,
    /// Output pins as the fault's handler left them, before the reset.
    pub pins: OutputLevels,
}

impl Breakable {
    /// Starts `image` as [`Emulator::start`] does.
    ///
    /// # Errors
    /// [`EmulatorError`] where it does not come up.
    pub fn start(
        image: &Path,
        kept: impl Into<Kept>,
        retained: Retained,
        bench: Rc<RefCell<Bench>>,
    ) -> Result<Self, EmulatorError> {
        let [halt, tick, stack_end] = addresses(image, ["halt", "tick", "_stack_end"])?;
        let folder = tempfile::tempdir()?;
        let port = folder.path().join("port");
        let gdb = format!("unix:{},server=on,wait=off", port.display());
        let arguments = ["-S".into(), "-gdb".into(), gdb];
        let mut board =
            Emulator::spawn(image, kept.into(), retained, Rc::clone(&bench), &arguments)?;
        let mut debugger = Debugger::connect(&port)?;
        debugger.set_breakpoint(halt)?;
        debugger.go_on()?;
        board.introduce()?;
        let (due, last, fall) = (None, Record::default(), None);
        let (places, _folder) = (Places { halt, tick, stack_end }, folder);
        Ok(Self { board, bench, debugger, places, due, last, fall, _folder })
    }

    /// Breaks the board in the next tick; once. That tick leaves no record: the controller gives the last one again,
    /// and the next tick is the first after the board's reset.
    pub fn crash(&mut self, crash: Crash) {
        self.due = Some(crash);
    }

    /// What the last crash looked like, if there was one.
    pub fn fall(&self) -> Option<&Fall> {
        self.fall.as_ref()
    }

    /// See [`Emulator::stop`].
    ///
    /// # Errors
    /// As there.
    pub fn stop(self) -> Result<End, EmulatorError> {
        self.board.stop()
    }

    /// Lets the board begin its tick and breaks it there.
    fn break_down(&mut self, crash: Crash, release: &Release) -> Result<(), EmulatorError> {
        let Places { halt, tick, stack_end } = self.places;
        self.board.halt()?;
        self.debugger.await_stop()?;
        self.debugger.clear_breakpoint(halt)?;
        self.debugger.set_breakpoint(tick)?;
        self.debugger.go_on()?;
        self.board.release(release)?;
        self.debugger.await_stop()?;
        self.debugger.clear_breakpoint(tick)?;
        match crash {
            Crash::HardFault => self.debugger.set_register(PC, NO_CODE)?,
            Crash::StackOverflow => {
                self.debugger.set_register(SP, stack_end + LAST_STACK_BYTES)?;
            }
        }
        Ok(self.debugger.go_on()?)
    }

    /// A tick that breaks down, and the boot after it.
    fn fall_down(&mut self, crash: Crash, release: &Release) -> Result<Record, EmulatorError> {
        self.break_down(crash, release)?;
        let status = match self.board.serve() {
            Err(EmulatorError::Fault { status }) => status,
            other => return other,
        };
        let pins = self.bench.borrow().outputs;
        self.fall = Some(Fall { last: self.last, status, pins });
        self.bench.borrow_mut().let_go();
        self.board.introduce()?;
        Ok(self.last)
    }
}

impl Controller for Breakable {
    type Error = EmulatorError;

    fn tick(&mut self, release: &Release) -> Result<Record, EmulatorError> {
        if let Some(crash) = self.due.take() {
            return self.fall_down(crash, release);
        }
        self.last = self.board.exchange(release)?;
        Ok(self.last)
    }

    fn said(&mut self) -> Vec<u8> {
        self.board.said()
    }
}

/// Addresses of symbols of `image`.
fn addresses<const N: usize>(image: &Path, names: [&str; N]) -> Result<[u32; N], EmulatorError> {
    let path = image.display().to_string();
    let data = fs::read(image).map_err(|_| EmulatorError::NoImage { path: path.clone() })?;
    let elf = object::File::parse(&*data).map_err(io::Error::other)?;
    let mut found = [0; N];
    for (slot, name) in found.iter_mut().zip(names) {
        let missing = || io::Error::other(format!("{path} has no symbol `{name}`"));
        // The lowest bit of a function's address says Thumb.
        *slot = elf.symbol_by_name(name).ok_or_else(missing)?.address() as u32 & !1;
    }
    Ok(found)
}

/// A run in which the board broke down.
#[derive(Debug)]
pub struct Crashed {
    /// The whole run.
    pub tape: Tape,
    /// Index of the frame in which the board broke down.
    pub at: usize,
    /// What that looked like.
    pub fall: Fall,
    /// What the board kept.
    pub evidence: Box<Image>,
}

/// Runs `scenario` on `image`, breaks the board `at_s` after the trajectory's start, and goes on for another `for_s`
/// with the board as it comes up again; nobody clears it.
///
/// # Errors
/// [`PilError`] where the emulator fails, or the run ends before the crash.
pub fn crash(
    scenario: &Scenario,
    image: &Path,
    crash: Crash,
    at_s: f64,
    for_s: f64,
) -> Result<Crashed, PilError> {
    let mut session = Session::new(scenario, false);
    session.keep_tape();
    let kept = kept_of(scenario);
    let mut board = Breakable::start(image, kept, session.retained(), session.bench())?;
    let ticks = |seconds: f64| (seconds * f64::from(scenario.tick_hz)).round() as usize;
    let frames =
        |session: &Session<'_>| session.tape().map_or((0, None), |t| (t.frames.len(), t.start));
    let at = loop {
        if let (now, Some(start)) = frames(&session)
            && now >= start + ticks(at_s)
        {
            break now;
        }
        if session.is_over() {
            return Err(PilError::OverBefore { at_s });
        }
        session.tick(&mut board)?;
    };
    board.crash(crash);
    for _ in 0..=ticks(for_s) {
        session.tick(&mut board)?;
    }
    let fall = *board.fall().ok_or(PilError::Survived)?;
    let tape = session.tape().cloned().unwrap_or_default();
    Ok(Crashed { tape, at, fall, evidence: board.stop()?.evidence })
}
