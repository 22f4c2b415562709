//! Modelled cycles of the firmware's law on target against its plain versions, over the same states.

use std::process::Command;

use hil_sim::outcome::Adaptation;
use hil_sim::scenario::Scenario;
use tests::board::{self, plugin};
use tests::image::Image;
use tests::stage::Stage;
use tests::trace::{self, Cost, Request, Trace};

/// States under each adaptation; those under the inertia-weighted one come first.
const STATES: usize = 32;

const ADAPTATIONS: [&str; 2] = ["inertia-weighted", "paper's psi"];
const INERTIA_WEIGHTED: usize = 0;
const PAPER_PSI: usize = 1;

/// Plain cycles that no state may exceed.
const MAX_CYCLES: [u64; 2] = [700, 800];

/// Times fewer plain cycles than the better plain version takes, both in the mean over the states.
const RATIO_MIN: f64 = 20.0;

/// `libm`'s sine, cosine and square root, with the soft `f64` that they call, and all else.
const STAGES: &[Stage] =
    &[("libm", &["libm::"]), ("rest", &["laws::", "plain::", "nalgebra::", "core::array::"])];
const LIBM: usize = 0;

/// One law, traced over all states under each adaptation.
struct Row {
    name: &'static str,
    traces: [Trace; 2],
    stdout: String,
}

impl Row {
    /// Runs the image and prices each call of `function`.
    fn measure(image: &Image, name: &'static str, function: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let plugin = plugin();
        let request =
            Request { plugin: &plugin, folder: folder.path(), tick: function, stages: STAGES };
        let mut emulator = Command::new("timeout");
        emulator
            .args(["60", "qemu-system-arm", "-M", "mps2-an386", "-nographic"])
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(&image.path);
        let Trace { ticks, sites, stdout } =
            trace::run(image, &request, emulator).expect("a trace");
        assert_eq!(ticks.len(), 2 * STATES, "calls of {function}");
        let (weighted, paper) = ticks.split_at(STATES);
        let traces = [weighted, paper].map(|ticks| Trace {
            ticks: ticks.to_vec(),
            sites: sites.clone(),
            stdout: String::new(),
        });
        Self { name, traces, stdout }
    }

    /// Mean plain cycles of the stages that `counts` accepts.
    fn cycles(&self, adaptation: usize, counts: impl Fn(usize) -> bool) -> f64 {
        self.traces[adaptation].spread(counts, |c| c.plain).mean
    }

    /// Instructions and cycles, and how many of the plain cycles are `libm`'s.
    fn print(&self, adaptation: usize) {
        print!("{:18}{:18}", ADAPTATIONS[adaptation], self.name);
        let trace = &self.traces[adaptation];
        for figure in [|c: &Cost| c.instructions, |c: &Cost| c.plain, |c: &Cost| c.pessimistic] {
            let all = trace.spread(|_| true, figure);
            print!("{:8}{:8.0}{:8}", all.min, all.mean, all.max);
        }
        println!("{:8.0}", self.cycles(adaptation, |stage| stage == LIBM));
    }
}

/// The number behind `name` in what the image wrote.
fn value(stdout: &str, name: &str) -> f64 {
    let found = stdout.lines().find_map(|l| l.strip_prefix(name)?.trim().parse().ok());
    found.unwrap_or_else(|| panic!("no {name} in {stdout:?}"))
}

/// Route two of every result: the image compares torque and estimate of all three laws at each state.
#[test]
fn the_law_costs_a_twentieth_of_its_plain_versions() {
    let image = board::open("laws");
    let ours = Row::measure(&image, "closed form", "laws::ours");
    let plain = [
        Row::measure(&image, "CRBA and RNEA", "laws::plain_crba"),
        Row::measure(&image, "five RNEA calls", "laws::plain_five_calls"),
    ];

    println!("{:36}{:^24}{:^24}{:^24}{:>8}", "", "instructions", "cycles", "pessimistic", "libm");
    let ratios = [INERTIA_WEIGHTED, PAPER_PSI].map(|adaptation| {
        ours.print(adaptation);
        plain.iter().for_each(|row| row.print(adaptation));
        // Whatever is left out of the plain versions, the closed form counts in full.
        let ratio = |counts: fn(usize) -> bool| {
            let [crba, five_calls] = plain.each_ref().map(|row| row.cycles(adaptation, counts));
            crba.min(five_calls) / ours.cycles(adaptation, |_| true)
        };
        let (all, without_libm) = (ratio(|_| true), ratio(|stage| stage != LIBM));
        println!("{all:.1} times fewer cycles than the better, {without_libm:.1} without its libm");
        all
    });
    print!("{}", ours.stdout);

    // Four joints' torque and estimate.
    assert_eq!(value(&ours.stdout, "compared "), (2 * STATES * plain.len() * 8) as f64);
    assert_eq!(value(&ours.stdout, "agreeing "), value(&ours.stdout, "compared "));
    for (adaptation, max) in MAX_CYCLES.into_iter().enumerate() {
        let worst = ours.traces[adaptation].spread(|_| true, |c| c.plain).max;
        assert!(worst <= max, "{}: {worst} cycles", ADAPTATIONS[adaptation]);
    }
    assert!(ratios[INERTIA_WEIGHTED] >= RATIO_MIN, "{ratios:?}");
}

/// The same functions in the product's tick, where they also tell saturated joints from others.
#[test]
fn the_product_tick_keeps_the_same_bounds() {
    let image = board::open("mps2-an386");
    let mut scenario = Scenario::load("paper").expect("a shipped scenario");
    scenario.duration_s = 1.0;
    let is_law = |stage: usize| {
        let name = board::STAGES.get(stage).map(|s| s.0);
        name.is_some_and(|n| ["kinematics and dynamics", "law and adaptation"].contains(&n))
    };
    for (adaptation, max) in [Adaptation::Inertia, Adaptation::Paper].into_iter().zip(MAX_CYCLES) {
        scenario.controller.adaptation = adaptation;
        let trace = board::trace(&image, &plugin(), &scenario);
        let law = trace.spread(is_law, |c| c.plain);
        println!("in the product's tick, {adaptation:?}: {} cycles at worst", law.max);
        // Before the arm is enabled no law runs.
        assert!(law.max > max / 2 && law.max <= max, "{adaptation:?}: {law:?}");
    }
}
