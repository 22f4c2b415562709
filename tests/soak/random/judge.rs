//! Judges a run step by step from what the harness sees: plant, pins, contacts, and what the operator was made to
//! say. The controller's records have to fit that.

use hil_sim::faults::{Injection, Kind};
use hil_sim::session::{Event, Frame};
use shared::arm::JOINTS;
use shared::command::Command;
use shared::fault::{Fault, Mode};

use super::demand::Demand;

/// Ticks from an order on the line to the pins.
const ORDER_TICKS: u64 = 10;
/// SS1: 150 ms along the path; then 100 ms for the brakes, 50 ms of torque; STO: 250 ms at most. Ticks, with grace.
const STOPPING: u64 = 320;
const BRAKE_HOLD: u64 = 320;
const TORQUE_OFF: u64 = 520;
/// Without torque an arm stands still after this, ticks: brakes close in 100 ms, and then slow it.
const STANDING: u64 = 800;
/// Silence of the operator that stops a motion, ticks, with grace.
const SILENCE: u64 = 510;
/// An emergency stop is a hardware STO after 500 ms.
const RELAY: u64 = 1_002;

/// What a run came to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Tally {
    pub ticks: u64,
    pub faults: u32,
    pub demands: u32,
    pub stops: u32,
    pub arms: u32,
    pub lowerings: u32,
    pub moving: u64,
}

/// See the module's documentation.
#[derive(Default)]
pub struct Judge {
    pub tally: Tally,
    pub complaints: Vec<String>,
    step: u64,
    last: Option<Frame>,
    /// Steps at which the operator armed and cleared last.
    armed: Option<u64>,
    cleared: Option<u64>,
    /// Step at which torque was taken away last.
    cut: Option<u64>,
    /// The arm was lowered: it must not be armed again.
    lowered: bool,
    /// Tick in which the mode began.
    since: u64,
    active: Vec<Injection>,
    due: Vec<(u64, Demand, Injection)>,
    stuck: Vec<(usize, f64, Option<u64>)>,
    /// Steps without torque, without an operator, with an open emergency stop, without a fault of the brakes.
    limp: u64,
    silent: u64,
    open: u64,
    sound: u64,
}

fn mode_of(frame: &Frame) -> Mode {
    Mode::from_number(frame.record.mode).expect("a mode")
}

/// Whether the arm is under torque and not being stopped.
fn goes(mode: Mode) -> bool {
    matches!(mode, Mode::Holding | Mode::Moving | Mode::Jogging)
}

fn is_of_brakes(kind: Kind) -> bool {
    use Kind::{BrakeJammed, BrakeNoFeedback, BrakeSlip, BrakeStuckOpen};
    matches!(kind, BrakeJammed | BrakeNoFeedback | BrakeSlip | BrakeStuckOpen)
}

/// Modes that may follow each other; the diagram of the supervisor's page.
fn follows(from: Mode, to: Mode) -> bool {
    use Mode::*;
    match from {
        Boot => to == Standby,
        Standby => matches!(to, Arming | Latched | Lowering),
        Arming => matches!(to, Holding | BrakeHold | TorqueOff),
        Holding => matches!(to, Moving | Jogging | BrakeHold | TorqueOff),
        Moving | Jogging => matches!(to, Holding | Stopping | TorqueOff),
        Stopping => matches!(to, BrakeHold | TorqueOff),
        BrakeHold => matches!(to, Latched | TorqueOff),
        TorqueOff => to == Latched,
        Latched => matches!(to, Boot | Lowering),
        Lowering => matches!(to, BrakeHold | TorqueOff),
    }
}

impl Judge {
    fn complain(&mut self, frame: &Frame, what: impl std::fmt::Display) {
        let (t, mode) = (frame.true_s, mode_of(frame));
        let fault = Fault::from_number(frame.record.fault).map_or("?", Fault::name);
        self.complaints.push(format!("{t:.4} s, {mode:?}, {fault}: {what}"));
    }

    /// The operator says this in the coming step.
    pub fn told(&mut self, command: &Command) {
        match command {
            Command::Arm => self.armed = Some(self.step),
            Command::Clear => self.cleared = Some(self.step),
            _ => {}
        }
    }

