//! Damaged frames on the bus of an arm that moves: what comes through to positions, torques and the arm.
//!
//! The arm lifts and lowers without end. In each tick one encoder's frame is damaged, in each third one the torque
//! converter's, in each fourth one of the DAC's in either direction: as often as the loss buckets bear. Half of the
//! frames get flipped bits, a burst each fourth, the rest random contents; of those of the encoders some get the
//! check sum that fits, with a position near the right one. Requests to the DAC get no random contents: what a DAC does
//! with a command that it was not sent is not the firmware's to judge.

mod judge;
mod tap;

use std::cell::RefCell;
use std::rc::Rc;

use firmware::monitor::Thresholds;
use hil_sim::path::Path;
use hil_sim::run::config_of;
use hil_sim::scenario::Scenario;
use shared::arm::{JOINTS, REFERENCE};
use shared::command::{Command, Trajectory};
use shared::fault::{Fault, Mode};

use super::damage::Damage;
use crate::rig::{Rig, Way};
use tap::{Hit, Tap};

/// Index of the torque converter and of the DAC among the devices.
const ADC: usize = JOINTS;
const DAC: usize = JOINTS + 1;
const TICK_HZ: f64 = 2_000.0;
/// A stop is over after 150 ms, 100 ms for the brakes and 50 ms of torque; the rest is time to see that it stays so.
const STOP_TICKS: u32 = 1_000;
/// Ticks between two near positions, at least. Nobody but an attacker on the bus sends them more often.
const NEAR_EVERY: u64 = 200;

/// What became of damaged frames of one sort.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fate {
    /// Damaged.
    pub frames: u64,
    /// Taken by their check with contents that were not sent.
    pub passed: u64,
    /// And used.
    pub used: u64,
}

/// What came of it all.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// By device (encoders, torque converter, DAC) and by sort; the last is that of near positions.
    pub fates: [[Fate; 4]; 3],
    /// Ticks of the moving arm.
    pub ticks: u64,
    /// Stops, by their faults.
    pub stops: Vec<Fault>,
    /// Farthest that a position was from the one sent, counts.
    pub off_counts: [u32; JOINTS],
    /// Farthest that the tip was from its path, m.
    pub off_path_m: f64,
}

impl Tally {
    /// All damaged frames.
    pub fn frames(&self) -> u64 {
        self.fates.iter().flatten().map(|fate| fate.frames).sum()
    }
}

/// Index of the fate of positions near the right one.
pub const NEAR: usize = 3;

struct Running {
    rig: Rig,
    taps: [Rc<RefCell<Tap>>; JOINTS + 2],
    path: Path,
    lift: Trajectory,
    /// The path of the present motion is gone backwards.
    down: bool,
    /// Codes that the DAC was told last with success.
    acting: [u16; JOINTS],
    /// When an encoder had a near position last.
    near: u64,
    /// Codes of the last two ticks.
    codes: [[u32; 2]; JOINTS],
    /// Loss buckets of the encoders.
    levels: [u8; JOINTS],
    /// Ticks along the path.
    phase: f64,
}

/// Damages `count` frames, as many as it takes of ticks.
///
/// # Panics
/// Where a value is used that a check must have found, or that the rate window must have.
pub fn run(seed: u64, count: u64) -> Tally {
    let mut tally = Tally::default();
    let damage = Rc::new(RefCell::new(Damage::new(seed)));
    let scenario = Scenario::load("paper").expect("a shipped scenario");
    let mut thresholds: Thresholds = bytemuck::Zeroable::zeroed();
    thresholds.set(&config_of(&scenario));
    while tally.frames() < count {
        let mut running = Running::new(&scenario, &damage);
        while tally.frames() < count && running.goes_on() {
            running.tick(&damage, &mut tally, &thresholds);
        }
        if !running.goes_on() {
            running.see_stop(&mut tally);
        }
    }
    tally
}

impl Running {
    /// An arm that holds its start pose.
    fn new(scenario: &Scenario, damage: &Rc<RefCell<Damage>>) -> Self {
        let mut rig = Rig::new(&config_of(scenario), scenario.encoders.skew_s);
        rig.until(Mode::Standby, 1.0);
        rig.tick(Some(Command::Arm));
        rig.until(Mode::Holding, 1.0);
        let path = Path::of(scenario);
        let taps: [Rc<RefCell<Tap>>; JOINTS + 2] = Default::default();
        for (index, (line, tap)) in rig.devices.iter().zip(&taps).enumerate() {
            let (tap, damage) = (Rc::clone(tap), Rc::clone(damage));
            let pass =
                move |way, bytes: &mut [u8]| tap.borrow_mut().pass(index, way, bytes, &damage);
            *line.tamper.borrow_mut() = Some(Box::new(pass));
        }
        let lift = path.command(&REFERENCE);
        let before = rig.last.code;
        rig.tick(None);
        Self {
            acting: rig.last.dac,
            codes: std::array::from_fn(|j| [rig.last.code[j], before[j]]),
            rig,
            taps,
            path,
            lift,
            down: true,
            near: 0,
            levels: [0; JOINTS],
            phase: 0.0,
        }
    }

