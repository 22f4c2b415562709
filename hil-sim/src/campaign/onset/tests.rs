use shared::arm::REFERENCE;

use super::*;
use crate::campaign::synthetic::holding;
use crate::campaign::trial::Trial;

const J: usize = 1;

/// A joint that moves `counts` a tick, with what its encoder shows.
fn moving(counts: f64, shown: impl Fn(usize, u32) -> Option<u32>) -> Trial {
    let mut trial = holding(40);
    let encoder = &REFERENCE.encoders[J];
    for i in 0..40 {
        trial.frames[i].q[J] = counts * i as f64 * encoder.lsb;
        trial.frames[i].qd[J] = 0.0;
        let code = true_code(&trial, i, J).round() as u32;
        trial.seen[i].codes[J] = shown(i, code);
    }
    trial
}

#[test]
fn bucket_fills_at_the_third_loss_in_a_row_and_not_at_every_third() {
    let lost = |lost: fn(usize) -> bool| {
        let trial = moving(0.0, |i, code| (!lost(i)).then_some(code));
        Condition::BucketFull(J).index(&trial, 5)
    };
    assert_eq!(lost(|i| i >= 10), Some(12));
    assert_eq!(lost(|i| (10..12).contains(&i)), None);
    assert_eq!(lost(|i| i % 3 == 0), None);
    assert_eq!(lost(|i| i % 2 == 0), Some(14));
}

#[test]
fn code_that_stands_still_counts_once_the_joint_has_moved_by_more_than_eight() {
    let stuck = |counts| {
        moving(counts, |i, code| Some(if i < 10 { code } else { moving_code(counts, 10) }))
    };
    let at = |counts| Condition::Still(J, 0).index(&stuck(counts), 10);
    assert_eq!(at(100.0), Some(11));
    assert_eq!(at(3.0), Some(13));
    assert_eq!(at(0.0), None);
    assert_eq!(Condition::Still(J, 2).index(&stuck(100.0), 10), Some(13));
    assert_eq!(Condition::Still(J, 0).index(&moving(100.0, |_, code| Some(code)), 10), None);
}

fn moving_code(counts: f64, i: usize) -> u32 {
    moving(counts, |_, code| Some(code)).seen[i].codes[J].expect("a code")
}

#[test]
fn three_wrong_codes_in_ten_ticks_are_doubtful() {
    let wrong = |ticks: &'static [usize]| {
        let trial = moving(50.0, |i, code| Some(code + if ticks.contains(&i) { 100 } else { 0 }));
        Condition::Doubtful(J).index(&trial, 5)
    };
    assert_eq!(wrong(&[10, 14, 19]), Some(19));
    assert_eq!(wrong(&[10, 14, 20]), None);
    assert_eq!(wrong(&[10, 14, 20, 21]), Some(21));
}

#[test]
fn late_ticks_are_counted_by_true_time() {
    let mut trial = holding(20);
    trial.frames.iter_mut().skip(8).for_each(|f| f.true_s += 0.2 * TICK_S);
    trial.frames.iter_mut().skip(12).for_each(|f| f.true_s += 4.0 * TICK_S);
    assert_eq!([1, 2, 3].map(|n| Condition::Late(n).index(&trial, 5)), [Some(8), Some(12), None]);
    assert_eq!(trial.ticks(8, 11), 4);
    assert_eq!(trial.ticks(11, 12), 6);
}

#[test]
fn torque_is_wrong_beyond_its_threshold_one_step_after_it_acted() {
    let share = 10_000.0 / 32_768.0;
    let told_nm = share * REFERENCE.drive_full_scale[J];
    let threshold_nm = f64::from(Safety::REFERENCE.torque_wrong[J]);
    let at = |given_nm: f64| {
        let mut trial = holding(20);
        for (i, frame) in trial.frames.iter_mut().enumerate() {
            frame.record.dac[J] = 0x8000 + 10_000;
            frame.torque[J] = if i < 10 { told_nm } else { given_nm };
        }
        Condition::TorqueWrong(J).index(&trial, 5)
    };
    assert_eq!(at(0.0), Some(11));
    assert_eq!(at(told_nm - 1.01 * threshold_nm), Some(11));
    assert_eq!(at(told_nm - 0.99 * threshold_nm), None);
}

#[test]
fn torque_is_at_its_limit_at_the_last_code_below_it() {
    // 120 000 N m of 122 880 are 32 000 of 32 768 codes.
    let at = |codes: [u16; 2]| {
        let mut trial = holding(20);
        trial.frames.iter_mut().for_each(|frame| frame.record.dac = [0x8000; JOINTS]);
        trial.frames[9].record.dac[J] = codes[0];
        trial.frames[12].record.dac[J] = codes[1];
        Condition::TorqueAtLimit.index(&trial, 5)
    };
    assert_eq!(at([0x8000 + 31_999, 0x8000 + 32_000]), Some(12));
    assert_eq!(at([0x8000 - 32_000, 0x8000]), Some(9));
    assert_eq!(at([0x8000 - 31_999, 0x8000]), None);
}

#[test]
fn joint_is_astray_beyond_what_the_monitor_lets_last() {
    let encoder = &REFERENCE.encoders[J];
    let allowed = f64::from(Safety::REFERENCE.tracking[J]);
    let at = |share: f64| {
        let mut trial = holding(20);
        for (i, frame) in trial.frames.iter_mut().enumerate() {
            frame.q = std::array::from_fn(|j| REFERENCE.encoders[j].zero);
            // The set-point goes on from tick 10 on, and the joint stays.
            let error = if i < 10 { 0.0 } else { share * allowed };
            frame.record.code[J] = 1_000;
            frame.q[J] = 1_000.0 * encoder.lsb + encoder.zero;
            frame.record.e1[J] = error as f32;
        }
        Condition::Astray.index(&trial, 5)
    };
    assert_eq!([at(1.01), at(-1.01), at(0.99)], [Some(10), Some(10), None]);
}

#[test]
fn ticks_that_never_came_are_passed_over() {
    let mut trial = holding(20);
    trial.frames[7].ticked = false;
    let at = |condition: Condition| condition.index(&trial, 7);
    assert_eq!(at(Condition::Begun), Some(8));
    assert_eq!(at(Condition::BegunAnyhow), Some(7));
    assert_eq!(at(Condition::After(2)), Some(9));
    assert_eq!(at(Condition::Later(3.0 * TICK_S)), Some(10));
    assert_eq!(at(Condition::Never), None);
}
