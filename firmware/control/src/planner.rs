//! Turns commands into orders outside the tick, so that the tick only has to check whether they fit its mode.

use core::num::NonZeroU32;

use bytemuck::Zeroable;
use shared::arm::JOINTS;
use shared::command::{Command, GainName, Profile, Trajectory};
use shared::fault::Refusal;

use crate::JointVector;
use crate::config::{Body, Config, Gains, Joint, Law};
use crate::dynamics::Constants;
use crate::estimator::FRACTION_BITS;
use crate::law;
use crate::memory::Gained;
use crate::path::{DURATION_MAX, Line, Motion, Phase, Rate, SetPoint, Shaped};

/// A command as the tick takes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    /// Preload torque, open the brakes, try each joint and hold the measured pose.
    Arm,
    /// Follow this motion, if it starts at the set-point.
    Start(Motion),
    /// Stop along the path, set the brakes, switch torque off.
    Stop,
    /// Leave a latched stop.
    Clear,
    /// Move along this line, whose origin the tick fills in, until the jog times out.
    Jog(Line),
    /// Use these gains.
    SetGains(Gained),
    /// Believe the pose at power-up.
    ConfirmPose,
    /// Take the arm to its rest pose: the answer to a slipped brake.
    Lower(Motion),
    /// The command cannot be followed from anywhere.
    Refused(Refusal),
}

/// What planning needs of one joint.
#[derive(Clone, Copy, Debug, Zeroable)]
struct Range {
    min_code: i32,
    max_code: i32,
    lsb: f32,
    zero: f32,
    qd_max: f32,
    /// Torque that a stop may need.
    tau_stop: f32,
}

impl Range {
    fn new(joint: &Joint, reserve: f32) -> Self {
        let code = |q: f32| ((q - joint.encoder_zero) / joint.encoder_lsb) as i32;
        Self {
            min_code: code(joint.q_min),
            max_code: code(joint.q_max),
            lsb: joint.encoder_lsb,
            zero: joint.encoder_zero,
            qd_max: joint.qd_max,
            tau_stop: joint.tau_max * (reserve - BETWEEN),
        }
    }

    fn position(&self, code: u32) -> f32 {
        code as f32 * self.lsb + self.zero
    }
}

/// Parts of a path at which its stop is computed.
const PLACES: u32 = 16;
/// What the torque may be higher between them and those of [`STOP`], share of its limit.
const BETWEEN: f32 = 0.01;
/// Path rate and its slope times the duration of the stop, at 0, 1/4, 1/2 and 3/4 of a stop (`path::Ramp`).
const STOP: [(f32, f32); 4] = [(1.0, 0.0), (0.843_75, -1.125), (0.5, -1.5), (0.156_25, -1.125)];
/// A jog is stoppable where it is and where it will be after this time, s.
const JOG_AHEAD_S: f32 = 0.5;
/// Shortest way to the rest pose, ticks a second of it at any rate: one second.
const LOWERING_MIN_S: f32 = 1.0;

/// See the module's documentation. All zero until it has a configuration.
#[derive(Clone, Copy, Debug, Zeroable)]
pub struct Planner {
    ranges: [Range; JOINTS],
    tick_hz: f32,
    /// The arm with its rated payload.
    rated: Constants,
    stop_per_s: f32,
    rest_pose: [f32; JOINTS - 1],
    lowering_share: f32,
    gains: Gains,
}

impl Planner {
    /// For a validated configuration.
    pub fn new(config: &Config) -> Self {
        let mut planner = Self::zeroed();
        planner.set(config);
        planner
    }

    /// Takes a validated configuration; filled in place, so that a small stack is enough.
    #[inline(never)]
    pub fn set(&mut self, config: &Config) {
        let safety = &config.safety;
        let (rated, own) = (&Body::payload(safety.rated_payload_kg), &config.arm.payload);
        let payload = if own.mass_kg < rated.mass_kg { rated } else { own };
        self.rated.collect(&config.arm, payload);
        for (range, joint) in self.ranges.iter_mut().zip(&config.joints) {
            *range = Range::new(joint, safety.torque_reserve);
        }
        self.tick_hz = config.tick_hz as f32;
        self.stop_per_s = 1.0 / safety.stop_s;
        self.rest_pose = safety.rest_pose;
        self.lowering_share = safety.lowering_share;
        self.gains = config.gains;
    }

