//! The fixed-step executive: one tick walks from the sensors to the drives once, with no way back.

use bytemuck::{Pod, Zeroable};
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
use crate::drivers::{Progress, encoder};
use crate::dynamics;
use crate::estimator::{self, Observer};
use crate::io::Io;
use crate::law::{self, State};
use crate::math::{clamp_symmetric, round_to_i32};
use crate::mode::{Events, Mode, Timing};
use crate::trajectory::{Order, SetPoint};

/// What a tick is handed; it reads no clock and no queue itself.
#[derive(Clone, Copy, Debug, Default)]
pub struct TickInput<'a> {
    /// Order that was planned since the last tick.
    pub order: Option<&'a Order>,
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

/// Configuration turned into what a tick uses.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Coefficients {
    observers: [estimator::Coefficients; JOINTS],
    dynamics: dynamics::Constants,
    law: law::Coefficients,
    timing: Timing,
    tau_max: JointVector,
    /// DAC codes per N m and N.
    codes_per_torque: JointVector,
}

impl Coefficients {
    /// Filled group by group, so that a small stack is enough.
    fn set(&mut self, config: &Config) {
        let tick_hz = config.tick_hz as f32;
        let gains = &config.gains;
        self.dynamics.collect(&config.arm);
        self.law = law::Coefficients::new(gains, tick_hz);
        for (j, joint) in config.joints.iter().enumerate() {
            self.observers[j] = estimator::Coefficients::new(joint, gains.observer_rad_s, tick_hz);
            self.tau_max[j] = joint.tau_max;
            self.codes_per_torque[j] = DAC_HALF_SCALE / joint.drive_full_scale;
        }
        self.timing = Timing::new(config.tick_hz);
    }
}

/// Codes from DAC mid-scale to full scale.
const DAC_HALF_SCALE: f32 = 32_768.0;
/// DAC code of no torque, offset binary.
const DAC_ZERO: u16 = 0x8000;
/// Samples lost in a row, or DAC writes not acknowledged, that end operation.
const LOST_MAX: u8 = 3;

/// The controller with everything it owns.
#[derive(Debug)]
pub struct Executive<S, O, I> {
    io: Io<S, O, I>,
    adc: Ads131m04,
    dac: Dac81404,
    layouts: [Layout; JOINTS],
    coefficients: Coefficients,
    mode: Mode,
    observers: [Observer; JOINTS],
    d_hat: JointVector,
    /// Last accepted encoder codes.
    code: [u32; JOINTS],
    /// Encoders, ADC and DAC: failures in a row; devices that never succeeded stand at the maximum.
    lost: [u8; JOINTS + 2],
    adc_ready: bool,
    dac_ready: bool,
    /// The DAC holds four good codes that LDAC may pass on.
    acknowledged: bool,
    /// Ticks since reset.
    tick: u32,
    /// One bit a device whose sample this tick could not use.
    rejected: u8,
    /// What the last samples and writes gave away; acted on while not booting.
    found: Fault,
    /// Records that the queue had no room for.
    dropped: u8,
    /// Why the last command had no effect.
    refusal: Refusal,
}

