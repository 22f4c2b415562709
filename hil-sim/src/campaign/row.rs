//! What a row of the fault table is made of.

use std::fmt;

use shared::fault::{Fault, Limit, Refusal};

use super::onset::Condition;
use super::pose::Pose;
use super::trial::{Ask, Order, Trial};
use crate::faults::{Injection, Kind, Target};
use crate::pil::Crash;

/// What must come of a fault.
#[derive(Clone, Debug, PartialEq)]
pub enum Expect {
    /// Noticed and tolerated: no stop.
    Tolerate,
    /// Not noticed, or noticed; no stop in either case.
    Harmless,
    /// Stop along the path, brakes, torque off.
    Ss1,
    /// Torque off and all brakes at once, by the firmware.
    Sto,
    /// The same by the hardware.
    Hardware,
    /// This joint's brake at once, the others stop along the path.
    Isolate(usize),
    /// No stop, or SS1.
    Ss1OrNone,
    /// Never leaves boot, or refuses to arm: no brake is released.
    NoArm,
    /// The configuration is refused.
    NoConfiguration,
    /// Arming ends without a motion.
    NoGo,
    /// The order is refused for one of these reasons, and nothing else happens.
    Refuse(&'static [Refusal]),
    /// Torque comes back and takes the arm to its rest pose.
    Lower,
}

/// How it shows that the fault was noticed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign {
    /// One of these faults is reported.
    Fault(&'static [Fault]),
    /// A sample of the device with this index counts as rejected.
    Rejected(usize),
    /// The arm is limited by this.
    Limited(Limit),
    /// The count of irregular ticks goes up.
    Irregular,
    /// An order is refused.
    Refused,
    /// The hardware's safety chain opens.
    Chain,
    /// Nothing has to show.
    Nothing,
}

impl fmt::Display for Sign {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(faults) => {
                let names = faults.iter().map(|fault| fault.name()).collect::<Vec<_>>();
                write!(f, "fault {}", names.join(" or "))
            }
            Self::Rejected(_) => f.write_str("rejected sample"),
            Self::Limited(limit) => write!(f, "limit {}", limit.name()),
            Self::Irregular => f.write_str("count of irregular ticks"),
            Self::Refused => f.write_str("refusal"),
            Self::Chain => f.write_str("open safety chain"),
            Self::Nothing => f.write_str("sign"),
        }
    }
}

/// How far the tip may sink.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drop {
    /// 5 mm.
    Tight,
    /// 0.1 mm beyond the run without the fault.
    Zero,
    /// As far as the bare plant with this fault acting until the reaction's limit, then an ideal reaction; 10 % more.
    Bound(Acting),
}

/// What acts on the bare plant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Acting {
    /// The torques stay as they are.
    Held,
    /// No drive gives torque.
    Limp,
    /// The drive of a joint gives this share of its full scale.
    Stuck(usize, f64),
    /// The drive of a joint gives the opposite.
    Inverted(usize),
    /// A joint is limp, and the others stop along the path.
    Isolated(usize),
}

/// Something else that must hold of a run; gives what does not.
pub type Check = fn(&Trial, usize) -> Option<String>;

/// A way in which a row's fault comes.
#[derive(Clone, Debug)]
pub struct Variant {
    /// What is injected where, in a few words.
    pub name: String,
    /// Injections, their times counted from the pose.
    pub faults: Vec<Injection>,
    /// Orders that are given with and without the fault, likewise.
    pub orders: Vec<Order>,
    /// Orders that are the fault.
    pub wrong: Vec<Order>,
    /// What must come of it.
    pub expect: Expect,
    /// How it shows.
    pub sign: Sign,
    /// From when on it can be noticed.
    pub observable: Condition,
    /// Highest number of ticks to the sign.
    pub detect: u32,
    /// From when on the reaction is due, and the highest number of ticks to it.
    pub react: Vec<(Condition, u32)>,
    /// How far the tip may sink.
    pub drop: Drop,
    /// Injections of the twin, which must not trip.
    pub twin: Vec<Injection>,
    /// Compare with the run without the fault by ticks and not by true time.
    pub by_ticks: bool,
    /// Another pose than the cell's.
    pub pose: Option<Pose>,
    /// What else must hold.
    pub check: Option<Check>,
    /// The same again with seeds from the campaign's on.
    pub runs: u32,
    /// The emulated board breaks down so; it is run there alone.
    pub crash: Option<Crash>,
    /// Duration of the path, s, if not the usual one.
    pub path_s: Option<f64>,
}

