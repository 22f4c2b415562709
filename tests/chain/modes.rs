//! Modes through the bus and the pins: what keeps the arm from moving, and what stops it.

use hil_sim::path::Path;
use hil_sim::plant::{Disturbance, FRICTION, Plant, RATIOS, Ratios};
use hil_sim::run::config_of;
use hil_sim::scenario::Scenario;
use shared::arm::{JOINTS, Q0, REFERENCE};
use shared::command::{Command, Trajectory};
use shared::fault::{Fault, Mode, Refusal};
use shared::telemetry::Record;
use tests::rig::Rig;

pub fn rig() -> Rig {
    Rig::new(&config_of(&Scenario::load("paper").expect("a shipped scenario")), 10e-6)
}

pub fn lift() -> Trajectory {
    Path::of(&Scenario::load("paper").expect("a shipped scenario")).command(&REFERENCE)
}

/// A rig brought to `mode` by the usual way.
pub fn rig_in(mode: Mode) -> Rig {
    let mut rig = rig();
    let way = [
        (Mode::Standby, None),
        (Mode::Arming, Some(Command::Arm)),
        (Mode::Holding, None),
        (Mode::Moving, Some(Command::Start(lift()))),
    ];
    for (next, command) in way {
        if rig.last.mode == mode as u8 && rig.last.tick > 0 {
            break;
        }
        if command.is_some() {
            rig.tick(command);
        } else {
            rig.until(next, 1.0);
        }
        assert_eq!(rig.last.mode, next as u8);
    }
    rig
}

#[test]
fn the_first_tick_drives_every_output_pin_and_all_are_off() {
    let mut rig = rig();
    assert_eq!(rig.pins.len(), 13);
    assert!(rig.pins.iter().all(|pin| !pin.driven.get()), "no pin is driven before the first tick");
    rig.tick(None);
    let undriven =
        |rig: &Rig| -> Vec<usize> { (0..13).filter(|&i| !rig.pins[i].driven.get()).collect() };
    // The watchdog's feed has its first edge after 2 ms.
    assert_eq!(undriven(&rig), [12]);
    let outputs = rig.bench.borrow().outputs;
    assert!(!rig.is_live() && !outputs.dac_reset && !outputs.adc_reset && outputs.ldac);
    (0..4).for_each(|_| _ = rig.tick(None));
    assert_eq!(undriven(&rig), [0; 0]);
}

#[test]
fn nothing_moves_before_an_arm_command() {
    let mut rig = rig();
    for _ in 0..4_000 {
        rig.tick(None);
        assert!(!rig.is_live(), "tick {}: {:?}", rig.last.tick, rig.bench.borrow().outputs);
    }
    assert_eq!(rig.last.mode, Mode::Standby as u8);
    assert_eq!((rig.plant.qd(), rig.plant.brake_released()), ([0.0; JOINTS], [false; JOINTS]));
}

#[test]
fn boot_waits_for_every_device_and_complains() {
    for missing in 0..JOINTS + 2 {
        let mut rig = rig();
        rig.devices[missing].dead.set(true);
        for _ in 0..1_100 {
            rig.tick(None);
            assert_eq!(rig.last.mode, Mode::Boot as u8, "device {missing}");
            assert!(!rig.is_live(), "device {missing}");
        }
        assert_eq!(rig.last.fault, Fault::BootTimeout as u16, "device {missing}");
        // It starts over, and ends once the device is there.
        rig.devices[missing].dead.set(false);
        rig.until(Mode::Standby, 0.6);
    }
}

/// An encoder may be late; a converter that misses a frame of its configuration waits for boot to start over.
#[test]
fn boot_ends_once_the_last_encoder_reports() {
    for late in 0..JOINTS {
        let mut rig = rig();
        rig.devices[late].dead.set(true);
        (0..400).for_each(|_| _ = rig.tick(None));
        assert_eq!(rig.last.mode, Mode::Boot as u8, "encoder {late}");
        rig.devices[late].dead.set(false);
        rig.until(Mode::Standby, 0.1);
    }
}

/// Whenever a frame is lost in boot, an arm that is armed then is seen.
#[test]
fn a_frame_lost_in_boot_leaves_no_joint_unseen() {
    for lost in 1..40 {
        let mut rig = rig();
        (0..lost).for_each(|_| _ = rig.tick(None));
        rig.devices[1].dead.set(true);
        rig.tick(None);
        rig.devices[1].dead.set(false);
        if rig.last.mode == Mode::Boot as u8 {
            rig.until(Mode::Standby, 1.0);
        }
        rig.tick(Some(Command::Arm));
        rig.until(Mode::Holding, 1.0);
        let encoder = &REFERENCE.encoders[1];
        let seen = f64::from(rig.last.code[1]) * encoder.lsb + encoder.zero;
        let off = seen - rig.plant.q()[1];
        assert!(
            off.abs() < 2e-6,
            "lost in tick {lost}: joint 2 is {off:e} rad from where it seems"
        );
    }
}

