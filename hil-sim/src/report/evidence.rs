//! evidence.csv and evidence.json: what the controller kept of the time before a stop.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use serde::Serialize;
use shared::arm::JOINTS;
use shared::evidence::{Entry, ErrorEntry, Image};
use shared::fault::{Fault, Mode};

/// One row a tick: the thinned ring, then the one at full rate, each oldest first.
pub(super) fn write_ticks(path: &Path, image: &Image) -> std::io::Result<()> {
    let mut file = csv::Writer::from_path(path)?;
    file.write_record(header())?;
    for (ring, entries) in [
        ("thin", image.thin_in_order().collect::<Vec<_>>()),
        ("full", image.full_in_order().collect()),
    ] {
        for entry in entries {
            file.write_record(row(ring, entry))?;
        }
    }
    file.flush()
}

fn header() -> Vec<String> {
    let flags = ["joint_bits", "limit_bits", "rejected_bits", "powered_bits", "saturated_bits"];
    let single = ["ring", "tick", "mode", "fault"].into_iter().chain(flags);
    let joints = |name: &str, units: [&str; JOINTS]| -> Vec<String> {
        let numbered = units.iter().enumerate();
        numbered.map(|(j, unit)| format!("{name}{}_{unit}", j + 1)).collect()
    };
    let mut all: Vec<String> = single.chain(["path_rate", "bucket"]).map(Into::into).collect();
    all.extend(joints("encoder", ["count"; JOINTS]));
    all.extend(joints("e_controller", ["rad", "rad", "rad", "m"]));
    all.extend(joints("dac", ["count"; JOINTS]));
    all.extend(joints("adc", ["256_count"; JOINTS]));
    all
}

fn row(ring: &str, e: &Entry) -> Vec<String> {
    let flags =
        [e.joints.into(), e.limits, e.rejected.into(), e.powered.into(), e.saturated.into()];
    let mut all = vec![ring.into(), e.tick.to_string(), e.mode.to_string(), e.fault.to_string()];
    all.extend(flags.map(|bits: u16| bits.to_string()));
    all.extend([e.path_rate.to_string(), e.bucket.to_string()]);
    all.extend(e.code.map(|code| code.to_string()));
    all.extend(e.e1.map(|e1| format!("{e1:e}")));
    all.extend(e.dac.map(|code| code.to_string()));
    all.extend(e.adc.map(|code| code.to_string()));
    all
}

/// What happened, without the rings.
#[derive(Serialize)]
struct Summary {
    /// Boots since the memory was first written.
    boots: u32,
    /// Exception that ended the run before this boot.
    #[serde(skip_serializing_if = "Option::is_none")]
    crash: Option<Crash>,
    /// Tick at which the ring at full rate was frozen.
    trigger_tick: Option<u32>,
    /// Errors seen; the first of them are listed.
    error_count: u32,
    errors: Vec<Error>,
}

#[derive(Serialize)]
struct Crash {
    fault: &'static str,
    /// Fault status register (Armv7-M ARM B3.2.15, CFSR).
    cfsr: u32,
}

#[derive(Serialize)]
struct Error {
    tick: u32,
    number: u16,
    fault: &'static str,
    mode: &'static str,
    /// From 1 on.
    joints: Vec<usize>,
}

impl From<&ErrorEntry> for Error {
    fn from(entry: &ErrorEntry) -> Self {
        Self {
            tick: entry.tick,
            number: entry.fault,
            fault: Fault::from_number(entry.fault).map_or("Unknown", Fault::name),
            mode: Mode::from_number(entry.mode).map_or("Unknown", Mode::name),
            joints: (1..=JOINTS).filter(|j| entry.joints >> (j - 1) & 1 != 0).collect(),
        }
    }
}

pub(super) fn write_summary(path: &Path, image: &Image) -> std::io::Result<()> {
    let crash = image.crash_fault();
    let summary = Summary {
        boots: image.boots,
        crash: crash.map(|fault| Crash { fault: fault.name(), cfsr: image.crash_status }),
        trigger_tick: (image.frozen != 0).then_some(image.trigger),
        error_count: image.error_count,
        errors: image.errors_in_order().map(Error::from).collect(),
    };
    Ok(serde_json::to_writer_pretty(BufWriter::new(File::create(path)?), &summary)?)
}
