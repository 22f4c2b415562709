//! Damaged numbers through the bus and the pins: none of them moves the arm, and what is lost stays lost.

use std::ops::Range;

use firmware::memory::Memory;
use shared::command::Command;
use shared::fault::{Fault, Mode, Refusal};
use tests::rig::Rig;

use crate::modes::{rig, rig_in};

/// Overwrites the first word of `stretch` in each copy of the coefficients.
fn poke(rig: &mut Rig, stretch: Range<usize>, [live, shadow]: [u32; 2]) {
    let words = rig.memory().as_words_mut();
    words[stretch.start / 4] = live;
    // The shadow follows what it is a copy of.
    words[(stretch.start + Memory::SHADOW.len()) / 4] = shadow;
}

/// Damages both copies of the thresholds.
fn lose_thresholds(rig: &mut Rig) {
    let words = rig.memory().as_words_mut();
    let place = Memory::THRESHOLDS.start / 4;
    words[place] ^= 1;
    words[place + Memory::THRESHOLDS.len() / 4] ^= 2;
}

fn lose_coefficients(rig: &mut Rig) {
    poke(rig, Memory::ARM, [1, 2]);
}

fn wait(rig: &mut Rig, ticks: u32) {
    (0..ticks).for_each(|_| _ = rig.tick(None));
}

fn standing(rig: &Rig) -> (u8, u16) {
    (rig.last.mode, rig.last.fault)
}

const LOST: (u8, u16) = (Mode::Latched as u8, Fault::ParametersLost as u16);

/// Torques that are no numbers never reach a drive: those of the tick before stay until the brakes have set.
#[test]
fn a_law_that_gives_no_number_moves_nothing() {
    for mode in [Mode::Arming, Mode::Holding, Mode::Moving] {
        let mut rig = rig_in(mode);
        wait(&mut rig, 500);
        let before = rig.last.dac;
        poke(&mut rig, Memory::ARM, [f32::NAN.to_bits(); 2]);
        rig.tick(None);
        assert_eq!(rig.last.fault, Fault::ErrorWindow as u16, "{mode:?}");
        while rig.last.mode != Mode::Latched as u8 {
            assert_eq!(rig.last.dac, before, "{mode:?} in {:?}", Mode::from_number(rig.last.mode));
            rig.tick(None);
            assert!(rig.last.tick < 6_000, "{mode:?} does not end");
        }
        assert!(!rig.is_live());
    }
}

#[test]
fn lost_parameters_end_latched_and_locked_out_in_every_mode() {
    for lose in [lose_coefficients as fn(&mut Rig), lose_thresholds] {
        for mode in [Mode::Standby, Mode::Arming, Mode::Holding, Mode::Moving] {
            let mut rig = rig_in(mode);
            lose(&mut rig);
            wait(&mut rig, 1_000);
            assert_eq!(standing(&rig), LOST, "{mode:?}");
            for command in [Command::Clear, Command::Arm] {
                assert_ne!(rig.tick(Some(command)).refusal, 0, "{mode:?}: {command:?}");
                wait(&mut rig, 1_000);
                assert_eq!(standing(&rig), LOST, "{mode:?}: {command:?}");
                assert!(!rig.is_live());
            }
            assert_eq!(rig.tick(Some(Command::Clear)).refusal, Refusal::LockedOut as u8);
            assert_eq!(rig.tick(Some(Command::Stop)).refusal, 0, "{mode:?}");
        }
    }
}

/// What was lost before there was torque keeps it from ever coming.
#[test]
fn lost_parameters_keep_boot_from_ending_and_a_stop_from_being_cleared() {
    for lose in [lose_coefficients as fn(&mut Rig), lose_thresholds] {
        let mut rig = rig();
        rig.tick(None);
        lose(&mut rig);
        for tick in 0..4_000 {
            // Boot may end before a round of the check does.
            let command = (tick == 1_000).then_some(Command::Arm);
            rig.tick(command);
            assert!(!rig.is_live(), "{tick}: {:?}", rig.last);
        }
        assert_eq!(rig.last.fault, Fault::ParametersLost as u16);
        let mut rig = rig_in(Mode::Moving);
        rig.tick(Some(Command::Stop));
        rig.until(Mode::Latched, 1.0);
        assert_eq!(rig.last.fault, Fault::OperatorStop as u16);
        lose(&mut rig);
        wait(&mut rig, 500);
        assert_eq!(standing(&rig), LOST);
        assert_eq!(rig.tick(Some(Command::Clear)).refusal, Refusal::LockedOut as u8);
    }
}

/// Orders in a tick that has no parameters are answered with a refusal; a stop is obeyed.
#[test]
fn a_tick_without_parameters_takes_no_order_but_a_stop() {
    for (command, refusal) in [(Command::Arm, Refusal::Busy), (Command::Stop, Refusal::None)] {
        let mut rig = rig_in(Mode::Standby);
        poke(&mut rig, Memory::LIMITS, [1; 2]);
        poke(&mut rig, Memory::LIMITS, [1, 2]);
        rig.tick(Some(command));
        assert_eq!(rig.last.refusal, refusal as u8, "{command:?}");
    }
}
