//! Faults begin and end when they should, do what they are named after, and repeat with their seed.

use firmware::controller::Core;
use hil_sim::faults::{Injection, Kind, Place, SPECS, Target};
use hil_sim::run::{RunError, Software, kept_of};
use hil_sim::scenario::Scenario;
use hil_sim::session::{Event, Session};
use shared::command::Command;
use shared::fault::{Fault, Limit, Mode};

use super::rig::{TICK_S, are_same, lift, rest, run, run_on};

fn records(scenario: &Scenario) -> Vec<[u8; 128]> {
    run(scenario).tape.frames.iter().map(|frame| frame.record.to_bytes()).collect()
}

/// One injection of a kind at its first target.
fn one(kind: Kind, at_s: f64) -> Injection {
    Injection::new(kind, kind.spec().targets[0], at_s)
}

#[test]
fn faults_that_never_come_change_nothing() {
    let never = SPECS.iter().filter(|spec| spec.kind != Kind::ConfigFlip);
    // The counter's wrap shows in the counter from power-up on, and in nothing else.
    let never = never.map(|spec| one(spec.kind, 900.0)).collect::<Vec<_>>();
    assert_eq!(records(&lift(&never)), records(&lift(&[])));
}

#[test]
fn every_kind_on_every_target_runs_and_repeats_bit_for_bit() {
    for spec in SPECS.iter().filter(|spec| spec.kind != Kind::ConfigFlip) {
        for target in spec.targets {
            let scenario = lift(&[Injection::new(spec.kind, *target, 0.3)]);
            let (first, second) = (run(&scenario), run(&scenario));
            let bytes = |run: &super::rig::Run| {
                run.tape.frames.iter().map(|f| f.record.to_bytes()).collect::<Vec<_>>()
            };
            assert!(bytes(&first) == bytes(&second), "{} on {target}", spec.name);
            assert!(first.end().q.iter().all(|q| q.is_finite()), "{} on {target}", spec.name);
            assert!(are_same(first.time_of(Event::Began(scenario.faults[0])).unwrap(), 0.3));
        }
    }
}

#[test]
fn random_faults_depend_on_the_seed_and_not_on_each_other() {
    let loss = Injection { severity: 0.2, ..Injection::new(Kind::FrameLoss, Target::Adc, 0.1) };
    let lost = |scenario: &Scenario| {
        let frames = run(scenario).tape.frames;
        frames.iter().map(|f| f.record.rejected & 0x10).collect::<Vec<_>>()
    };
    let short = |seed, faults: &[Injection]| Scenario {
        seed,
        faults: faults.iter().map(|one| Injection { for_s: Some(0.01), ..*one }).collect(),
        ..lift(&[])
    };
    let jump = Injection::new(Kind::WarningBit, Target::Encoder(0), 0.1);
    assert_eq!(lost(&short(1, &[loss])), lost(&short(1, &[loss, jump])));
    assert_ne!(lost(&short(1, &[loss])), lost(&short(2, &[loss])));
}

#[test]
fn one_shot_spoils_one_tick_and_a_duration_as_many_as_it_says() {
    let jump = Injection::new(Kind::Jump, Target::Encoder(1), 0.5);
    let rejected = |jump: Injection| {
        let run = run(&lift(&[jump]));
        let hit = run.since(0.0).iter().filter(|f| f.record.rejected & 2 != 0);
        let hit = hit.map(|f| f.true_s - run.since(0.5)[0].true_s).collect::<Vec<_>>();
        (hit.len(), hit.first().copied())
    };
    assert_eq!(rejected(jump), (1, Some(0.0)));
    assert_eq!(rejected(Injection { for_s: Some(2.0 * TICK_S), ..jump }), (2, Some(0.0)));
}

#[test]
fn time_before_the_start_is_known_beforehand() {
    // The arm is armed about 0.67 s before its start here.
    let silent = Injection { for_s: Some(0.05), ..one(Kind::WarningBit, -0.08) };
    let run = run(&lift(&[silent]));
    let began_s = run.time_of(Event::Began(silent)).expect("it begins");
    let ended_s = run.time_of(Event::Ended(silent)).expect("it ends");
    assert!(are_same(began_s, -0.08) && are_same(ended_s, -0.03), "{began_s} {ended_s}");
    let warned =
        run.tape.frames.iter().filter(|f| f.record.limits >> Limit::EncoderWarning as u16 & 1 != 0);
    assert_eq!(warned.count(), 100);
}

