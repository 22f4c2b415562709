//! What a run was like from power-up on, step by step: truth, pins and telemetry side by side.

use shared::arm::JOINTS;
use shared::telemetry::Record;

use crate::bench::{Bench, OutputLevels};
use crate::plant::Plant;

/// One step: a tick of the controller, or a time at which none came.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Since power-up, s.
    pub true_s: f64,
    /// The controller ticked; else `record` is that of the tick before.
    pub ticked: bool,
    /// Joint positions at this instant, rad and m.
    pub q: [f64; JOINTS],
    /// Joint speeds, rad/s and m/s.
    pub qd: [f64; JOINTS],
    /// Tip position, world axes, m.
    pub tip_m: [f64; 3],
    /// Tip velocity, world axes, m/s.
    pub tip_m_s: [f64; 3],
    /// Torque of the drives from this instant on, N m and N.
    pub torque: [f64; JOINTS],
    /// Output pins as the tick left them.
    pub pins: OutputLevels,
    /// The hardware's safety chain lets torque flow.
    pub chain_closed: bool,
    /// The controller's record.
    pub record: Record,
}

/// All steps of a run, and where its time begins.
#[derive(Clone, Debug, Default)]
pub struct Tape {
    /// From power-up on.
    pub frames: Vec<Frame>,
    /// Index of the frame at t = 0, once it has come.
    pub start: Option<usize>,
}

impl Tape {
    /// Adds a step.
    pub(super) fn add(
        &mut self,
        true_s: f64,
        record: (bool, Record),
        plant: &Plant,
        torque: &[f64; JOINTS],
        bench: &Bench,
    ) {
        let (ticked, record) = record;
        let (q, qd) = (plant.q(), plant.qd());
        let (tip_m, tip_m_s) = plant.model().tip(&q, &qd);
        self.frames.push(Frame {
            true_s,
            ticked,
            q,
            qd,
            tip_m,
            tip_m_s,
            torque: *torque,
            pins: bench.outputs,
            chain_closed: bench.chain_closed(),
            record,
        });
    }
}
