//! The controller without its devices: what is believed of the samples, the mode, and the torque that follows.
//!
//! The executive walks through it once a tick: [`Core::begin`], [`Core::start_sampling`] and a sample of each
//! device, [`Core::supervise`], [`Core::control`], [`Core::conclude`], [`Core::record`].

mod control;
mod decide;
mod record;
mod sample;

use bytemuck::Zeroable;
use shared::arm::JOINTS;
use shared::fault::{Fault, Refusal};

pub use control::Control;

use crate::JointVector;
use crate::config::{Config, ConfigError};
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
    /// Fault that ended the last run by a reset, if one did: until it is cleared, the controller stays latched.
    pub crash: Option<Fault>,
}

/// Index of the torque converter among the counted devices; encoders are 0 to 3.
pub const ADC: usize = JOINTS;
/// Index of the DAC among the counted devices.
pub const DAC: usize = JOINTS + 1;

/// Both contacts of the emergency stop as they were.
#[derive(Clone, Copy, Debug)]
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
    /// Disturbance estimates of 0 to 1 and of 1 to 2 times [`BACKUP_TICKS`] ago, N m and N.
    d_mid: JointVector,
    d_old: JointVector,
    /// Ticks since the present round of the watch motion began.
    watch: u32,
    /// Joints that it moves, one bit each.
    watched: u8,
    /// Joints without torque, one bit each.
    isolated: u8,
    /// The arm swings: the law is softened.
    soft: bool,
    /// The law computed the torque.
    in_control: bool,
    /// The arm's motion tells of disturbances.
    adapts: bool,
    /// Ticks for which samples get a wider window: torque was at its limit.
    loose: u8,
}

/// Age of a disturbance estimate that a faulty sensor has not touched yet, as long as it is found within this
/// many ticks; a power of two.
const BACKUP_TICKS: u32 = 128;

impl Trace {
    const NONE: Self = {
        let zero = JointVector::new(0.0, 0.0, 0.0, 0.0);
        let none = [0.0; JOINTS];
        Self {
            aim: SetPoint { position: [0; JOINTS], velocity: none, acceleration: none },
            speed_error: zero,
            wanted: [zero; 2],
            written: zero,
            acting: zero,
            d_mid: zero,
            d_old: zero,
            watch: 0,
            watched: 0,
            isolated: 0,
            soft: false,
            in_control: false,
            adapts: false,
            loose: 0,
        }
    };

    /// Leaves control; what torques act does not depend on that.
    #[cold]
    #[inline(never)]
    fn forget(&mut self) {
        let Self { written, acting, .. } = *self;
        *self = Self::NONE;
        (self.written, self.acting) = (written, acting);
    }
}

/// See the module's documentation. What every tick uses comes first: loads of floats do not reach far.
#[repr(C)]
pub struct Core {
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
    /// The torque converter is configured.
    adc_ready: bool,
    /// The DAC took what the last tick wrote.
    acknowledged: bool,
    /// Something speaks against adaptation: a joint is not seen, or an estimate was not finite.
    spoilt: bool,
    /// The operator vouches for the pose at power-up.
    pose_confirmed: bool,
    /// One bit a device whose sample this tick could not use.
    rejected: u8,
    /// Records that the queue had no room for.
    dropped: u8,
    /// Why the last command had no effect.
    refusal: Refusal,
    /// Ticks since reset.
    tick: u32,
    /// Which of two alternating memories this tick reads and then writes.
    turn: usize,
    /// Ticks since the operator's last authentic frame.
    silence: u32,
    /// See [`Retained::parked`].
    parked: Option<[u32; JOINTS]>,
}

impl Core {
    /// Without a configuration. All its bytes are zero, so that it takes no room in an image.
    pub const fn new() -> Self {
        Self {
            trace: Trace::NONE,
            tracks: [Track::NONE; JOINTS],
            mode: Mode::RESET,
            memory: bytemuck::zeroed(),
            search: Search::NONE,
            scrub: Scrub::NONE,
            clock: Clock::NONE,
            torques: Torques::NONE,
            motions: Motions::NONE,
            findings: Findings::NONE,
            judged: Fault::None,
            contacts: Contacts { differ: 0, suspect: false, open: false },
            buckets: [Bucket::EMPTY; JOINTS + 2],
            leaking: false,
            seen: 0,
            blind: 0,
            implausible: [0; 2],
            adc_ready: false,
            acknowledged: false,
            spoilt: false,
            pose_confirmed: false,
            rejected: 0,
            dropped: 0,
            refusal: Refusal::None,
            tick: 0,
            turn: 0,
            silence: 0,
            parked: None,
        }
    }

    /// Takes a configuration with the CRC-32 that it was kept with (`Config::crc`), and what the board kept
    /// over the loss of power; to be called once, before the first tick.
    ///
    /// # Errors
    /// A check sum that does not fit, or the first value of `config` that is out of range; then nothing is
    /// taken.
    #[inline(never)]
    pub fn configure(
        &mut self,
        config: &Config,
        crc: u32,
        retained: &Retained,
    ) -> Result<(), ConfigError> {
        config.check(crc)?;
        config.validate()?;
        self.memory.set(config);
        self.parked = retained.parked;
        if let Some(crash) = retained.crash {
            self.mode = Mode::latched(crash);
        }
        Ok(())
    }

    /// Parameters, their shadow and the estimates.
    #[inline(always)]
    pub fn memory(&self) -> &Memory {
        &self.memory
    }

    /// The same, for whoever injects faults into memory.
    pub fn memory_mut(&mut self) -> &mut Memory {
        &mut self.memory
    }

    /// Present mode.
    #[inline(always)]
    pub fn mode(&self) -> &Mode {
        &self.mode
    }

    /// Begins a tick; whether the parameters may be used.
    #[inline(always)]
    pub fn begin(&mut self) -> bool {
        self.findings = Findings::NONE;
        self.turn ^= 1;
        self.memory.agrees()
    }

    /// Forgets everything about the devices, which are in reset now.
    #[inline(never)]
    pub fn start_over(&mut self) {
        (self.adc_ready, self.acknowledged) = (false, false);
        (self.seen, self.blind, self.spoilt) = (0, 0, false);
        self.pose_confirmed = false;
        for bucket in &mut self.buckets {
            *bucket = Bucket::FULL;
        }
        self.leaking = true;
        self.memory.estimates.set_d_hat(zero());
        self.torques = Torques::NONE;
        self.motions = Motions::NONE;
        self.trace = Trace::NONE;
    }

    /// The torque converter is configured, at this count of its conversions.
    pub fn adc_is_ready(&mut self, conversions: u32) {
        self.adc_ready = true;
        self.clock.restart(conversions);
    }

    /// Last believed codes.
    #[inline(always)]
    fn codes(&self) -> [u32; JOINTS] {
        let [a, b, c, d] = &self.tracks;
        [a.code, b.code, c.code, d.code]
    }
}

impl Default for Core {
    fn default() -> Self {
        Self::new()
    }
}

/// Nothing but zeros.
fn zero() -> JointVector {
    JointVector::zeroed()
}