/// What the law leaves for bus and telemetry.
#[derive(Clone, Copy, Debug)]
struct Control {
    torque: JointVector,
    e1: JointVector,
    qd: JointVector,
    e1_dot: JointVector,
    saturated: u8,
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
            coefficients: Coefficients::zeroed(),
            mode: Mode::RESET,
            observers: [Observer::default(); JOINTS],
            d_hat: JointVector::repeat(0.0),
            code: [0; JOINTS],
            lost: [LOST_MAX; JOINTS + 2],
            adc_ready: false,
            dac_ready: false,
            acknowledged: false,
            tick: 0,
            rejected: 0,
            found: Fault::None,
            dropped: 0,
            refusal: Refusal::None,
        }
    }

    /// Takes a configuration; to be called once, before the first tick.
    ///
    /// # Errors
    /// The first value of `config` that is out of range; then nothing is taken.
    pub fn configure(&mut self, config: &Config) -> Result<(), ConfigError> {
        config.validate()?;
        let [j1, j2, j3, j4] = &config.joints;
        self.layouts = [j1.layout(0)?, j2.layout(1)?, j3.layout(2)?, j4.layout(3)?];
        self.coefficients.set(config);
        Ok(())
    }

    /// The coefficients as bytes: equal on host and target, or the builds differ.
    pub fn coefficient_bytes(&self) -> &[u8] {
        bytemuck::bytes_of(&self.coefficients)
    }

    /// One control tick: update (LDAC), sample, compute, write. The only entry.
    ///
    /// Call it every 1 / `tick_hz`. What tick k computes takes effect at the start of tick k + 1, so the
    /// delay is one tick whatever the computation took; the deadline is the next tick, and half a tick
    /// for computation and wire together keeps the other half for the idle loop. A late tick stretches
    /// the observer's step; a missing one leaves the last torque standing until the external watchdog,
    /// fed once here, opens STO.
    ///
    /// Allocates nothing, has no panic path, loops only over joints and reads no clock.
    #[inline(always)]
    pub fn tick(&mut self, input: &TickInput<'_>, records: &mut impl RecordSink) {
        let mut driven = self.update();
        self.sample();
        self.supervise(input);
        let control = match self.mode.set_point() {
            Some(set_point) => self.control(&set_point),
            None => self.rest(),
        };
        let levels = self.mode.levels(&self.coefficients.timing);
        driven &= self.io.outputs.drive(levels, self.tick & 1 == 0);
        let codes = self.write(&control.torque);
        if !driven {
            self.found = Fault::PinNotDriven;
        }
        self.publish(&control, codes, records);
    }

    /// Passes the last tick's torques on, if all four arrived.
    #[inline(always)]
    fn update(&mut self) -> bool {
        if self.acknowledged { self.io.outputs.pulse_ldac() } else { self.io.outputs.rest_ldac() }
    }

    /// Reads encoders, in joint order as their latch offsets assume, and the torque converter.
    #[inline(always)]
    fn sample(&mut self) {
        self.rejected = 0;
        // Written out: with constant indices no address is computed.
        self.sample_joint(0);
        self.sample_joint(1);
        self.sample_joint(2);
        self.sample_joint(3);
        if self.adc_ready {
            match self.adc.sample(&mut self.io.adc) {
                Ok(_) => self.lost[ADC] = 0,
                Err(_) => self.miss(ADC),
            }
        }
    }

    /// Reads the encoder of joint `j` and advances its observer.
    #[inline(always)]
    fn sample_joint(&mut self, j: usize) {
        let sample = encoder::read(&mut self.io.encoders[j], &self.layouts[j]).ok();
        match &sample {
            Some(sample) => {
                self.code[j] = sample.code;
                if self.lost[j] != 0 {
                    self.regain(j);
                }
            }
            None => self.miss(j),
        }
        self.observers[j].update(&self.coefficients.observers[j], sample.map(|s| s.code));
    }

    /// Ends a row of failures of encoder `j`; after a long one the estimate starts anew.
    #[cold]
    #[inline(never)]
    fn regain(&mut self, j: usize) {
        let mut joints = self.lost.iter_mut().zip(&mut self.observers).zip(&self.code);
        if let Some(((lost, observer), code)) = joints.nth(j) {
            if *lost >= LOST_MAX {
                *observer = Observer::at_rest(*code);
            }
            *lost = 0;
        }
    }

    /// Counts a failure of device `index`, and finds the fault that too many in a row are.
    #[cold]
    #[inline(never)]
    fn miss(&mut self, index: usize) {
        self.rejected |= 1 << index;
        let Some(lost) = self.lost.get_mut(index) else { return };
        *lost = if *lost < LOST_MAX { *lost + 1 } else { LOST_MAX };
        if *lost == LOST_MAX {
            self.found = match index {
                ADC => Fault::TorqueAdcLost,
                DAC => Fault::DacNotAcknowledged,
                _ => Fault::EncoderLost,
            };
        }
    }

    /// Configures converters during boot and moves the mode machine.
    #[inline(always)]
    fn supervise(&mut self, input: &TickInput<'_>) {
        let booting = matches!(self.mode, Mode::Boot { .. });
        if booting && self.mode.converters_awake(&self.coefficients.timing) {
            self.boot_converters();
        }
        let ready = booting && self.is_ready();
        let brakes_open = self.io.inputs.brakes_open();
        let fault = if booting { Fault::None } else { self.monitor() };
        let observers = &self.observers;
        let events = Events { order: input.order, observers, ready, brakes_open, fault };
        self.found = Fault::None;
        let refusal = self.mode.step(&self.coefficients.timing, &events);
        if !self.mode.adapts() {
            self.d_hat = JointVector::repeat(0.0);
        }
        if input.order.is_some() {
            self.refusal = refusal;
        }
    }

    fn is_ready(&self) -> bool {
        self.adc_ready && self.dac_ready && self.lost.iter().all(|&n| n == 0)
    }

    /// One boot step of each converter.
    #[cold]
    #[inline(never)]
    fn boot_converters(&mut self) {
        if !self.adc_ready {
            self.adc_ready = self.adc.boot_step(&mut self.io.adc) == Progress::Ready;
        }
        if !self.dac_ready {
            self.dac_ready = self.dac.boot_step(&mut self.io.dac) == Progress::Ready;
        }
    }

    /// What was found wrong since the last tick, outside boot.
    #[inline(always)]
    fn monitor(&mut self) -> Fault {
        if self.io.inputs.emergency_stop_healthy() { self.found } else { Fault::EmergencyStop }
    }

    /// The law at the measured state, limited to what the drives may give.
    #[inline(always)]
    fn control(&mut self, set_point: &SetPoint) -> Control {
        let state = self.state(set_point);
        let c = &self.coefficients;
        let wanted = law::evaluate(&c.law, &c.dynamics, &state, &self.d_hat);
        let torque = wanted.torque.zip_map(&c.tau_max, clamp_symmetric);
        let saturated = wanted.torque.zip_map(&torque, |w, t| if w == t { 0.0 } else { 1.0 });
        if self.mode.adapts() {
            // A joint at its torque limit learns nothing: its error is not the disturbance's.
            let step =
                wanted.adaptation.zip_map(&saturated, |s, at| if at == 0.0 { s } else { 0.0 });
            self.d_hat = law::adapt(&c.law, &self.d_hat, &step);
        }
        let State { qd, e1, e1_dot, .. } = state;
        Control { torque, e1, qd, e1_dot, saturated: law::bits(saturated) }
    }

    /// Estimates against the set-point, in SI units.
    #[inline(always)]
    fn state(&self, set_point: &SetPoint) -> State {
        let c = &self.coefficients.observers;
        let o = &self.observers;
        let q = JointVector::from_fn(|j, _| o[j].position(&c[j]));
        let qd = JointVector::from_fn(|j, _| o[j].velocity(&c[j]));
        let e1 = JointVector::from_fn(|j, _| {
            o[j].position.wrapping_sub(set_point.position[j]) as i32 as f32 * c[j].step
        });
        let e1_dot = qd - JointVector::from(set_point.velocity);
        State { q, qd, e1, e1_dot, qdd_d: set_point.acceleration.into() }
    }

    /// No torque, and nothing to report of a law.
    fn rest(&self) -> Control {
        let c = &self.coefficients.observers;
        let zero = JointVector::repeat(0.0);
        let qd = JointVector::from_fn(|j, _| self.observers[j].velocity(&c[j]));
        Control { torque: zero, e1: zero, qd, e1_dot: zero, saturated: 0 }
    }

    /// Encodes torques and writes them; LDAC of the next tick makes them act.
    #[inline(always)]
    fn write(&mut self, torque: &JointVector) -> [u16; JOINTS] {
        let codes = torque.component_mul(&self.coefficients.codes_per_torque).map(dac_code).into();
        if self.dac_ready {
            let acknowledge = self.dac.write(&mut self.io.dac, codes);
            // Without a valid status the DAC may have been reset and echo codes that move nothing.
            self.acknowledged = acknowledge.accepted && acknowledge.status.is_some();
            if self.acknowledged {
                self.lost[DAC] = 0;
            } else {
                self.miss(DAC);
            }
        }
        codes
    }

    /// Queues the tick's record; a full queue drops it and counts.
    #[inline(always)]
    fn publish(&mut self, control: &Control, dac: [u16; JOINTS], records: &mut impl RecordSink) {
        let kept = records.push(Record {
            tick: self.tick,
            mode: self.mode.code() as u8,
            refusal: self.refusal as u8,
            fault: self.mode.fault() as u16,
            saturated: control.saturated,
            adaptation_bound: self.coefficients.law.at_bound(&self.d_hat),
            rejected: self.rejected,
            dropped: self.dropped,
            phase: self.mode.phase(),
            code: self.code,
            e1: control.e1.into(),
            qd: control.qd.into(),
            e1_dot: control.e1_dot.into(),
            dac,
            adc: self.adc.codes(),
            d_hat: self.d_hat.into(),
        });
        if !kept {
            self.dropped = self.dropped.saturating_add(1);
        }
        self.tick = self.tick.wrapping_add(1);
    }
}

/// Index of the torque converter among the counted devices.
const ADC: usize = JOINTS;
/// Index of the DAC among the counted devices.
const DAC: usize = JOINTS + 1;

/// Offset-binary code of a torque within ±32 768 codes; zero torque for what is not a number.
#[inline(always)]
fn dac_code(codes: f32) -> u16 {
    let codes = if codes.abs() <= DAC_HALF_SCALE { codes } else { 0.0 };
    let code = round_to_i32(codes).wrapping_add(i32::from(DAC_ZERO));
    // Positive full scale itself is one code too many.
    (code - (code >> 16)) as u16
}