/// A row of the table.
#[derive(Clone, Copy)]
pub struct Row {
    /// Its number.
    pub number: u8,
    /// What it is about.
    pub title: &'static str,
    /// Ways in which the fault comes in a pose, or why it makes no sense there.
    pub variants: fn(&Pose) -> Result<Vec<Variant>, &'static str>,
}

/// One tick, s.
pub const T: f64 = super::trial::TICK_S;
/// Long before power-up.
pub const POWER_UP: f64 = -900.0;

/// A fault that begins in the pose.
pub fn fault(kind: Kind, target: Target) -> Injection {
    Injection::new(kind, target, 0.0)
}

impl Injection {
    /// The same of another severity.
    pub(super) fn of(self, severity: f64) -> Self {
        Self { severity, ..self }
    }

    /// The same for so many ticks.
    pub(super) fn ticks(self, ticks: u32) -> Self {
        Self { for_s: Some(f64::from(ticks) * T), ..self }
    }

    /// The same, begun at another time.
    pub(super) fn at(self, at_s: f64) -> Self {
        Self { at_s, ..self }
    }
}

impl Variant {
    /// Faults, and what must come of them within so many ticks of both kinds; 5 mm; a twin without them.
    pub fn new(
        name: impl Into<String>,
        faults: Vec<Injection>,
        expect: Expect,
        sign: Sign,
        detect: u32,
        react: u32,
    ) -> Self {
        Self {
            name: name.into(),
            faults,
            orders: Vec::new(),
            wrong: Vec::new(),
            expect,
            sign,
            observable: Condition::Begun,
            detect,
            react: vec![(Condition::Begun, react)],
            drop: Drop::Tight,
            twin: Vec::new(),
            by_ticks: false,
            pose: None,
            check: None,
            runs: 1,
            crash: None,
            path_s: None,
        }
    }

    /// Tolerated, and seen in its sign within so many ticks.
    pub fn tolerated(
        name: impl Into<String>,
        faults: Vec<Injection>,
        sign: Sign,
        detect: u32,
    ) -> Self {
        Self::new(name, faults, Expect::Tolerate, sign, detect, 0)
    }

    /// Without consequence.
    pub fn harmless(name: impl Into<String>, faults: Vec<Injection>) -> Self {
        Self::new(name, faults, Expect::Harmless, Sign::Nothing, 0, 0)
    }

    /// A stop is as good: what cannot be told from a good sample at once may be told later.
    pub fn or_stopped(self) -> Self {
        Self { expect: Expect::Ss1OrNone, react: vec![(Condition::Never, 0)], ..self }
    }

    /// An order that is refused at once for one of these reasons.
    pub fn refused(name: impl Into<String>, ask: Ask, reasons: &'static [Refusal]) -> Self {
        let order = Order { at_s: 0.0, ask };
        let plain = Self::new(name, Vec::new(), Expect::Refuse(reasons), Sign::Refused, 1, 1);
        Self { wrong: vec![order], drop: Drop::Zero, ..plain }
    }

    /// Noticed and due from this condition on.
    pub fn from(self, condition: Condition) -> Self {
        let (_, react) = self.react[0];
        Self { observable: condition, react: vec![(condition, react)], ..self }
    }

    /// Due from this condition on, noticed from another.
    pub fn due(self, condition: Condition) -> Self {
        let (_, react) = self.react[0];
        Self { react: vec![(condition, react)], ..self }
    }

    /// With another limit of its drop.
    pub fn dropping(self, drop: Drop) -> Self {
        Self { drop, ..self }
    }

    /// With another twin.
    pub fn twin(self, twin: Vec<Injection>) -> Self {
        Self { twin, ..self }
    }

    /// With orders that are given in any case.
    pub fn ordered(self, orders: Vec<Order>) -> Self {
        Self { orders, ..self }
    }

    /// With something else that must hold.
    pub fn checked(self, check: Check) -> Self {
        Self { check: Some(check), ..self }
    }
}
