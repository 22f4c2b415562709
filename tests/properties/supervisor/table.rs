//! Each transition of the table by the exit that it names.

use firmware::monitor::Finding;
use firmware::planner::Order;
use firmware::supervisor::{Exit, Mode, TRANSITIONS};
use shared::fault::{Fault, Mode as ModeCode, Refusal};
use shared::telemetry::PATH_RATE_ONE;

use super::{World, jog};

/// Exits that lead from reset to `mode`.
fn way_to(mode: ModeCode) -> Vec<Exit> {
    let after = |before: ModeCode, exit: Exit| {
        let mut way = way_to(before);
        way.push(exit);
        way
    };
    match mode {
        ModeCode::Boot => vec![],
        ModeCode::Standby => after(ModeCode::Boot, Exit::Ready),
        ModeCode::Arming => after(ModeCode::Standby, Exit::Arm),
        ModeCode::Holding => after(ModeCode::Arming, Exit::Free),
        ModeCode::Moving => after(ModeCode::Holding, Exit::Start),
        ModeCode::Jogging => after(ModeCode::Holding, Exit::Jog),
        ModeCode::Stopping => after(ModeCode::Moving, Exit::Stop),
        ModeCode::BrakeHold => after(ModeCode::Holding, Exit::Stop),
        ModeCode::TorqueOff => after(ModeCode::Holding, Exit::CutTorque),
        ModeCode::Latched => after(ModeCode::Standby, Exit::Stop),
        ModeCode::Lowering => after(ModeCode::Standby, Exit::Slipped),
    }
}

pub fn in_mode(mode: ModeCode) -> World {
    let mut world = World::new();
    for exit in way_to(mode) {
        leave_by(&mut world, exit);
    }
    assert_eq!(world.code(), mode);
    world
}

/// Brings about what `exit` stands for, and waits for the mode to change.
fn leave_by(world: &mut World, exit: Exit) {
    let from = world.code();
    if (from, exit) == (ModeCode::Lowering, Exit::Stop) {
        set_out(world);
    }
    let order = match exit {
        Exit::Arm => Some(Order::Arm),
        Exit::Start => Some(Order::Start(world.motion())),
        Exit::Jog => Some(jog(1.0)),
        Exit::Stop => Some(Order::Stop),
        Exit::AtRest if from == ModeCode::Lowering => Some(Order::Stop),
        Exit::Clear => Some(Order::Clear),
        _ => None,
    };
    world.ready = exit == Exit::Ready;
    world.slip = if exit == Exit::Slipped { 1_000 } else { 0 };
    world.finding = match exit {
        Exit::CutTorque => Finding::of_joint(Fault::Overspeed, 1),
        Exit::Astray => Finding::of_joint(Fault::ErrorWindow, 1),
        _ => Finding::NONE,
    };
    assert_eq!(world.tick(order.as_ref()), Refusal::None, "{from:?} by {exit:?}");
    world.finding = Finding::NONE;
    for _ in 0..2_000 {
        if world.code() != from || (from, exit) == (ModeCode::BrakeHold, Exit::Astray) {
            return;
        }
        // The planner's answer to a slipped brake.
        let way = (exit == Exit::Lowered).then(|| Order::Lower(world.motion()));
        world.tick(way.as_ref());
    }
    panic!("{from:?} is not left by {exit:?}");
}

/// Waits for the brakes that a lowering opens, and gives it its way.
pub fn set_out(world: &mut World) {
    let on_its_way = |world: &World| matches!(world.mode, Mode::Lowering { motion: Some(_), .. });
    for _ in 0..100 {
        let way = Order::Lower(world.motion());
        world.tick(Some(&way));
        if on_its_way(world) {
            return;
        }
    }
    panic!("{:?} does not take its way", world.code());
}

#[test]
fn every_transition_happens_by_its_exit() {
    for (from, exit, to) in TRANSITIONS {
        let mut world = in_mode(*from);
        leave_by(&mut world, *exit);
        assert_eq!(world.code(), *to, "{from:?} by {exit:?}");
    }
}

#[test]
fn no_exit_leads_to_two_modes() {
    for (n, (from, exit, _)) in TRANSITIONS.iter().enumerate() {
        let again = TRANSITIONS[n + 1..].iter().any(|(f, e, _)| (f, e) == (from, exit));
        assert!(!again, "{from:?} by {exit:?} stands twice");
    }
}