/// The watch motion of an arm that holds ends with the order, wherever it is: that is no standing encoder.
#[test]
fn a_trajectory_may_start_at_any_time() {
    for held in (0..220).step_by(3) {
        let mut rig = rig_in(Mode::Holding);
        (0..held).for_each(|_| _ = rig.tick(None));
        let record = rig.tick(Some(Command::Start(lift())));
        assert_eq!(record.refusal, 0, "after {held} ticks");
        for _ in 0..200 {
            let Record { mode, fault, rejected, .. } = rig.tick(None);
            let now = (mode, fault, rejected);
            assert_eq!(now, (Mode::Moving as u8, 0, 0), "started after {held} ticks");
        }
    }
}

#[test]
fn torque_is_on_before_the_brakes_are_told_to_open() {
    let mut rig = rig_in(Mode::Arming);
    let outputs = rig.bench.borrow().outputs;
    assert!(outputs.sto && outputs.drive_enable == [true; JOINTS]);
    assert_eq!(outputs.brake_release, [false; JOINTS]);
    let height_m = rig.plant.tip().position_m[2];
    rig.until(Mode::Holding, 1.0);
    assert_eq!(rig.bench.borrow().outputs.brake_release, [true; JOINTS]);
    (0..1_000).for_each(|_| _ = rig.tick(None));
    let moved_m = rig.plant.tip().position_m[2] - height_m;
    assert!(moved_m.abs() < 2e-5, "the arm moves by {moved_m:e} m when its brakes open");
}

#[test]
fn a_command_in_the_wrong_mode_is_refused_and_changes_no_mode() {
    let start = Command::Start(lift());
    let (wrong, busy) = (Refusal::WrongMode, Refusal::Busy);
    let table: [(Mode, &[(Command, Refusal)]); 6] = [
        (Mode::Boot, &[(Command::Arm, wrong), (start, wrong), (Command::Stop, wrong)]),
        (Mode::Standby, &[(start, wrong)]),
        (Mode::Arming, &[(Command::Arm, wrong), (start, wrong)]),
        (Mode::Holding, &[(Command::Arm, wrong)]),
        (Mode::Moving, &[(Command::Arm, wrong), (start, busy)]),
        (Mode::Latched, &[(Command::Arm, wrong), (start, wrong)]),
    ];
    for (mode, commands) in table {
        for (command, refusal) in commands {
            let mut rig = match mode {
                Mode::Boot => rig(),
                Mode::Latched => rig_in(Mode::Standby),
                _ => rig_in(mode),
            };
            if mode == Mode::Latched {
                rig.tick(Some(Command::Stop));
            }
            let live = rig.is_live();
            let record = rig.tick(Some(*command));
            let got = (record.mode, record.refusal);
            assert_eq!(got, (mode as u8, *refusal as u8), "{command:?} in {mode:?}");
            assert_eq!(rig.is_live(), live, "{command:?} in {mode:?}");
        }
    }
}

#[test]
fn a_refused_trajectory_is_named_in_the_record() {
    let mut rig = rig_in(Mode::Holding);
    let too_fast = Trajectory { duration_ticks: 1_000, ..lift() };
    let record = rig.tick(Some(Command::Start(too_fast)));
    assert_eq!((record.mode, record.refusal), (Mode::Holding as u8, Refusal::TooFast as u8));
    let record = rig.tick(Some(Command::Start(lift())));
    assert_eq!((record.mode, record.refusal), (Mode::Moving as u8, Refusal::None as u8));
}

#[test]
fn a_second_trajectory_does_not_disturb_the_first() {
    let [mut alone, mut asked] = [rig_in(Mode::Moving), rig_in(Mode::Moving)];
    for k in 1..1_000 {
        let second = (k % 100 == 0).then(|| Command::Start(lift()));
        let (one, other) = (alone.tick(None), asked.tick(second));
        assert_eq!((one.phase, one.dac, one.d_hat), (other.phase, other.dac, other.d_hat));
        assert_eq!(other.phase, k);
    }
    assert_eq!(asked.last.refusal, Refusal::Busy as u8);
}

/// Nobody vouches for a pose that nobody has seen: confirming counts only once boot says that the pose differs.
#[test]
fn a_pose_is_confirmed_only_after_it_was_found_to_differ() {
    let mut rig = rig();
    let q = std::array::from_fn(|j| Q0[j] - if j == 1 { 0.2 } else { 0.0 });
    rig.plant = Plant::at_rest(&REFERENCE, q, Disturbance::new(FRICTION, Ratios::Fixed(RATIOS)), 1);
    let confirm = |rig: &mut Rig| rig.tick(Some(Command::ConfirmPose)).refusal;
    for _ in 0..20 {
        assert_eq!(confirm(&mut rig), Refusal::WrongMode as u8);
    }
    (0..1_500).for_each(|_| _ = rig.tick(None));
    let standing = (rig.last.mode, rig.last.fault);
    assert_eq!(standing, (Mode::Boot as u8, Fault::ParkedPoseDiffers as u16));
    assert_eq!(confirm(&mut rig), 0);
    rig.until(Mode::Standby, 0.6);
}
