//! The fixed-step executive: one tick walks from the sensors to the drives once, with no way back.

mod control;
mod output;
mod sample;
mod supervise;

use bytemuck::Zeroable;
use embedded_hal::digital::{InputPin, OutputPin};
use embedded_hal::spi::SpiDevice;
use heapless::spsc::Producer;
use shared::arm::JOINTS;
use shared::fault::{Fault, Refusal};
use shared::telemetry::Record;
use shared::wire::biss_c::Layout;

use crate::JointVector;
use crate::config::{Config, ConfigError};
use crate::drivers::ads131m04::Ads131m04;
use crate::drivers::dac81404::Dac81404;
use crate::io::Io;
use crate::memory::{Memory, Scrub, Search};
use crate::monitor::{Bucket, Clock, Findings, Motions, Torques, Track};
use crate::path::SetPoint;
use crate::planner::Order;
use crate::supervisor::Mode;

/// What a tick is handed; it reads no clock and no queue itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct TickInput<'a> {
    /// Order that was planned since the last tick.
    pub order: Option<&'a Order>,
    /// An authentic frame of the operator came since the last tick.
    pub alive: bool,
    /// Free-running counter at `config::Safety::clock_hz`, at the tick's start.
    pub cycles: u32,
    /// What the tick before computed, in the same unit.
    pub spent: u32,
    /// Free-running counter of the torque converter's conversions.
    pub conversions: u32,
}

/// What must outlive a loss of power, as the board kept it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Retained {
    /// Encoder codes of the pose that the arm was parked in; `None` if it is not known.
    pub parked: Option<[u32; JOINTS]>,
}

/// Where a tick leaves its record.
pub trait RecordSink {
    /// Takes the record, or returns `false` when full.
    fn push(&mut self, record: Record) -> bool;
}

impl RecordSink for Producer<'_, Record> {
    #[inline(always)]
    fn push(&mut self, record: Record) -> bool {
        self.enqueue(record).is_ok()
    }
}

/// Index of the torque converter among the counted devices.
const ADC: usize = JOINTS;
/// Index of the DAC among the counted devices.
const DAC: usize = JOINTS + 1;

/// Both contacts of the emergency stop as they were.
#[derive(Clone, Copy, Debug, Default)]
struct Contacts {
    /// Ticks that they have disagreed.
    differ: u32,
    /// They disagreed for too long and have not been seen to agree on open since.
    suspect: bool,
    /// Either is open.
    open: bool,
}

/// What the last ticks under control left for the monitors.
#[derive(Clone, Copy, Debug)]
struct Trace {
    /// The law computed the torque.
    in_control: bool,
    /// The arm's motion tells of disturbances.
    adapts: bool,
    /// Ticks for which samples get a wider window: torque was at its limit.
    loose: u8,
    /// Set-point.
    aim: SetPoint,
    /// Speed less its set-point, rad/s and m/s.
    speed_error: JointVector,
    /// Accelerations that the law wanted in the last two ticks, word steps a tick². What tick k wants acts from
    /// k + 1 to k + 2, so k + 2 is the first to see it: both take turns.
    wanted: [JointVector; 2],
    /// Torque written, and torque acting since LDAC, N m and N.
    written: JointVector,
    acting: JointVector,
    /// Last disturbance estimate that was finite, N m and N.
    d_hat: JointVector,
}

impl Trace {
    const NONE: Self = {
        let zero = JointVector::new(0.0, 0.0, 0.0, 0.0);
        Self {
            in_control: false,
            adapts: false,
            loose: 0,
            aim: SetPoint { position: [0; JOINTS], velocity: [0.0; JOINTS], acceleration: [0.0; JOINTS] },
            speed_error: zero,
            wanted: [zero; 2],
            written: zero,
            acting: zero,
            d_hat: zero,
        }
    };
}

/// The controller with everything it owns. What every tick uses comes first: loads of floats do not reach far.
#[repr(C, align(8))]
pub struct Executive<S, O, I> {
    trace: Trace,
    tracks: [Track; JOINTS],
    mode: Mode,
    memory: Memory,
    search: Search,
    scrub: Scrub,
    clock: Clock,
    torques: Torques,
    motions: Motions,
    findings: Findings,
    /// Fault that the mode has reacted to in this tick.
    judged: Fault,
    contacts: Contacts,
    /// Encoders, ADC and DAC.
    buckets: [Bucket; JOINTS + 2],
    /// Any of them is not empty.
    leaking: bool,
    /// Encoders that gave a sample since boot, one bit each.
    seen: u8,
    /// Encoders that are no longer believed, one bit each.
    blind: u8,
    /// Encoders whose sample was implausible in this tick and in the one before, one bit each.
    implausible: [u8; 2],
    adc_ready: bool,
    dac_ready: bool,
    /// The DAC holds four good codes that LDAC may pass on.
    acknowledged: bool,
    /// Nothing speaks against adaptation: every joint is seen, and no estimate was ever not finite.
    may_adapt: bool,
    /// The operator vouches for the pose at power-up.
    pose_confirmed: bool,
    /// Level of the watchdog's pin.
    fed: bool,
    /// One bit a device whose sample this tick could not use.
    rejected: u8,
    /// Drive enables and brake releases as driven.
    powered: u8,
    /// Records that the queue had no room for.
    dropped: u8,
    /// Why the last command had no effect.
    refusal: Refusal,
    /// Ticks since reset.
    tick: u32,
    /// Which of two alternating memories this tick reads and then writes.
    turn: usize,
    /// Stages that this tick has gone through, four bits each.
    stages: u32,
    /// Ticks since the operator's last authentic frame.
    silence: u32,
    /// Ticks between two feeds of the watchdog, and those left to the next one.
    feed: (u32, u32),
    retained: Retained,
    layouts: [Layout; JOINTS],
    adc: Ads131m04,
    dac: Dac81404,
    io: Io<S, O, I>,
}

