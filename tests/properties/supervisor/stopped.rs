//! What a stop may still do: brakes that come too late, an arm that does not follow, torque that does not come back.

use firmware::monitor::Finding;
use firmware::planner::Order;
use firmware::supervisor::{ALL, Brakes, Mode};
use shared::fault::{Fault, Mode as ModeCode};

use super::World;
use super::table::{in_mode, set_out};

fn wait(world: &mut World, ticks: u32) {
    (0..ticks).for_each(|_| _ = world.tick(None));
}

/// One tick in which a monitor finds this.
fn find(world: &mut World, finding: Finding) {
    world.finding = finding;
    world.tick(None);
    world.finding = Finding::NONE;
}

/// Goes on until latched.
fn latch(world: &mut World) {
    wait(world, 2_000);
    assert_eq!(world.code(), ModeCode::Latched);
}

fn fault(world: &World) -> Option<Fault> {
    world.mode.cause().map(|cause| cause.finding.fault)
}

/// A contact that falls back, however long after it had opened, does not keep arming from ending.
#[test]
fn arming_ends_whenever_a_brake_contact_falls_back() {
    let deadline = |world: &World| world.timing.preload + world.timing.brake_open;
    let limit = {
        let timing = in_mode(ModeCode::Arming).timing;
        timing.preload + timing.calm + timing.test.ticks
    };
    for tick in (1..limit - 1).step_by(13) {
        let mut world = in_mode(ModeCode::Arming);
        wait(&mut world, tick);
        world.brakes = Some(Brakes { open: ALL & !0b0010, closed: 0 });
        let left = deadline(&world).saturating_sub(tick) + 2;
        wait(&mut world, left);
        assert_eq!(world.code(), ModeCode::BrakeHold, "fell back at {tick}");
        let finding = Finding::of_joint(Fault::BrakeNotReleased, 1);
        assert_eq!(world.mode.cause().map(|cause| cause.finding), Some(finding));
    }
}

#[test]
fn torque_that_was_cut_does_not_come_back_by_itself() {
    let finding = Finding::of_joint(Fault::TorqueWrong, 2);
    let stop = Finding::new(Fault::EmergencyStop);
    for (mode, finding) in [
        (ModeCode::Standby, finding),
        (ModeCode::Moving, finding),
        (ModeCode::BrakeHold, finding),
        (ModeCode::Lowering, finding),
        (ModeCode::Lowering, stop),
    ] {
        let mut world = in_mode(mode);
        find(&mut world, finding);
        latch(&mut world);
        world.slip += 1_000;
        wait(&mut world, 100);
        assert_eq!(world.code(), ModeCode::Latched, "{mode:?} by {finding:?}");
    }
}

#[test]
fn lowering_leaves_a_joint_whose_drive_is_lost_braked() {
    let lost = Finding::of_joint(Fault::DriveLost, 1);
    let mut world = in_mode(ModeCode::Moving);
    find(&mut world, lost);
    latch(&mut world);
    world.slip += 1_000;
    world.tick(None);
    assert_eq!(world.code(), ModeCode::Lowering);
    set_out(&mut world);
    let levels = world.mode.levels(&world.timing);
    assert_eq!((levels.drives, levels.release), (0b1101, 0b1101));
    // Another one is lost on the way.
    find(&mut world, Finding::of_joint(Fault::DriveLost, 2));
    let levels = world.mode.levels(&world.timing);
    assert_eq!((world.code(), levels.drives), (ModeCode::Stopping, 0b1001));
    latch(&mut world);
    assert_eq!(fault(&world), Some(Fault::BrakeSlipped));
}

/// As long as the brakes are set there is nothing to slow down, and they stay set.
#[test]
fn a_stop_while_lowering_goes_on_along_the_way() {
    let mut world = in_mode(ModeCode::Lowering);
    world.tick(Some(&Order::Stop));
    assert_eq!((world.code(), world.mode.levels(&world.timing).release), (ModeCode::BrakeHold, 0));

    let mut world = in_mode(ModeCode::Lowering);
    set_out(&mut world);
    wait(&mut world, 100);
    let before = world.mode.set_point(&world.timing).expect("a set-point");
    world.tick(Some(&Order::Stop));
    assert_eq!(world.code(), ModeCode::Stopping);
    let after = world.mode.set_point(&world.timing).expect("a set-point");
    for (before, after) in before.velocity.iter().zip(after.velocity) {
        assert!((after - before).abs() <= 0.05 * before.abs(), "{before} to {after}");
    }
    latch(&mut world);
}

/// Whatever the arm does, a stop does not go on for longer than its ramp, and holds it where it is.
#[test]
fn a_stop_that_is_not_followed_sets_the_brakes() {
    let astray = Finding::of_joint(Fault::ErrorWindow, 3);
    let mut world = in_mode(ModeCode::Stopping);
    find(&mut world, astray);
    assert_eq!(world.code(), ModeCode::BrakeHold);
    wait(&mut world, 20);
    world.brakes = Some(Brakes { open: ALL, closed: 0 });
    let Mode::BrakeHold { ticks: before, .. } = world.mode else { unreachable!() };
    world.observers[3].position += 1_000;
    let measured = world.observers.map(|o| o.position);
    world.drifts = true;
    find(&mut world, astray);
    let Mode::BrakeHold { pose, ticks, .. } = world.mode else { panic!("{:?}", world.code()) };
    assert_eq!((pose, ticks), (measured, before));
    assert_eq!(fault(&world), Some(Fault::OperatorStop), "the stop's own reason stays");
}