    /// The order for `command`, given the encoder codes of a moment ago; in the place where it is wanted, so that a
    /// small stack is enough.
    #[inline(never)]
    pub fn plan(&mut self, command: &Command, codes: &[u32; JOINTS], order: &mut Order) {
        let planned = match command {
            Command::Arm => put(order, Order::Arm),
            Command::Stop => put(order, Order::Stop),
            Command::Clear => put(order, Order::Clear),
            Command::ConfirmPose => put(order, Order::ConfirmPose),
            Command::Start(trajectory) => {
                self.motion(trajectory, order).and_then(|()| self.can_stop(order))
            }
            Command::Jog(speeds) => self.jog(speeds, codes).and_then(|()| self.line(speeds, order)),
            Command::SetGain { name, values } => self.set_gain(*name, values, order),
        };
        if let Err(refusal) = planned {
            *order = Order::Refused(refusal);
        }
    }

    /// The way to the rest pose from the pose at `codes`.
    #[inline(never)]
    pub fn lower(&self, codes: &[u32; JOINTS], order: &mut Order) {
        let mut amplitude_q5 = [0; JOINTS];
        let mut duration_s = LOWERING_MIN_S;
        let places = self.ranges.iter().zip(codes).zip(&mut amplitude_q5).skip(1);
        for (((range, &code), slot), rest) in places.zip(self.rest_pose) {
            let way = rest - range.position(code);
            let needed_s =
                way.abs() * Profile::Quintic.peak_rate() / (range.qd_max * self.lowering_share);
            duration_s = if needed_s > duration_s { needed_s } else { duration_s };
            *slot = (way / range.lsb * 32.0) as i32;
        }
        let trajectory = Trajectory {
            profile: Profile::Quintic,
            allow_velocity_step: false,
            speed_limit_percent: 100,
            duration_ticks: (duration_s * self.tick_hz) as u32,
            origin_q6: codes.map(|code| code << FRACTION_BITS),
            amplitude_q5,
        };
        let ticks = NonZeroU32::new(trajectory.duration_ticks).filter(|n| *n <= DURATION_MAX);
        *order = match ticks {
            Some(ticks) => Order::Lower(self.planned(&trajectory, ticks)),
            None => Order::Refused(Refusal::BadDuration),
        };
    }

    fn planned(&self, trajectory: &Trajectory, ticks: NonZeroU32) -> Motion {
        Motion::new(trajectory, ticks, self.ranges.map(|r| r.lsb), self.tick_hz)
    }

    #[inline(never)]
    fn motion(&self, trajectory: &Trajectory, order: &mut Order) -> Result<(), Refusal> {
        let ticks = NonZeroU32::new(trajectory.duration_ticks).ok_or(Refusal::BadDuration)?;
        if ticks > DURATION_MAX {
            return Err(Refusal::BadDuration);
        }
        if trajectory.profile == Profile::HalfSine && !trajectory.allow_velocity_step {
            return Err(Refusal::VelocityStep);
        }
        let paths = trajectory.origin_q6.iter().zip(&trajectory.amplitude_q5);
        for ((&origin, &span), range) in paths.zip(&self.ranges) {
            let start = (origin >> FRACTION_BITS) as i32;
            let end = start.saturating_add(span >> 5);
            if [start, end].iter().any(|c| *c < range.min_code || *c > range.max_code) {
                return Err(Refusal::OutOfRange);
            }
        }
        let motion = self.planned(trajectory, ticks);
        let share = f32::from(trajectory.speed_limit_percent) * 0.01;
        let share = if share > 1.0 { 1.0 } else { share };
        let (amplitude, times) = motion.peak();
        let fast = |(a, range): (&f32, &Range)| a.abs() * times > range.qd_max * share;
        if amplitude.iter().zip(&self.ranges).any(fast) {
            return Err(Refusal::TooFast);
        }
        put(order, Order::Start(motion))
    }

    /// Whether a motion can be stopped wherever it is.
    #[inline(never)]
    fn can_stop(&self, order: &Order) -> Result<(), Refusal> {
        let Order::Start(motion) = order else { return Ok(()) };
        if (0..=PLACES).all(|place| self.stops_at(motion, place)) {
            Ok(())
        } else {
            Err(Refusal::NotStoppable)
        }
    }