impl<S: SpiDevice, O: OutputPin, I: InputPin> Executive<S, O, I> {
    /// A controller that has no configuration yet; no pin is touched before the first tick.
    #[inline(always)]
    pub fn new(io: Io<S, O, I>) -> Self {
        Self {
            io,
            adc: Ads131m04::new(),
            dac: Dac81404::new(),
            layouts: [Layout::default(); JOINTS],
            memory: Memory::zeroed(),
            search: Search::default(),
            scrub: Scrub::default(),
            mode: Mode::RESET,
            findings: Findings::NONE,
            judged: Fault::None,
            tracks: [Track::default(); JOINTS],
            buckets: [Bucket::FULL; JOINTS + 2],
            leaking: true,
            clock: Clock::default(),
            torques: Torques::default(),
            motions: Motions::default(),
            contacts: Contacts::default(),
            trace: Trace::NONE,
            seen: 0,
            blind: 0,
            implausible: [0; 2],
            adc_ready: false,
            dac_ready: false,
            acknowledged: false,
            may_adapt: true,
            retained: Retained::default(),
            pose_confirmed: false,
            silence: 0,
            tick: 0,
            turn: 0,
            feed: (0, 0),
            fed: false,
            stages: 0,
            rejected: 0,
            powered: 0,
            dropped: 0,
            refusal: Refusal::None,
        }
    }

    /// Takes a configuration with the CRC-32 that it was kept with (`Config::crc`), and what the board kept
    /// over the loss of power; to be called once, before the first tick.
    ///
    /// # Errors
    /// A check sum that does not fit, or the first value of `config` that is out of range; then nothing is
    /// taken.
    pub fn configure(
        &mut self,
        config: &Config,
        crc: u32,
        retained: Retained,
    ) -> Result<(), ConfigError> {
        config.check(crc)?;
        config.validate()?;
        let [j1, j2, j3, j4] = &config.joints;
        self.layouts = [j1.layout(0)?, j2.layout(1)?, j3.layout(2)?, j4.layout(3)?];
        self.memory.set(config);
        self.retained = retained;
        // Toggled every 2 ms (docs/parts.md, external watchdog).
        let interval = config.tick_hz / 500;
        self.feed = (interval, interval);
        Ok(())
    }

    /// What the configuration became, as bytes in two pieces: equal on host and target, or the builds differ.
    pub fn parameter_bytes(&self) -> [&[u8]; 2] {
        let memory = &self.memory;
        [bytemuck::bytes_of(&memory.coefficients), bytemuck::bytes_of(&memory.thresholds)]
    }

    /// Parameters, their shadow and the estimates, for whoever injects faults into memory.
    pub fn memory(&mut self) -> &mut Memory {
        &mut self.memory
    }

    /// One control tick: update (LDAC), sample, compute, write. The only entry.
    ///
    /// Call it every 1 / `tick_hz`. What tick k computes takes effect at the start of tick k + 1, so the
    /// delay is one tick whatever the computation took; the deadline is the next tick, and half a tick
    /// for computation and wire together keeps the other half for the idle loop. A late, early or missing
    /// tick is told by `input.cycles` and made up for; several, or one far too late, stop the arm. A tick
    /// that never returns is the external watchdog's business, which this feeds every 2 ms.
    ///
    /// Allocates nothing, has no panic path, loops only over joints and reads no clock.
    #[inline(always)]
    pub fn tick(&mut self, input: &TickInput<'_>, records: &mut impl RecordSink) {
        self.findings = Findings::NONE;
        let mut driven = self.update();
        let (control, codes) = if self.memory.agrees() {
            self.sample(input);
            self.supervise(input);
            let levels = self.mode.levels(&self.memory.thresholds.timing);
            driven &= self.drive(levels);
            let control = self.control(input);
            let codes = self.write(&control.torque);
            self.conclude(driven);
            (control, codes)
        } else {
            (self.repair(), [output::DAC_ZERO; JOINTS])
        };
        self.publish(&control, codes, records);
        self.feed_watchdog();
    }
}