/// What stops the arm, in every mode that a stop goes through.
const STOPPED: [ModeCode; 5] = [
    ModeCode::Stopping,
    ModeCode::BrakeHold,
    ModeCode::TorqueOff,
    ModeCode::Latched,
    ModeCode::Lowering,
];

#[test]
fn every_stop_ends_latched_and_stays() {
    for mode in STOPPED {
        let mut world = in_mode(mode);
        for tick in 0..4_000 {
            let order = match (mode, tick % 7) {
                (ModeCode::Lowering, 0) => Some(Order::Lower(world.motion())),
                (_, 1) => Some(Order::Arm),
                (_, 2) => Some(Order::Start(world.motion())),
                (_, 3) => Some(jog(1.0)),
                _ => None,
            };
            world.tick(order.as_ref());
            assert!(STOPPED.contains(&world.code()), "{mode:?} led to {:?}", world.code());
        }
        assert_eq!(world.code(), ModeCode::Latched, "{mode:?}");
    }
}

#[test]
fn only_standby_takes_an_arm_order() {
    for mode in ModeCode::ALL {
        let mut world = in_mode(*mode);
        let refusal = world.tick(Some(&Order::Arm));
        let expected = if *mode == ModeCode::Standby { Refusal::None } else { Refusal::WrongMode };
        assert_eq!(refusal, expected, "{mode:?}");
        let armed = world.code() == ModeCode::Arming;
        assert_eq!(armed, matches!(mode, ModeCode::Standby | ModeCode::Arming), "{mode:?}");
    }
}

#[test]
fn an_open_emergency_stop_refuses_arm_and_clear() {
    for (mode, order) in [(ModeCode::Standby, Order::Arm), (ModeCode::Latched, Order::Clear)] {
        let mut world = in_mode(mode);
        world.stop_released = false;
        assert_eq!(world.tick(Some(&order)), Refusal::EmergencyStop);
        assert_eq!(world.code(), mode);
    }
}

/// Pressing the button again, or a frame that comes twice, costs the stop no time.
#[test]
fn a_stop_that_is_repeated_takes_no_longer() {
    let ticks_to_latch = |is_repeated: bool| {
        let mut world = in_mode(ModeCode::Moving);
        world.tick(Some(&Order::Stop));
        let again = is_repeated.then_some(Order::Stop);
        (0..2_000).find(|_| {
            world.tick(again.as_ref());
            world.code() == ModeCode::Latched
        })
    };
    let once = ticks_to_latch(false);
    assert!(once.is_some());
    assert_eq!(ticks_to_latch(true), once);
}

/// A jog that comes to its end by itself and is stopped on the way there: it neither turns back nor starts anew.
#[test]
fn a_stop_at_the_end_of_a_jog_never_turns_back() {
    for stopped_after in (0..300).step_by(7) {
        let mut world = in_mode(ModeCode::Jogging);
        let rate = |world: &World| world.mode.status(&world.timing).path_rate;
        let falls = |world: &mut World| {
            let before = rate(world);
            world.tick(None);
            rate(world) < before
        };
        assert!((0..2_000).any(|_| falls(&mut world)), "the jog does not end");
        (0..stopped_after).for_each(|_| _ = world.tick(None));
        let mut before = world.mode.set_point(&world.timing).expect("a set-point");
        world.tick(Some(&Order::Stop));
        while world.code() == ModeCode::Stopping {
            assert!(rate(&world) <= PATH_RATE_ONE);
            let now = world.mode.set_point(&world.timing).expect("a set-point");
            for j in 0..now.position.len() {
                let moved = now.position[j].wrapping_sub(before.position[j]) as i32;
                assert!(moved >= -1 && now.velocity[j] >= 0.0, "{stopped_after}: {moved}");
            }
            before = now;
            world.tick(None);
        }
    }
}

/// What the arm did while the emergency stop was pressed is no slip that lowers it when the button is let go.
#[test]
fn letting_go_of_the_emergency_stop_moves_nothing() {
    for mode in [ModeCode::Standby, ModeCode::Latched] {
        let mut world = in_mode(mode);
        world.stop_released = false;
        world.slip = 1_000;
        (0..100).for_each(|_| _ = world.tick(None));
        world.stop_released = true;
        (0..100).for_each(|_| _ = world.tick(None));
        assert_eq!(world.code(), mode);
        world.slip = 2_000;
        world.tick(None);
        assert_eq!(world.code(), ModeCode::Lowering, "a slip after that");
    }
}