#[test]
fn fault_before_power_up_is_there_from_the_first_tick() {
    let run = run(&lift(&[one(Kind::Missing, -100.0)]));
    assert_eq!(run.events[0].0, 0.0);
    assert_eq!(run.mode_at_end(), Some(Mode::Boot));
}

#[test]
fn arm_without_a_trajectory_rests_armed_for_its_time() {
    let scenario = rest(&[one(Kind::WarningBit, 0.25)]);
    let run = run(&scenario);
    assert_eq!(run.mode_at_end(), Some(Mode::Holding));
    assert_eq!(run.since(0.0).len(), 2_001);
    assert!(run.since(0.0).iter().all(|f| f.record.mode == Mode::Holding as u8));
    assert!(are_same(run.time_of(Event::Began(scenario.faults[0])).unwrap(), 0.25));
}

#[test]
fn payload_comes_and_goes() {
    let added = Injection { severity: 50.0, ..one(Kind::Payload, 0.2) };
    let scenario = |faults: &[Injection]| {
        let mut scenario = lift(faults);
        (scenario.plant.payload_kg, scenario.model.payload_kg) = (100.0, 100.0);
        scenario
    };
    let kg = |faults: &[Injection]| run(&scenario(faults)).payload_kg;
    assert_eq!(kg(&[added]), 150.0);
    assert_eq!(kg(&[Injection { for_s: Some(0.1), ..added }]), 100.0);
    assert_eq!(kg(&[added, one(Kind::PayloadDrop, 0.3)]), 0.0);
}

#[test]
fn memory_is_changed_before_the_tick_that_finds_it() {
    let found = |kind, target, severity| {
        let run = run(&lift(&[Injection { severity, ..Injection::new(kind, target, 0.5) }]));
        run.first_fault().map(|(t_s, fault, _)| (((t_s - 0.5) / TICK_S).round() as i32, fault))
    };
    assert_eq!(found(Kind::NonFinite, Target::Joint(2), 1.0), Some((0, Fault::NotFinite)));
    let shadow = Target::Place(Place::Shadow);
    assert_eq!(found(Kind::Flip, shadow, 0.0), Some((0, Fault::ParameterFlipped)));
    assert_eq!(found(Kind::HugeError, Target::Joint(0), 30.0), Some((0, Fault::NotFinite)));
}

#[test]
fn flipped_configuration_is_refused() {
    let scenario = lift(&[one(Kind::ConfigFlip, 0.0)]);
    let session = Session::new(&scenario, false);
    let mut core = Core::new();
    let refused =
        Software::new(kept_of(&scenario), &session.bench(), session.retained(), &mut core);
    assert!(matches!(refused, Err(RunError::Config(error)) if error.field() == "check sum"));
}

#[test]
fn brakes_and_drives_obey_their_faults() {
    let jammed = run(&lift(&[one(Kind::BrakeJammed, -100.0)]));
    assert_eq!(jammed.first_fault().map(|(_, fault, _)| fault), Some(Fault::BrakeNotReleased));
    let lost = run(&lift(&[Injection::new(Kind::EnableLost, Target::Joint(1), 0.5)]));
    assert!(lost.since(0.5).iter().all(|f| f.torque[1] == 0.0));
    assert_eq!(
        lost.first_fault().map(|(_, fault, joints)| (fault, joints)),
        Some((Fault::DriveLost, 2))
    );
}

#[test]
fn orders_lead_out_of_a_stop_and_into_the_measured_pose() {
    let broken = Injection { for_s: Some(0.01), ..one(Kind::FrameLoss, 0.5) };
    let run = run_on(&lift(&[broken]), 1.5, &[Command::Clear, Command::Arm]);
    assert_eq!(run.first_fault().map(|(_, fault, _)| fault), Some(Fault::EncoderLost));
    assert_eq!(run.mode_at_end(), Some(Mode::Holding));
}
