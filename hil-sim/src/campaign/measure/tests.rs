use shared::fault::{Fault, Limit, Mode};

use super::*;
use crate::campaign::synthetic::holding;

#[test]
fn drop_is_the_deepest_point_below_the_reference_and_never_negative() {
    let mut trial = holding(10);
    trial.frames[3].tip_m[2] = 1.5;
    trial.frames[6].tip_m[2] = 0.996;
    trial.frames[8].tip_m[2] = 0.999;
    let reference = Track::at_rest([4.0, 0.0, 1.0]);
    assert!((drop_m(&trial, 0, &reference, false) - 4e-3).abs() < 1e-12);
    assert!((drop_m(&trial, 7, &reference, false) - 1e-3).abs() < 1e-12);
    assert_eq!(drop_m(&trial, 9, &reference, false), 0.0);
    // A reference that sinks as well takes nothing from a tip that stays.
    assert_eq!(drop_m(&trial, 9, &Track::at_rest([4.0, 0.0, 0.5]), false), 0.0);
}

#[test]
fn distance_counts_in_every_direction() {
    let mut trial = holding(4);
    trial.frames[2].tip_m = [4.0 + 3e-4, 4e-4, 1.0];
    let reference = Track::at_rest([4.0, 0.0, 1.0]);
    assert!((astray_m(&trial, 0, &reference, false) - 5e-4).abs() < 1e-12);
    assert_eq!(drop_m(&trial, 0, &reference, false), 0.0);
}

#[test]
fn tracks_are_read_at_any_time_and_by_ticks_where_clocks_differ() {
    let mut fast = holding(4);
    for (i, frame) in fast.frames.iter_mut().enumerate() {
        frame.tip_m[2] = 1.0 + i as f64;
        frame.true_s = i as f64 * 0.5 * TICK_S;
    }
    let mut even = holding(4);
    even.frames.iter_mut().enumerate().for_each(|(i, f)| f.tip_m[2] = 1.0 + i as f64);
    let track = Track::of(&even);
    assert_eq!([0.0, 1.5, 99.0].map(|ticks| track.height(ticks * TICK_S)), [1.0, 2.5, 4.0]);
    assert_eq!(astray_m(&fast, 0, &track, true), 0.0);
    assert_eq!(astray_m(&fast, 0, &track, false), 1.5);
}

#[test]
fn reactions_are_told_by_modes_and_pins() {
    let told = |trial: &Trial| reaction(trial, 5);
    assert_eq!(told(&holding(20)), (Reaction::None, None));
    assert_eq!(told(&holding(20).cut(8, Mode::TorqueOff)), (Reaction::Sto, Some(8)));
    let stopped = holding(20).mode(7, Mode::Stopping).cut(15, Mode::Latched);
    assert_eq!(told(&stopped), (Reaction::Ss1, Some(7)));
    let mut isolated = holding(20).mode(7, Mode::Stopping).cut(15, Mode::Latched);
    isolated.frames[7..15].iter_mut().for_each(|f| f.pins.drive_enable[2] = false);
    assert_eq!(told(&isolated), (Reaction::Isolate, Some(7)));
    let mut chain = holding(20);
    chain.frames[9..].iter_mut().for_each(|f| f.chain_closed = false);
    assert_eq!(told(&chain), (Reaction::Hardware, Some(9)));
    assert_eq!(told(&holding(20).mode(11, Mode::Lowering)), (Reaction::Lower, Some(11)));
    // What was over before does not count.
    let early = holding(20).cut(2, Mode::TorqueOff).mode(4, Mode::Holding);
    assert_eq!(reaction(&early, 5).0, Reaction::None);
}

#[test]
fn stop_whose_torque_is_cut_in_motion_is_no_stop_along_the_path() {
    let mut trial = holding(20).mode(7, Mode::Stopping).cut(15, Mode::TorqueOff);
    trial.frames[15].qd[1] = 0.1;
    assert_eq!(reaction(&trial, 5), (Reaction::Sto, Some(15)));
}

#[test]
fn signs_are_looked_for_from_the_fault_on() {
    let mut trial = holding(20);
    for frame in &mut trial.frames[3..6] {
        frame.record.rejected = 0b10;
    }
    trial.frames[9].record.rejected = 0b10;
    trial.frames[10].record.fault = Fault::EncoderLost as u16;
    trial.frames[11].record.limits = 1 << Limit::ClockDrift as u16;
    trial.frames[12..].iter_mut().for_each(|f| f.record.irregular = 1);
    let at = |sought| sign(&trial, 7, sought);
    assert_eq!(at(Sign::Rejected(1)), Some(9));
    assert_eq!(at(Sign::Rejected(0)), None);
    assert_eq!(at(Sign::Fault(&[Fault::DriveLost, Fault::EncoderLost])), Some(10));
    assert_eq!(at(Sign::Limited(Limit::ClockDrift)), Some(11));
    assert_eq!(at(Sign::Irregular), Some(12));
    assert_eq!(at(Sign::Chain), None);
}

#[test]
fn arm_that_moves_after_its_rest_is_found_out() {
    let mut trial = holding(20).cut(8, Mode::Latched);
    assert!(!moved_again(&trial, 5));
    trial.frames[15].qd[0] = 1e-6;
    assert!(moved_again(&trial, 5));
    trial.frames[15].qd[0] = 0.0;
    trial.frames[16].pins.sto = true;
    trial.frames[16].pins.brake_release[2] = true;
    assert!(moved_again(&trial, 5));
}
