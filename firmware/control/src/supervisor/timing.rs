//! Times of the supervisor in ticks.

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;

use super::Bump;
use crate::config::{Config, Law};
use crate::estimator::FRACTION_BITS;
use crate::path::Pace;

/// Times, and what else the supervisor compares with.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Timing {
    /// Converters are held in reset this long.
    pub reset: u32,
    /// From reset to the first frame to a converter.
    pub settle: u32,
    /// Boot starts over after this long.
    pub boot: u32,
    /// Torque is on this long before the brakes are told to open.
    pub preload: u32,
    /// Brakes must report open this long after they were told.
    pub brake_open: u32,
    /// From then to the test move.
    pub calm: u32,
    /// The test move.
    pub test: Bump,
    /// The motion by which a joint that stands shows that its encoder is alive, again and again.
    pub watch: Bump,
    /// Duration of a stop.
    pub pace: Pace,
    /// Brakes must report closed this long after they were told.
    pub brake_set: u32,
    /// Torque stays on this long after that.
    pub torque_tail: u32,
    /// Longest silence of the operator link while moving.
    pub link: u32,
    /// A jog goes on this long after its last order.
    pub jog: u32,
    /// The contacts of the emergency stop may disagree this long: they never switch in the same instant.
    pub contacts: u32,
    /// A set joint that moved this far has slipped, counts.
    pub(crate) slip: [u32; JOINTS],
    /// Range of motion of a jog, position words.
    pub(crate) lowest: [u32; JOINTS],
    pub(crate) highest: [u32; JOINTS],
    /// Distance from the parked pose that is believed, counts.
    pub parked: [u32; JOINTS],
}

/// An encoder's noise is one count; four are motion.
const SLIP_MIN_COUNTS: u32 = 4;

/// Duration of the watch motion, s.
const WATCH_S: f32 = 0.1;
/// Its amplitude with the inertia-weighted law, counts. Wherever on its way a code got stuck, its lower or its upper
/// end is 16 away, and 8 for 29 ms: more than the 6 that a code must follow within 25 ms, and noise.
const WATCH_COUNTS: f32 = 32.0;
/// With the other laws one end is 48 away: more than the 40 that tell a stuck encoder at once.
const WATCH_COUNTS_ELSE: f32 = 96.0;
/// Its largest amplitude, rad and m: 0.1 mm at the tip.
const WATCH_MAX: f32 = 2e-5;

/// Amplitudes of the watch motion; none where it would show.
fn watch_amplitude(config: &Config) -> [f32; JOINTS] {
    let learns = config.gains.law == Law::INERTIA_WEIGHTED;
    let counts = if learns { WATCH_COUNTS } else { WATCH_COUNTS_ELSE };
    config.joints.map(|joint| {
        let amplitude = counts * joint.encoder_lsb;
        if amplitude <= WATCH_MAX { amplitude } else { 0.0 }
    })
}

/// Whole ticks in this time; out of line, because it is wanted often and once.
#[inline(never)]
fn rounded(seconds: f32, tick_hz: f32) -> u32 {
    (seconds * tick_hz + 0.5) as u32
}

impl Timing {
    /// For a validated configuration.
    #[inline(never)]
    pub fn set(&mut self, config: &Config) {
        let (safety, tick_hz) = (&config.safety, config.tick_hz as f32);
        let ticks = |seconds| rounded(seconds, tick_hz);
        // Both converters want a reset pulse of micro-seconds and are ready after milli-seconds
        // (ADS131M04 section 8.4.1, DAC81404 section 7.4).
        self.reset = ticks(0.002);
        self.settle = ticks(0.012);
        self.boot = ticks(0.5);
        self.preload = ticks(safety.preload_s);
        self.brake_open = ticks(safety.brake_open_s);
        // Five time constants of the slowest law's 50 rad/s take up what the model lacks.
        self.calm = ticks(0.1);
        self.test.set(safety.test_move_s, tick_hz, &safety.test_move, &config.joints);
        self.watch.set(WATCH_S, tick_hz, &watch_amplitude(config), &config.joints);
        self.pace = Pace::new(safety.stop_s, tick_hz);
        self.brake_set = ticks(safety.brake_set_s);
        self.torque_tail = ticks(safety.torque_tail_s);
        self.link = ticks(safety.link_timeout_s);
        self.jog = ticks(safety.jog_timeout_s);
        self.contacts = ticks(0.050);
        self.measure(config);
    }

    /// Fills in what is kept in counts and position words; casts stop at what a word holds.
    #[inline(never)]
    fn measure(&mut self, config: &Config) {
        let safety = &config.safety;
        let words = (1 << FRACTION_BITS) as f32;
        for (j, joint) in config.joints.iter().enumerate() {
            let code = |q: f32| (q - joint.encoder_zero) / joint.encoder_lsb;
            let counts = |way: f32| (way / joint.encoder_lsb) as u32;
            let slip = counts(safety.slip[j]);
            self.slip[j] = if slip > SLIP_MIN_COUNTS { slip } else { SLIP_MIN_COUNTS };
            self.lowest[j] = (code(joint.q_min) * words) as u32;
            self.highest[j] = (code(joint.q_max) * words) as u32;
            self.parked[j] = counts(safety.parked_tolerance);
        }
    }
}
