//! A short motion with faults in it, kept on tape.

use std::convert::Infallible;

use firmware::controller::Core;
use hil_sim::faults::Injection;
use hil_sim::run::{Software, kept_of};
use hil_sim::scenario::Scenario;
use hil_sim::session::{Controller, Event, Frame, Session, Tape};
use shared::command::Command;
use shared::fault::{Fault, Mode};
use shared::pil::Release;
use shared::telemetry::Record;

const TICK_HZ: f64 = 2_000.0;
/// One tick, s.
pub const TICK_S: f64 = 1.0 / TICK_HZ;

/// A lift of one second.
pub fn lift(faults: &[Injection]) -> Scenario {
    scenario("[0, 0.01, 0.02, -0.1]", faults)
}

/// The same time at rest.
pub fn rest(faults: &[Injection]) -> Scenario {
    scenario("[0, 0, 0, 0]", faults)
}

fn scenario(amplitude: &str, faults: &[Injection]) -> Scenario {
    let text = format!(
        "summary = \"a short motion\"\nduration_s = 1\nsettle_s = 0.1\n\
         [trajectory]\nprofile = \"quintic\"\namplitude = {amplitude}\n"
    );
    let scenario = Scenario::parse("short.toml", &text).expect("all is in range");
    Scenario { faults: faults.to_vec(), ..scenario }
}

/// Software that remembers how its ticks were opened.
struct Listener<'m> {
    software: Software<'m>,
    releases: Vec<Release>,
}

impl Controller for Listener<'_> {
    type Error = Infallible;

    fn tick(&mut self, release: &Release) -> Result<Record, Infallible> {
        self.releases.push(*release);
        self.software.tick(release)
    }

    fn said(&mut self) -> Vec<u8> {
        self.software.said()
    }
}

/// What a run left behind.
pub struct Run {
    pub tape: Tape,
    /// One a tick.
    pub releases: Vec<Release>,
    pub events: Vec<(f64, Event)>,
    /// Payload and locked brakes at the end.
    pub payload_kg: f64,
    start_s: f64,
}

/// Runs a scenario, and on for `more_s` after its end with these commands, one each tenth of a second.
pub fn run_on(scenario: &Scenario, more_s: f64, commands: &[Command]) -> Run {
    let mut session = Session::new(scenario, false);
    session.keep_tape();
    let (kept, bench) = (kept_of(scenario), session.bench());
    let mut core = Core::new();
    let software =
        Software::new(kept, &bench, session.retained(), &mut core).expect("a good configuration");
    let mut listener = Listener { software, releases: Vec::new() };
    while !session.is_over() {
        let Ok(_) = session.tick(&mut listener);
    }
    let mut commands = commands.iter();
    for tick in 0..(more_s * TICK_HZ) as u32 {
        if tick % 200 == 0
            && let Some(command) = commands.next()
        {
            session.order(*command);
        }
        let Ok(_) = session.tick(&mut listener);
    }
    let happenings = session.happenings().iter();
    Run {
        tape: session.tape().expect("it is kept").clone(),
        releases: listener.releases,
        events: happenings.map(|one| (one.true_s, one.event)).collect(),
        payload_kg: session.plant().payload_kg(),
        start_s: session.start_s().unwrap_or(f64::NAN),
    }
}

pub fn run(scenario: &Scenario) -> Run {
    run_on(scenario, 0.0, &[])
}

impl Run {
    /// Steps from `t_s` after the start on.
    pub fn since(&self, t_s: f64) -> &[Frame] {
        let at = |frame: &Frame| frame.true_s < self.start_s + t_s - 1e-9;
        &self.tape.frames[self.tape.frames.partition_point(at)..]
    }

    /// The last step.
    pub fn end(&self) -> &Frame {
        self.tape.frames.last().expect("a step")
    }

    /// When an event came after the start, s.
    pub fn time_of(&self, wanted: Event) -> Option<f64> {
        let found = self.events.iter().find(|(_, event)| *event == wanted);
        found.map(|(true_s, _)| true_s - self.start_s)
    }

    /// Time, fault and joints of the first fault that was reported.
    pub fn first_fault(&self) -> Option<(f64, Fault, u8)> {
        self.events.iter().find_map(|(true_s, event)| match event {
            Event::Fault(fault, joints) => Some((true_s - self.start_s, *fault, *joints)),
            _ => None,
        })
    }

    pub fn mode_at_end(&self) -> Option<Mode> {
        Mode::from_number(self.end().record.mode)
    }
}

/// Whether two times are less than a thousandth of a tick apart.
pub fn are_same(a_s: f64, b_s: f64) -> bool {
    (a_s - b_s).abs() < 1e-3 * TICK_S
}
