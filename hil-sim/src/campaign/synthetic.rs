//! Made-up runs for the tests of what is measured on real ones.

use shared::arm::JOINTS;
use shared::fault::Mode;
use shared::telemetry::Record;

use super::trial::{TICK_S, Trial};
use super::witness::Seen;
use crate::bench::OutputLevels;
use crate::session::Frame;

/// Torque on, brakes open.
pub const LIVE: OutputLevels = OutputLevels {
    ldac: true,
    drive_enable: [true; JOINTS],
    sto: true,
    brake_release: [true; JOINTS],
    dac_reset: true,
    adc_reset: true,
    watchdog: false,
};

/// An arm that holds its pose under torque, `count` ticks of it from the path's start on.
pub fn holding(count: usize) -> Trial {
    let record = Record { mode: Mode::Holding as u8, ..Record::default() };
    let frame = |i: usize| Frame {
        true_s: i as f64 * TICK_S,
        ticked: true,
        q: [0.0; JOINTS],
        qd: [0.0; JOINTS],
        tip_m: [4.0, 0.0, 1.0],
        tip_m_s: [0.0; 3],
        torque: [1.0; JOINTS],
        pins: LIVE,
        chain_closed: true,
        record,
    };
    Trial {
        frames: (0..count).map(frame).collect(),
        seen: vec![Seen::default(); count],
        brakes_open: vec![[true; JOINTS]; count],
        start: Some(0),
        start_s: Some(0.0),
        events: Vec::new(),
    }
}

impl Trial {
    /// Torque off and brakes set from step `from` on.
    pub fn cut(mut self, from: usize, mode: Mode) -> Self {
        for frame in &mut self.frames[from..] {
            frame.record.mode = mode as u8;
            frame.torque = [0.0; JOINTS];
            frame.pins = OutputLevels {
                drive_enable: [false; JOINTS],
                sto: false,
                brake_release: [false; JOINTS],
                ..LIVE
            };
        }
        self
    }

    /// In this mode from step `from` on.
    pub fn mode(mut self, from: usize, mode: Mode) -> Self {
        self.frames[from..].iter_mut().for_each(|frame| frame.record.mode = mode as u8);
        self
    }
}
