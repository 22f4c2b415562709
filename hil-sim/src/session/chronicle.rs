//! What happened in a run with faults: which began and ended, and what the controller and the hardware made of
//! them.

use std::fmt;

use serde::{Serialize, Serializer};
use shared::arm::JOINTS;
use shared::fault::{Fault, Mode};
use shared::telemetry::Record;

use crate::faults::Injection;

/// One thing that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A fault began.
    Began(Injection),
    /// A fault ended.
    Ended(Injection),
    /// The controller's mode changed.
    Mode(Mode),
    /// The controller reports another fault, and the joints it names, one bit each.
    Fault(Fault, u8),
    /// The hardware's safety chain opened, or closed.
    Chain {
        /// It lets torque flow.
        closed: bool,
    },
}

impl fmt::Display for Event {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Began(injection) => write!(f, "injected: {injection}"),
            Self::Ended(injection) => write!(f, "over: {injection}"),
            Self::Mode(mode) => write!(f, "mode {}", mode.name()),
            Self::Fault(fault, joints) => {
                write!(f, "fault {}", fault.name())?;
                let named = (0..JOINTS).filter(|j| joints >> j & 1 != 0);
                named.enumerate().try_for_each(|(i, j)| {
                    write!(f, "{}{}", if i == 0 { ", joint " } else { " and " }, j + 1)
                })
            }
            Self::Chain { closed: true } => write!(f, "hardware's safety chain closed"),
            Self::Chain { closed: false } => write!(f, "hardware's safety chain open"),
        }
    }
}

/// What happened at one time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Happening {
    /// Since power-up, s.
    pub true_s: f64,
    /// What.
    #[serde(serialize_with = "as_text")]
    pub event: Event,
}

fn as_text<S: Serializer>(event: &Event, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(event)
}

/// Everything that happened so far, in order.
#[derive(Clone, Debug, Default)]
pub(super) struct Chronicle {
    happenings: Vec<Happening>,
    mode: u8,
    fault: (u16, u8),
    chain_closed: bool,
}

impl Chronicle {
    /// Adds an event.
    pub fn add(&mut self, true_s: f64, event: Event) {
        self.happenings.push(Happening { true_s, event });
    }

    /// Adds what has changed since the last time.
    pub fn watch(&mut self, true_s: f64, record: &Record, chain_closed: bool) {
        if self.chain_closed != chain_closed {
            self.chain_closed = chain_closed;
            self.add(true_s, Event::Chain { closed: chain_closed });
        }
        let fault = (record.fault, record.joints);
        if self.fault != fault {
            self.fault = fault;
            let named = Fault::from_number(record.fault).filter(|fault| *fault != Fault::None);
            named
                .into_iter()
                .for_each(|fault| self.add(true_s, Event::Fault(fault, record.joints)));
        }
        if self.mode != record.mode {
            self.mode = record.mode;
            let named = Mode::from_number(record.mode);
            named.into_iter().for_each(|mode| self.add(true_s, Event::Mode(mode)));
        }
    }

    /// All of it.
    pub fn happenings(&self) -> &[Happening] {
        &self.happenings
    }
}
