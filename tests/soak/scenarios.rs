//! Every shipped scenario, again and again, with noise on its sensors and losses on its bus: nothing trips.

use firmware::controller::Core;
use hil_sim::faults::{Injection, Kind, Target};
use hil_sim::run::{Software, kept_of};
use hil_sim::scenario::Scenario;
use hil_sim::session::Session;
use rayon::prelude::*;
use shared::fault::{Fault, Mode};

/// Seeds of the runs.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=60;
/// Share of its ticks in which a device is not heard.
const LOSS: f64 = 0.001;
/// An encoder latches earlier or later by as much, s: what `campaign` counts as noise. In the lift that is up to
/// 5 counts; a head's own sampling moment is good to 25 ns. The torque converter's chip has its data-sheet noise
/// in any case.
const JITTER_S: f64 = 2e-6;
/// Before power-up.
const EVER_S: f64 = -900.0;

/// A shipped scenario, without faults of its own. The bit errors of `noisy-bus` are its losses: their checks refuse
/// 0.1 % of its answers. Twice as many make three in a row likely: 2e-9 to 2e-7 a tick and device, over 1.3 million
/// ticks.
fn disturbed(name: &str, seed: u64) -> Scenario {
    let mut scenario = Scenario::load(name).expect("a shipped scenario");
    let noise = Injection {
        severity: JITTER_S,
        ..Injection::new(Kind::SampleJitter, Target::Encoders, EVER_S)
    };
    let loss = Injection { severity: LOSS, ..Injection::new(Kind::FrameLoss, Target::All, EVER_S) };
    let loss = (scenario.bus.error_share == 0.0).then_some(loss);
    scenario.faults = [noise].into_iter().chain(loss).collect();
    (scenario.seed, scenario.expect) = (seed, None);
    scenario
}

/// What a run was like.
#[derive(Clone, Copy, Debug, Default)]
struct Seen {
    /// Samples not used once the arm was ready.
    rejected: u32,
    /// Highest level of a loss bucket then.
    bucket: u8,
    /// Runs whose boot missed a frame and had to start over.
    late_boots: u32,
}

impl Seen {
    fn with(self, other: Self) -> Self {
        Self {
            rejected: self.rejected + other.rejected,
            bucket: self.bucket.max(other.bucket),
            late_boots: self.late_boots + other.late_boots,
        }
    }
}

/// Runs to the end; what went wrong, if anything did.
fn soak(scenario: &Scenario) -> Result<Seen, String> {
    let mut session = Session::new(scenario, false);
    let mut core = Core::new();
    let (kept, bench) = (kept_of(scenario), session.bench());
    let mut software = Software::new(kept, &bench, session.retained(), &mut core)
        .map_err(|error| error.to_string())?;
    let mut seen = Seen::default();
    while !session.is_over() {
        let Ok(record) = session.tick(&mut software);
        let mode = Mode::from_number(record.mode).ok_or("no mode")?;
        match mode {
            Mode::Boot => {
                seen.late_boots |= u32::from(record.fault == Fault::BootTimeout as u16);
                continue;
            }
            Mode::Standby | Mode::Arming | Mode::Holding | Mode::Moving => {}
            _ => {
                let fault = Fault::from_number(record.fault).map_or("?", Fault::name);
                let (t, joints) = (record.tick, record.joints);
                return Err(format!("{mode:?} in tick {t}: {fault}, joints {joints:04b}"));
            }
        }
        seen.rejected += record.rejected.count_ones();
        seen.bucket = seen.bucket.max(record.bucket);
    }
    let outcome = session.outcome(1.0);
    let unfinished = outcome.broken_limits.iter().find(|told| told.contains("its end"));
    match unfinished {
        Some(told) => Err(told.clone()),
        None if !outcome.faults.is_empty() => Err(outcome.faults.join(", ")),
        None => Ok(seen),
    }
}

#[test]
fn sixty_runs_of_each_scenario_trip_nothing() {
    for (name, _) in Scenario::shipped() {
        let runs = SEEDS.into_par_iter().map(|seed| (seed, soak(&disturbed(name, seed))));
        let runs = runs.collect::<Vec<_>>();
        let tripped = runs.iter().filter_map(|(seed, run)| Some((seed, run.as_ref().err()?)));
        let tripped = tripped.collect::<Vec<_>>();
        assert!(tripped.is_empty(), "{name}: {} of {}: {tripped:?}", tripped.len(), runs.len());
        let all =
            runs.into_iter().filter_map(|(_, run)| run.ok()).fold(Seen::default(), Seen::with);
        println!("{name}: {all:?}");
        assert!(all.rejected > 1_000, "{name}: {all:?}");
    }
}