    /// Whether a stop begun at this place of the motion stays within the torque reserve.
    #[inline(never)]
    fn stops_at(&self, motion: &Motion, place: u32) -> bool {
        let ticks =
            (u64::from(motion.duration_ticks()) * u64::from(place) / u64::from(PLACES)) as u32;
        let phase = Phase { ticks, fraction: 0 };
        STOP.iter().all(|&(value, slope)| {
            let rate = Rate { value, slope_per_s: slope * self.stop_per_s };
            let mut at = SetPoint::default();
            motion.place(phase, rate, &mut at);
            let mut q = JointVector::repeat(0.0);
            for j in 0..JOINTS {
                q[j] = self.ranges[j].position(at.position[j] >> FRACTION_BITS);
            }
            self.affords(&q, &at.velocity.into(), &at.acceleration.into())
        })
    }

    /// Whether a jog at these speeds is possible and can be stopped.
    #[inline(never)]
    fn jog(&self, speeds: &[f32; JOINTS], codes: &[u32; JOINTS]) -> Result<(), Refusal> {
        if !speeds.iter().all(|v| v.is_finite()) {
            return Err(Refusal::NotFinite);
        }
        if speeds.iter().zip(&self.ranges).any(|(v, range)| v.abs() > range.qd_max) {
            return Err(Refusal::TooFast);
        }
        for ahead_s in [0.0, JOG_AHEAD_S] {
            let mut q = along(speeds, ahead_s);
            for j in 0..JOINTS {
                q[j] += self.ranges[j].position(codes[j]);
            }
            for (value, slope) in STOP {
                let (qd, qdd) = (along(speeds, value), along(speeds, slope * self.stop_per_s));
                if !self.affords(&q, &qd, &qdd) {
                    return Err(Refusal::NotStoppable);
                }
            }
        }
        Ok(())
    }

    /// The line of a jog.
    #[inline(never)]
    fn line(&self, speeds: &[f32; JOINTS], order: &mut Order) -> Result<(), Refusal> {
        let mut line = Line { velocity: *speeds, ..Line::default() };
        for ((slot, v), range) in line.velocity_q8.iter_mut().zip(speeds).zip(&self.ranges) {
            // Word steps of 1/64 count a tick, 8 fractional bits.
            *slot = (v / (range.lsb * self.tick_hz) * 16_384.0) as i32;
        }
        put(order, Order::Jog(line))
    }

    /// Whether the torque of this state leaves the reserve.
    #[inline(never)]
    fn affords(&self, q: &JointVector, qd: &JointVector, qdd: &JointVector) -> bool {
        let torque = self.rated.torque(q, qd, qdd);
        torque.iter().zip(&self.ranges).all(|(tau, range)| tau.abs() <= range.tau_stop)
    }

    #[inline(never)]
    fn set_gain(
        &mut self,
        name: u8,
        values: &[f32; JOINTS],
        order: &mut Order,
    ) -> Result<(), Refusal> {
        let (name, _) = *GainName::ALL.get(usize::from(name)).ok_or(Refusal::UnknownGain)?;
        let mut gains = self.gains;
        let of_pd = matches!(name, GainName::Kp | GainName::Kd);
        if of_pd != (gains.law == Law::PD) {
            return Err(Refusal::OtherLaw);
        }
        let [first, ..] = *values;
        match name {
            GainName::K1 => gains.k1 = *values,
            GainName::K2 => gains.k2 = *values,
            GainName::Wa => gains.wa_rad_s = first,
            GainName::Psi => gains.psi = *values,
            GainName::DMax => gains.d_max = *values,
            GainName::Kp => gains.kp = *values,
            GainName::Kd => gains.kd = *values,
        }
        if !gains.are_valid(self.tick_hz) {
            return Err(Refusal::GainOutOfRange);
        }
        self.gains = gains;
        let gained = Gained::new(&law::Coefficients::new(&gains, self.tick_hz));
        put(order, Order::SetGains(gained))
    }
}

/// Puts an order where it is wanted.
fn put(order: &mut Order, planned: Order) -> Result<(), Refusal> {
    *order = planned;
    Ok(())
}

/// `speeds` times a number.
#[inline(never)]
fn along(speeds: &[f32; JOINTS], by: f32) -> JointVector {
    speeds.map(|speed| speed * by).into()
}
