//! The emulated board's image, and its ticks traced through a scenario.

use std::path::PathBuf;
use std::process::Command;

use hil_sim::pil::Emulator;
use hil_sim::run::config_of;
use hil_sim::scenario::Scenario;
use hil_sim::session::Session;

use crate::image::Image;
use crate::stage::Stage;
use crate::trace::{self, Request, Trace};

/// Stages of a tick, by the functions that they consist of.
pub const STAGES: &[Stage] = &[
    ("link", &["mps2_an386::link::"]),
    ("read and decode", &["drivers::encoder::", "Ads131m04"]),
    ("memory", &["control::memory::"]),
    ("estimate", &["estimator::", "Core>::state"]),
    ("monitor", &["control::monitor::", "controller::sample::", "::sample"]),
    (
        "trajectory",
        &["control::path::", "supervisor::follow::", "Bump", "Mode::place", "Core>::aim"],
    ),
    ("kinematics and dynamics", &["control::dynamics::"]),
    ("law and adaptation", &["control::law::"]),
    ("control", &["controller::control::"]),
    ("supervise", &["controller::decide::", "::supervise", "control::supervisor::"]),
    ("telemetry", &["Core>::record"]),
    (
        "encode and write",
        &["Dac81404", "firmware::io::", "executive::output::", "controller::record::"],
    ),
];

/// Index of the emulator link in [`STAGES`]: wire time on silicon, left out of every sum.
pub const LINK: usize = 0;

/// The folder that cargo builds into: a test program lies two below a profile's.
pub fn target_folder() -> PathBuf {
    let test = std::env::current_exe().expect("path of the test program");
    test.ancestors().nth(3).expect("the target folder").into()
}

/// A program for the target, built beforehand by `tests/run`.
pub fn open(name: &str) -> Image {
    let path = target_folder().join("thumbv7em-none-eabihf/release").join(name);
    assert!(path.exists(), "{} is missing; `tests/run` builds it", path.display());
    Image::open(&path).expect("a readable image")
}

/// Builds the plug-in.
pub fn plugin() -> PathBuf {
    let status = Command::new(env!("CARGO"))
        .args(["build", "--quiet", "--release", "--package", "trace-plugin"])
        .status();
    assert!(status.expect("cargo").success(), "the trace plug-in does not build");
    target_folder().join("release/libtrace_plugin.so")
}

/// Runs `scenario` on `image` and prices each tick, from reset to the end.
///
/// # Panics
/// Where emulator or plug-in fail.
pub fn trace(image: &Image, plugin: &std::path::Path, scenario: &Scenario) -> Trace {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let request = Request { plugin, folder: folder.path(), tick: "tick", stages: STAGES };
    let arguments = trace::arguments(image, &request).expect("a price list");
    let mut session = Session::new(scenario, false);
    let config = config_of(scenario);
    let mut board =
        Emulator::start_with(&image.path, &config, session.retained(), session.bench(), &arguments)
            .expect("the emulator starts");
    while !session.is_over() {
        let ticked = session.tick(&mut board);
        ticked
            .unwrap_or_else(|e| panic!("{}, period {}: {e}", scenario.name, session.progress().0));
    }
    board.stop().expect("the emulator ends");
    trace::results(folder.path()).expect("the plug-in's results")
}