    /// Whether the arm has not been stopped.
    fn goes_on(&self) -> bool {
        let mode = self.rig.last.mode;
        mode == Mode::Holding as u8 || mode == Mode::Moving as u8
    }

    fn tick(&mut self, damage: &RefCell<Damage>, tally: &mut Tally, limits: &Thresholds) {
        tally.ticks += 1;
        self.aim(damage, tally.ticks, limits);
        let turns = self.rig.last.mode == Mode::Holding as u8;
        self.down ^= turns;
        let command = turns.then(|| Command::Start(self.next_path()));
        let acting = self.acting;
        let record = self.rig.tick(command);
        assert_eq!(record.refusal, 0, "{record:?}");
        let used = |device: usize| record.rejected >> device & 1 == 0;
        if used(DAC) {
            self.acting = record.dac;
        }
        // LDAC passes on what was taken in the tick before, or nothing.
        let given = self.rig.bench.borrow().drive_commands();
        let told = acting.map(|code| (f64::from(code) - 32_768.0) / 32_768.0);
        assert!(given.iter().zip(told).all(|(a, b)| (a - b).abs() < 1e-12), "{given:?} {told:?}");
        self.judge(used, tally, limits);
    }

    /// Chooses the frames to be hit in the coming tick.
    fn aim(&mut self, damage: &RefCell<Damage>, tick: u64, limits: &Thresholds) {
        let mut damage = damage.borrow_mut();
        self.taps.iter().for_each(|tap| tap.replace(Tap::default()).frames = [0; 2]);
        let j = (tick % 4) as usize;
        let mut sort = [0, 0, 1, 2][damage.below(4)];
        let mut hit = Hit { frame: 0, way: Way::In, sort, near: 0 };
        if sort == 2 && damage.below(4) == 0 && tick - self.near > NEAR_EVERY {
            // As near as a window that is tight, or as one that is wide.
            let window =
                2 * [limits.encoder.tight, limits.encoder.wide][damage.below(2)][j] as usize;
            let near = damage.below(2 * window + 1) as i32 - window as i32;
            (self.near, hit.sort, hit.near) = (tick, NEAR, if near == 0 { 1 } else { near });
        }
        self.taps[j].borrow_mut().hit = Some(hit);
        sort = [0, 0, 1, 2][damage.below(4)];
        if tick.is_multiple_of(3) {
            let frame = damage.below(2);
            let hit = Hit { frame, way: Way::In, sort, near: 0 };
            self.taps[ADC].borrow_mut().hit = Some(hit);
        }
        if tick.is_multiple_of(4) {
            let out = sort != 2 && damage.below(2) == 0;
            let (frame, way) = (damage.below(5), if out { Way::Out } else { Way::In });
            self.taps[DAC].borrow_mut().hit = Some(Hit { frame, way, sort, near: 0 });
        }
    }

    /// The path, or the way back along it.
    fn next_path(&self) -> Trajectory {
        let Trajectory { origin_q6, amplitude_q5, .. } = self.lift;
        if !self.down {
            return self.lift;
        }
        Trajectory {
            origin_q6: std::array::from_fn(|j| {
                origin_q6[j].wrapping_add_signed(2 * amplitude_q5[j])
            }),
            amplitude_q5: amplitude_q5.map(|a| -a),
            ..self.lift
        }
    }

    /// Sees a stop to its end, on a bus that is sound again.
    fn see_stop(&mut self, tally: &mut Tally) {
        self.rig.devices.iter().for_each(|line| *line.tamper.borrow_mut() = None);
        for _ in 0..STOP_TICKS {
            self.judge_arm(tally);
            self.rig.tick(None);
        }
        let record = self.rig.last;
        tally.stops.extend(Fault::from_number(record.fault));
        assert_eq!(record.mode, Mode::Latched as u8, "{record:?}");
        assert!(!self.rig.is_live() && self.rig.plant.qd() == [0.0; JOINTS]);
    }
}