    /// Sees a step, in which these events happened.
    pub fn see(&mut self, frame: &Frame, events: impl Iterator<Item = Event>) {
        let before = self.last.unwrap_or(*frame);
        for event in events {
            match event {
                Event::Began(fault) => self.begin(&fault, &before, frame),
                Event::Ended(fault) => self.end(&fault),
                _ => {}
            }
        }
        self.count(frame);
        self.judge_numbers(frame, &before);
        self.judge_licence(frame, &before);
        self.judge_modes(frame, &before);
        self.judge_rest(frame);
        self.judge_demands(frame);
        self.judge_stuck(frame);
        self.last = Some(*frame);
        self.step += 1;
    }

    fn begin(&mut self, fault: &Injection, before: &Frame, now: &Frame) {
        self.tally.faults += 1;
        self.active.push(*fault);
        if !goes(mode_of(before)) || !before.chain_closed {
            return;
        }
        if let Some(demand) = Demand::of(fault, before) {
            self.due.push((self.step + demand.ticks() as u64, demand, *fault));
        }
        if fault.kind == Kind::StuckEncoder {
            self.stuck.extend(fault.target.joints().map(|j| (j, now.q[j], None)));
        }
    }

    fn end(&mut self, fault: &Injection) {
        self.active.retain(|one| one != fault);
        if fault.kind == Kind::StuckEncoder {
            self.stuck.clear();
        }
    }

    fn is_active(&self, kinds: impl Fn(Kind) -> bool) -> bool {
        self.active.iter().any(|fault| kinds(fault.kind))
    }

    fn count(&mut self, frame: &Frame) {
        let run = |so: bool, count: u64| if so { count + 1 } else { 0 };
        let limp = frame.torque == [0.0; JOINTS] && (!frame.pins.sto || !frame.chain_closed);
        let stop = |kind| matches!(kind, Kind::EStop | Kind::WireBroken | Kind::ContactsDiffer);
        self.limp = run(limp, self.limp);
        self.silent = run(self.is_active(|kind| kind == Kind::LinkSilent), self.silent);
        self.open = run(self.is_active(stop), self.open);
        self.sound = run(!self.is_active(is_of_brakes), self.sound);
        self.tally.ticks += u64::from(frame.ticked);
        self.tally.moving += u64::from(matches!(mode_of(frame), Mode::Moving | Mode::Jogging));
    }

    /// Everything is a number, and every counter within its bound.
    fn judge_numbers(&mut self, frame: &Frame, before: &Frame) {
        let (now, last) = (&frame.record, &before.record);
        let told = [now.e1, now.qd, now.e1_dot, now.d_hat];
        let truth = [frame.q, frame.qd, frame.torque];
        let finite = told.as_flattened().iter().all(|x| x.is_finite())
            && truth.as_flattened().iter().all(|x| x.is_finite());
        if !finite {
            self.complain(frame, format!("no number in {told:?} {truth:?}"));
        }
        let ticks = u32::from(frame.ticked && self.step > 0);
        let counted = now.irregular.wrapping_sub(last.irregular);
        let fine = now.tick.wrapping_sub(last.tick) == ticks
            && u32::from(counted) <= ticks
            && now.dropped == 0
            && now.bucket <= 6
            && now.rejected < 1 << 6;
        if !fine {
            self.complain(frame, format!("a counter is out of its bounds: {now:?} after {last:?}"));
        }
    }

    /// Torque comes on only by an arm, after a stop with a clear before it, or to lower a slipping arm.
    fn judge_licence(&mut self, frame: &Frame, before: &Frame) {
        let (now, last) = (frame.pins.sto, before.pins.sto);
        if last && !now {
            self.cut = Some(self.step);
        }
        if last || !now {
            return;
        }
        let armed = self.armed.is_some_and(|at| at + ORDER_TICKS >= self.step);
        let cleared = self.cut.is_none_or(|cut| self.cleared.is_some_and(|at| at >= cut));
        let slips = mode_of(frame) == Mode::Lowering && self.sound < STANDING;
        if self.lowered || !(slips || armed && cleared) {
            self.complain(frame, "torque without an arm");
        }
        self.lowered |= slips;
        self.tally.lowerings += u32::from(slips);
        self.tally.arms += u32::from(!slips);
    }

