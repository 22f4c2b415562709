//! Rows 22 and 23: orders that must not be followed.

use shared::command::{Command, GainName, Trajectory};
use shared::fault::Refusal;

use super::Ways;
use crate::campaign::pose::Pose;
use crate::campaign::row::{T, Variant};
use crate::campaign::trial::{Ask, Order};

/// 0.01 rad and half a millimetre.
fn step(path: &mut Trajectory) {
    path.origin_q6 = path.origin_q6.map(|word| word.wrapping_add(10_000 << 6));
}

fn far(path: &mut Trajectory) {
    path.amplitude_q5[1] = i32::MAX;
}

fn fast(path: &mut Trajectory) {
    path.duration_ticks = 20;
    path.amplitude_q5[1] = 1_000_000 << 5;
}

fn endless(path: &mut Trajectory) {
    path.duration_ticks = 0;
}

fn same(_: &mut Trajectory) {}

pub fn bad(pose: &Pose) -> Ways {
    let plain = |name: &str, command, reasons| Variant::refused(name, Ask::Plain(command), reasons);
    let path = |name: &str, change, reasons| Variant::refused(name, Ask::Path(change), reasons);
    let nan = [0.0, f32::NAN, 0.0, 0.0];
    let gain = |value| Command::SetGain { name: GainName::K1 as u8, values: [value; 4] };
    let stepped: &[Refusal] =
        if pose.moves() { &[Refusal::Busy] } else { &[Refusal::OriginMismatch] };
    Ok(vec![
        plain("jog at a speed that is no number", Command::Jog(nan), &[Refusal::NotFinite]),
        plain("jog too fast", Command::Jog([0.0, 5.0, 0.0, 0.0]), &[Refusal::TooFast]),
        plain("gain that is no number", gain(f32::NAN), &[Refusal::GainOutOfRange]),
        plain("gain out of range", gain(1e9), &[Refusal::GainOutOfRange]),
        plain("clear while armed", Command::Clear, &[Refusal::WrongMode]),
        path("path out of range", far, &[Refusal::OutOfRange]),
        path("path too fast", fast, &[Refusal::TooFast]),
        path("path without duration", endless, &[Refusal::BadDuration]),
        path("path that begins elsewhere", step, stepped),
    ])
}

pub fn untimely(pose: &Pose) -> Ways {
    let order = |at_s, command| Order { at_s, ask: Ask::Plain(command) };
    let armed = if pose.moves() { "arm while moving" } else { "arm twice" };
    let twice = Variant::refused(armed, Ask::Plain(Command::Arm), &[Refusal::WrongMode]);
    let mut stopped = Variant::refused(
        "path after a stop, without arming",
        Ask::Path(same),
        &[Refusal::WrongMode],
    );
    stopped.orders = vec![order(0.0, Command::Stop)];
    stopped.wrong[0].at_s = 0.6;
    let mut ways = vec![twice, stopped];
    if pose.moves() {
        let mut old = Variant::refused(
            "old path after arming anew",
            Ask::Path(same),
            &[Refusal::OriginMismatch],
        );
        old.orders =
            vec![order(0.0, Command::Stop), order(0.6, Command::Clear), order(0.9, Command::Arm)];
        old.wrong[0].at_s = 1.6 + 10.0 * T;
        ways.push(old);
    }
    Ok(ways)
}
