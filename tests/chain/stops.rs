//! Stops through the bus and the pins: torque holds the arm while the brakes set, and every stop latches.

use shared::arm::JOINTS;
use shared::command::Command;
use shared::fault::{Fault, Mode, Refusal};
use shared::telemetry::PATH_RATE_ONE;
use tests::rig::Rig;

use crate::modes::rig_in;

const ARMED: [Mode; 3] = [Mode::Arming, Mode::Holding, Mode::Moving];

fn press(rig: &mut Rig, contacts: &[usize]) {
    for &contact in contacts {
        rig.bench.borrow_mut().emergency_stop[contact] = false;
    }
}

fn release(rig: &mut Rig) {
    rig.bench.borrow_mut().emergency_stop = [true; 2];
}

/// Goes on for `ticks` without a command.
fn wait(rig: &mut Rig, ticks: u32) {
    (0..ticks).for_each(|_| _ = rig.tick(None));
}

fn standing(rig: &Rig) -> (u8, u16) {
    (rig.last.mode, rig.last.fault)
}

/// The mode that a stop of the first kind enters from `mode`.
fn first_of_a_stop(mode: Mode) -> Mode {
    match mode {
        Mode::Standby => Mode::Latched,
        Mode::Moving => Mode::Stopping,
        _ => Mode::BrakeHold,
    }
}

/// The path rate reaches zero within 150 ms, the brakes set under torque, and torque goes off 50 ms after the
/// last of them has closed.
#[test]
fn a_stop_holds_the_arm_until_the_brakes_have_set() {
    for mode in ARMED {
        let mut rig = rig_in(mode);
        wait(&mut rig, 500);
        let record = rig.tick(Some(Command::Stop));
        assert_eq!((record.mode, record.refusal), (first_of_a_stop(mode) as u8, 0), "{mode:?}");
        let (mut slowing, mut closed) = (0, 0);
        while rig.last.mode != Mode::Latched as u8 {
            let outputs = rig.bench.borrow().outputs;
            assert!(outputs.sto && outputs.drive_enable == [true; JOINTS], "{mode:?}");
            slowing += u32::from(rig.last.mode == Mode::Stopping as u8);
            if rig.last.mode == Mode::BrakeHold as u8 {
                assert_eq!(outputs.brake_release, [false; JOINTS], "{mode:?}");
            }
            closed += u32::from(rig.plant.brake_released() == [false; JOINTS]);
            rig.tick(None);
            assert!(slowing <= 302 && closed < 300, "{mode:?}: {slowing}, {closed} ticks");
        }
        assert!(closed >= 100, "{mode:?}: torque went off {closed} ticks after the brakes had set");
        wait(&mut rig, 200);
        assert_eq!(standing(&rig), (Mode::Latched as u8, Fault::OperatorStop as u16), "{mode:?}");
        assert!(!rig.is_live());
        assert_eq!((rig.plant.brake_released(), rig.plant.qd()), ([false; JOINTS], [0.0; JOINTS]));
    }
}

/// The rate only falls, and without a step: a cubic over 300 ticks is steepest at 1.5 / 300.
#[test]
fn the_path_rate_falls_to_zero_without_a_step() {
    let mut rig = rig_in(Mode::Moving);
    wait(&mut rig, 5_000);
    let mut before = i32::from(PATH_RATE_ONE);
    rig.tick(Some(Command::Stop));
    while rig.last.mode == Mode::Stopping as u8 {
        let rate = i32::from(rig.last.path_rate);
        let fall = before - rate;
        assert!((0..=165).contains(&fall), "{before} to {rate}");
        before = rate;
        rig.tick(None);
    }
    assert!(before < 10, "the arm was at rest at a path rate of {before}");
}

#[test]
fn an_emergency_stop_latches_and_needs_release_clear_and_arm() {
    for mode in [Mode::Standby, Mode::Arming, Mode::Holding, Mode::Moving] {
        let mut rig = rig_in(mode);
        rig.tick(None);
        press(&mut rig, &[0, 1]);
        rig.tick(None);
        let stopped = (first_of_a_stop(mode) as u8, Fault::EmergencyStop as u16);
        assert_eq!(standing(&rig), stopped, "{mode:?}");
        wait(&mut rig, 1_000);
        let latched = (Mode::Latched as u8, Fault::EmergencyStop as u16);
        assert_eq!(standing(&rig), latched, "{mode:?}");
        let refusal = |rig: &mut Rig, command| rig.tick(Some(command)).refusal;
        assert_eq!(refusal(&mut rig, Command::Clear), Refusal::EmergencyStop as u8, "{mode:?}");
        release(&mut rig);
        assert_eq!(refusal(&mut rig, Command::Arm), Refusal::WrongMode as u8, "{mode:?}");
        wait(&mut rig, 1_000);
        assert_eq!(standing(&rig), latched, "{mode:?}: released alone");
        assert!(!rig.is_live());
        assert_eq!(refusal(&mut rig, Command::Clear), 0);
        rig.until(Mode::Standby, 0.5);
        wait(&mut rig, 1_000);
        assert_eq!(standing(&rig), (Mode::Standby as u8, 0), "{mode:?}: cleared alone");
        assert!(!rig.is_live());
        rig.tick(Some(Command::Arm));
        rig.until(Mode::Holding, 1.0);
    }
}

/// One contact is a stop, and after 50 ms a broken switch: it has to show that both contacts work.
#[test]
fn a_contact_that_opens_alone_stops_and_is_not_trusted_again() {
    for contact in 0..2 {
        let mut rig = rig_in(Mode::Moving);
        wait(&mut rig, 100);
        press(&mut rig, &[contact]);
        rig.tick(None);
        assert_eq!(standing(&rig), (Mode::Stopping as u8, Fault::EmergencyStop as u16));
        wait(&mut rig, 1_500);
        let latched = (Mode::Latched as u8, Fault::EmergencyStopContacts as u16);
        assert_eq!(standing(&rig), latched, "contact {contact}");
        release(&mut rig);
        wait(&mut rig, 10);
        let refusal = rig.tick(Some(Command::Clear)).refusal;
        assert_eq!(refusal, Refusal::EmergencyStop as u8, "contact {contact}");
        press(&mut rig, &[0, 1]);
        wait(&mut rig, 10);
        release(&mut rig);
        assert_eq!(rig.tick(Some(Command::Clear)).refusal, 0, "contact {contact}");
        rig.until(Mode::Standby, 0.5);
    }
}

/// A drive that is not written to is not trusted: torque and brakes in the same tick.
#[test]
fn a_converter_that_is_lost_cuts_torque_at_once() {
    let mut rig = rig_in(Mode::Moving);
    wait(&mut rig, 500);
    rig.devices[JOINTS + 1].dead.set(true);
    let lost = (0..5).find(|_| rig.tick(None).mode == Mode::TorqueOff as u8);
    assert!(lost.is_some(), "{:?}", standing(&rig));
    assert_eq!(rig.last.fault, Fault::DacNotAcknowledged as u16);
    assert!(!rig.is_live());
    rig.until(Mode::Latched, 0.3);
}
