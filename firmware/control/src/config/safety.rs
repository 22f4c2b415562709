//! Times and thresholds of the supervisor and its monitors, each with where it comes from.
//!
//! Noise figures are those of the reference parts: an encoder's quantisation of half a count, a torque
//! channel's 1.8e-5 of full scale (2.7 N m on joint 2). T is one tick.

use core::slice;

use bytemuck::{Pod, Zeroable};
use shared::arm::JOINTS;

use super::check::Check;
use super::fields::Field;

/// Everything that decides when the arm is stopped and how. SI units; joint 4 in m and N.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Safety {
    /// A stop brings the path rate to zero in this time (SS1), s.
    pub stop_s: f32,
    /// Torque is on this long before the brakes are told to open, s. Drives follow within ticks; 20 ms is
    /// far beyond that.
    pub preload_s: f32,
    /// A released brake must report open after this, s: 150 ms to open and 100 ms of grace, less the ticks from
    /// order to pin and from contact to mode.
    pub brake_open_s: f32,
    /// A set brake must report closed after this, s: 100 ms to close and 150 ms of grace.
    pub brake_set_s: f32,
    /// Torque stays on this long after the last brake reported closed, s.
    pub torque_tail_s: f32,
    /// Duration of the test move out and back, s.
    pub test_move_s: f32,
    /// Its amplitude: 1 mm at the tip with joints 1 and 2 at 6.7 m of reach, joint 3 at 4 m.
    pub test_move: [f32; JOINTS],
    /// While moving, the operator link may be silent this long, s.
    pub link_timeout_s: f32,
    /// A jog goes on this long after its last frame, s.
    pub jog_timeout_s: f32,
    /// Where joints 2 to 4 are taken when a brake slips: a pose that every brake holds with little load.
    pub rest_pose: [f32; JOINTS - 1],
    /// Speed on the way there over the joints' speed limits.
    pub lowering_share: f32,
    /// Payload that every motion must be stoppable with, kg.
    pub rated_payload_kg: f32,
    /// Share of the torque limits that a stop may need.
    pub torque_reserve: f32,
    /// The pose at power-up may differ this much from the parked one: half of the 0.2 rad by which any two
    /// encoders differ in a shipped pose.
    pub parked_tolerance: f32,
    /// Acceleration that neither command nor model foresees: 1.3 times the most that picking up or dropping
    /// 300 kg causes in any pose (0.3, 3.3, 15.4 rad/s², 18.7 m/s², from the plant), at least 1.
    pub unforeseen: [f32; JOINTS],
    /// Highest acceleration of a joint that no law controls: 1.5 times the torque limit, which a brake gives,
    /// over the least inertia of any pose.
    pub violent: [f32; JOINTS],
    /// A torque channel this far from the command warns: 0.5 % of the torque limit, 220 sigma of noise.
    pub torque_warn: [f32; JOINTS],
    /// And this far it counts as wrong: 1 %.
    pub torque_wrong: [f32; JOINTS],
    /// A wrong torque is believed when the speed error exceeds this, rad/s and m/s: more than
    /// thirty times the highest that the observer's noise gets at 26 bits, and reached within 2 ms by a limp joint.
    pub speed_error: [f32; JOINTS],
    /// Speed error that counts as swinging when it comes back again and again, rad/s and m/s: ten times the
    /// highest that the observer's noise gets at 26 bits.
    pub swing: [f32; JOINTS],
    /// A position error beyond this for [`Safety::tracking_s`] stops the arm: 3 mm at full reach with joint 2,
    /// 5 mm with joint 3. The worst that lasts as long in a shipped scenario is a PD's that picks up 300 kg
    /// unknown to its model: 6.3e-4 rad on joint 3, 7.8e-4 m on joint 4.
    pub tracking: [f32; JOINTS],
    /// See [`Safety::tracking`], s.
    pub tracking_s: f32,
    /// No control error can be this large in one tick; a larger one is a damaged number.
    pub error_window: [f32; JOINTS],
    /// A joint is too fast beyond this multiple of its speed limit.
    pub overspeed: f32,
    /// A joint may pass its range of motion by this.
    pub overtravel: [f32; JOINTS],
    /// A joint has slipped in its brake when it moved this far: reached in 3 ms at 1 rad/s².
    pub slip: [f32; JOINTS],
    /// Rate of the board's cycle counter, Hz.
    pub clock_hz: u32,
    /// Share of a tick that computation may take.
    pub budget: f32,
    /// Conversions of the torque converter a second, by its own clock.
    pub conversions_hz: f32,
}

impl Safety {
    /// For the reference arm.
    pub const REFERENCE: Self = Self {
        stop_s: 0.150,
        preload_s: 0.020,
        brake_open_s: 0.249,
        brake_set_s: 0.250,
        torque_tail_s: 0.050,
        test_move_s: 0.300,
        test_move: [1.5e-4, 1.5e-4, 2.5e-4, 1e-3],
        link_timeout_s: 0.250,
        jog_timeout_s: 0.100,
        rest_pose: [1.25, -1.1, 3.2],
        lowering_share: 0.1,
        rated_payload_kg: 300.0,
        torque_reserve: 0.9,
        parked_tolerance: 0.1,
        unforeseen: [1.0, 4.3, 20.0, 24.3],
        violent: [200.0, 100.0, 120.0, 400.0],
        torque_warn: [150.0, 600.0, 350.0, 150.0],
        torque_wrong: [300.0, 1_200.0, 700.0, 300.0],
        speed_error: [3e-3, 3e-3, 3e-3, 6e-3],
        swing: [1e-3, 1e-3, 1e-3, 2e-3],
        tracking: [4e-4, 4e-4, 1e-3, 2e-3],
        tracking_s: 0.050,
        error_window: [5e-3, 5e-3, 5e-3, 2e-2],
        overspeed: 1.2,
        overtravel: [0.01, 0.01, 0.01, 0.01],
        slip: [5e-6, 5e-6, 5e-6, 1e-5],
        clock_hz: 168_000_000,
        budget: 0.5,
        conversions_hz: 32_000.0,
    };

    pub(super) fn validate(&self, check: &mut Check) {
        const FIRST: Field = Field::named("stop_s");
        check.group(FIRST, 0, bytemuck::cast_slice(slice::from_ref(self)));
    }
}
