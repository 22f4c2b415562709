//! A cell that passes falls short as soon as any of its limits is tightened, or its twin gets the fault.

use shared::fault::Fault;

use super::*;
use crate::campaign::onset::Condition;
use crate::campaign::row::fault;
use crate::faults::{Kind, Target};

const SEED: u64 = 1;

fn pose() -> Pose {
    named("lowering")
}

fn named(name: &str) -> Pose {
    let poses = Pose::all().expect("good poses");
    poses.into_iter().find(|pose| pose.name == name).expect("a pose of that name")
}

/// Three lost frames in a row.
fn lost() -> Variant {
    let faults = vec![fault(Kind::FrameLoss, Target::Encoder(2)).ticks(3)];
    let sign = Sign::Fault(&[Fault::EncoderLost]);
    Variant::new("lost", faults, Expect::Ss1, sign, 1, 3).from(Condition::BucketFull(2))
}

fn short(variant: Variant) -> Vec<String> {
    judge(&variant, &pose(), SEED, Path::new("")).short
}

#[test]
fn a_sound_cell_passes() {
    let verdict = judge(&lost(), &pose(), SEED, Path::new(""));
    assert_eq!(verdict.short, Vec::<String>::new());
    assert_eq!((verdict.reaction, verdict.fault), (Reaction::Ss1, Fault::EncoderLost));
    assert_eq!((verdict.detect_ticks, verdict.react_ticks), (Some(1), Some(1)));
    assert!(verdict.drop_m > 0.0 && verdict.drop_m < TIGHT_M && !verdict.twin_tripped);
    assert!(!verdict.curve.is_empty());
}

#[test]
fn broken_limits_of_time_fall_short() {
    assert_eq!(short(Variant { detect: 0, ..lost() }), ["noticed after 1 ticks, at most 0"]);
    let early = vec![(Condition::BucketFull(2), 0)];
    assert_eq!(short(Variant { react: early, ..lost() }), ["reacted after 1 ticks, at most 0"]);
}

/// An arm that was to rise until the condition is complete is not too low because it was stopped before.
#[test]
fn a_stop_before_its_condition_is_compared_with_one_at_its_own_time() {
    let late = lost().from(Condition::After(400));
    let verdict = judge(&late, &named("lifting"), SEED, Path::new(""));
    assert_eq!((verdict.react_ticks, verdict.short), (Some(0), Vec::new()));
}

#[test]
fn another_reaction_fault_or_drop_falls_short() {
    let told = short(Variant { expect: Expect::Sto, ..lost() });
    assert_eq!(told, ["reaction SS1 (EncoderLost), not STO"]);
    let told = short(Variant { sign: Sign::Fault(&[Fault::DriveLost]), ..lost() });
    assert_eq!(told, ["not noticed: no fault DriveLost"]);
    let told = short(Variant { drop: Drop::Zero, ..lost() });
    assert!(told.iter().any(|one| one.ends_with("away from its path")), "{told:?}");
}

#[test]
fn a_twin_that_trips_falls_short() {
    let twin = lost().faults;
    assert_eq!(short(lost().twin(twin)), ["the twin tripped"]);
    let two = vec![fault(Kind::FrameLoss, Target::Encoder(2)).ticks(2)];
    assert_eq!(short(lost().twin(two)), Vec::<String>::new());
}

#[test]
fn a_reaction_that_never_comes_falls_short() {
    let nothing = vec![fault(Kind::WarningBit, Target::Encoder(2))];
    let told = short(Variant { faults: nothing, ..lost() }.from(Condition::Begun));
    assert_eq!(told, ["not noticed: no fault EncoderLost", "reaction none (None), not SS1"]);
}

#[test]
fn bare_plant_sinks_the_further_the_later_the_reaction() {
    let dead = vec![fault(Kind::DacReset, Target::Only)];
    let sign = Sign::Fault(&[Fault::DacReset, Fault::DacNotAcknowledged]);
    let limp = Drop::Bound(crate::campaign::row::Acting::Limp);
    let bound = |limit| {
        let way = Variant::new("dead", dead.clone(), Expect::Sto, sign, 2, limit).dropping(limp);
        judge(&way, &pose(), SEED, Path::new("")).bound_m
    };
    let [soon, late] = [3, 40].map(bound);
    assert!(0.03 < soon && soon < late && late < 0.3, "{soon} {late}");
}

#[test]
fn a_cell_of_the_board_without_an_image_says_how_to_get_one() {
    let way = Variant { crash: Some(Crash::HardFault), ..lost() };
    let told = judge(&way, &pose(), SEED, Path::new("nowhere/image")).short;
    let expected = "not run: no board image at nowhere/image; build it with `cargo firmware`";
    assert_eq!(told, [expected]);
}