    fn judge_modes(&mut self, frame: &Frame, before: &Frame) {
        let (now, last) = (mode_of(frame), mode_of(before));
        if now != last {
            self.since = self.tally.ticks;
            self.tally.stops += u32::from(now == Mode::Latched);
            // What is found after a mode's turn is reacted to in the same tick.
            let reacts =
                matches!(now, Mode::Stopping | Mode::BrakeHold | Mode::TorqueOff | Mode::Latched);
            let by_way = (0..=u8::MAX)
                .filter_map(Mode::from_number)
                .any(|way| follows(last, way) && follows(way, now));
            if !(follows(last, now) || reacts && by_way) {
                self.complain(frame, format!("comes after {last:?}"));
            }
        }
        let lasts = self.tally.ticks - self.since;
        let late = match now {
            Mode::Stopping => lasts > STOPPING,
            Mode::BrakeHold => lasts > BRAKE_HOLD && self.sound > BRAKE_HOLD,
            Mode::TorqueOff => lasts > TORQUE_OFF,
            Mode::Moving | Mode::Jogging => self.silent > SILENCE,
            _ => false,
        };
        if late && frame.ticked && !self.is_active(|kind| kind == Kind::ClockOff) {
            self.complain(
                frame,
                format!("lasts {lasts} ticks, without an operator {}", self.silent),
            );
        }
        if frame.ticked {
            self.judge_pins(frame, now);
        }
    }

    fn judge_pins(&mut self, frame: &Frame, mode: Mode) {
        let pins = &frame.pins;
        let bits = |levels: &[bool; JOINTS]| (0..JOINTS).map(|j| u8::from(levels[j]) << j).sum();
        let (enables, releases): (u8, u8) = (bits(&pins.drive_enable), bits(&pins.brake_release));
        let off = matches!(mode, Mode::Boot | Mode::Standby | Mode::TorqueOff | Mode::Latched);
        let live = pins.sto || enables != 0 || releases != 0;
        if off && live || mode == Mode::BrakeHold && releases != 0 || goes(mode) && !pins.sto {
            self.complain(frame, format!("the pins are {pins:?}"));
        }
        if frame.record.powered != enables | releases << 4 {
            self.complain(frame, format!("the record says {:08b}", frame.record.powered));
        }
    }

    /// Without torque the arm stands, and with an open emergency stop it has none.
    fn judge_rest(&mut self, frame: &Frame) {
        if self.limp > STANDING && self.sound > STANDING && frame.qd != [0.0; JOINTS] {
            self.complain(frame, format!("it moves without torque: {:?}", frame.qd));
        }
        if self.open > RELAY && self.limp == 0 {
            self.complain(frame, "torque in spite of the emergency stop");
        }
    }

    fn judge_demands(&mut self, frame: &Frame) {
        let (mode, step) = (mode_of(frame), self.step);
        let mut missed = Vec::new();
        let tally = &mut self.tally;
        self.due.retain(|(until, demand, fault)| {
            let met = match demand {
                Demand::Stop(_) => !goes(mode) || !frame.chain_closed,
                Demand::Sto(_) => !frame.pins.sto || !frame.chain_closed,
                Demand::Hardware(_) => !frame.chain_closed,
            };
            tally.demands += u32::from(met);
            if !met && step > *until {
                missed.push((*demand, *fault));
            }
            !met && step <= *until
        });
        for (demand, fault) in missed {
            self.complain(frame, format!("{demand:?} is missing after {fault:?}"));
        }
    }

    /// A round of the watch motion after the joint has moved by more than a code may stand still, even at rest.
    fn judge_stuck(&mut self, frame: &Frame) {
        const WAY: [f64; JOINTS] = [6e-6, 6e-6, 6e-6, 3e-6];
        const ROUND: u64 = 200;
        let step = self.step;
        if !goes(mode_of(frame)) {
            self.tally.demands += u32::from(self.stuck.iter().any(|(_, _, since)| since.is_some()));
            self.stuck.clear();
        }
        let mut missed = None;
        for (j, from, since) in &mut self.stuck {
            if (frame.q[*j] - *from).abs() > WAY[*j] {
                let since = *since.get_or_insert(step);
                missed = (step == since + ROUND).then_some(*j).or(missed);
            }
        }
        if let Some(j) = missed {
            self.complain(frame, format!("encoder {j} stands still"));
        }
    }

    /// The run is over: stopped, with everything off and at rest.
    pub fn see_end(&mut self, frame: &Frame, brakes_open: [bool; JOINTS]) {
        let record = &frame.record;
        let stopped = mode_of(frame) == Mode::Latched && record.fault != 0;
        let off = frame.torque == [0.0; JOINTS] && record.powered == 0 && !frame.pins.sto;
        let rests = frame.qd == [0.0; JOINTS] && brakes_open == [false; JOINTS];
        if !(stopped && off && rests && record.bucket == 0) {
            self.complain(frame, format!("not at rest at the end: {frame:?}, {brakes_open:?}"));
        }
    }
}
