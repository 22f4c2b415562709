//! What a fault demands of a controller that has the arm under torque, and until when, by the harness's knowledge.

use firmware::config::Safety;
use hil_sim::faults::{Injection, Kind, Place, Target};
use hil_sim::session::Frame;

/// Latest number of ticks to a reaction; each is that of the fault list and a few ticks of grace.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Demand {
    /// Any stop.
    Stop(u32),
    /// Torque off by the firmware.
    Sto(u32),
    /// Torque off by the hardware.
    Hardware(u32),
}

use Demand::{Hardware, Sto, Stop};

const TICK_HZ: f64 = 2_000.0;
/// A full loss bucket: the third loss, and grace.
const BUCKET: u32 = 6;
/// Actuators have 5 ms.
const ACTUATOR: u32 = 14;

impl Demand {
    /// What `fault` demands that begins now; `None` where it may be tolerated, or depends on more than is known.
    pub fn of(fault: &Injection, now: &Frame) -> Option<Self> {
        use Kind::*;
        let demand = match fault.kind {
            BitFlips | Burst | Mutation | Dead | Missing => lost(fault.target),
            FrameLoss if fault.severity == 1.0 => lost(fault.target),
            Repeat if matches!(fault.target, Target::Adc | Target::All) => Stop(BUCKET),
            Zeros | ErrorBit | Overrange => Stop(BUCKET),
            Jump => Stop(10),
            Swap => Stop(5),
            TorqueDrift => drift(fault)?,
            EnableLost if loaded(fault, now) => Stop(ACTUATOR),
            TorqueInverted if loaded(fault, now) => Sto(ACTUATOR),
            TorqueStuck => Sto(ACTUATOR),
            EStop | WireBroken | ContactsDiffer => Stop(4),
            NonFinite | HugeError => Stop(3),
            LateTick if fault.severity >= 5.0 => Stop(4 + fault.severity as u32),
            Hang => Hardware(20),
            EarlyKick => Hardware(10),
            Flip => match fault.target {
                Target::Place(Place::Gain | Place::Limit | Place::Arm) => Stop(5),
                _ => Stop(210),
            },
            AdcReset => Stop(210),
            DacReset => Sto(5),
            _ => return None,
        };
        fault.for_s.is_none_or(|for_s| for_s * TICK_HZ > demand.ticks()).then_some(demand)
    }

    /// Ticks that it leaves.
    pub fn ticks(self) -> f64 {
        let (Stop(ticks) | Sto(ticks) | Hardware(ticks)) = self;
        f64::from(ticks)
    }
}

fn lost(target: Target) -> Demand {
    match target {
        Target::Dac | Target::All => Sto(BUCKET),
        _ => Stop(BUCKET),
    }
}

/// 50 ms past the threshold.
fn drift(fault: &Injection) -> Option<Demand> {
    let wrong = |j: usize| f64::from(Safety::REFERENCE.torque_wrong[j]) / fault.severity.abs();
    let reached_s = fault.target.joints().map(wrong).fold(f64::INFINITY, f64::min);
    Some(Stop(((reached_s + 0.050) * TICK_HZ) as u32 + 10))
}

/// Whether the torque lost is far more than what counts as wrong.
fn loaded(fault: &Injection, now: &Frame) -> bool {
    let far = |j: usize| now.torque[j].abs() > 3.0 * f64::from(Safety::REFERENCE.torque_wrong[j]);
    fault.target.joints().any(far)
}
