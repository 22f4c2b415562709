//! The supervisor driven at random: orders, faults, contacts and brakes in any order and for any time.

use firmware::monitor::Finding;
use firmware::planner::Order;
use firmware::supervisor::{ALL, Brakes, Mode, Reaction, TRANSITIONS};
use proptest::prelude::*;
use shared::fault::{Fault, Mode as ModeCode, Refusal};

use super::{World, jog};

/// What an operator asks for.
#[derive(Clone, Copy, Debug)]
enum Ask {
    Nothing,
    Arm,
    Clear,
    Stop,
    Start,
    StartElsewhere,
    Jog(bool),
    Lower,
    ConfirmPose,
    Impossible,
}

impl Ask {
    fn order(self, world: &World) -> Option<Order> {
        Some(match self {
            Self::Nothing => return None,
            Self::Arm => Order::Arm,
            Self::Clear => Order::Clear,
            Self::Stop => Order::Stop,
            Self::Start => Order::Start(world.motion()),
            Self::StartElsewhere => Order::Start(world.motion().moved_to([1 << 31; 4])),
            Self::Jog(ahead) => jog(if ahead { 1.0 } else { -1.0 }),
            Self::Lower => Order::Lower(world.motion()),
            Self::ConfirmPose => Order::ConfirmPose,
            Self::Impossible => Order::Refused(Refusal::TooFast),
        })
    }
}

/// Some time in which nothing changes but for the order in its first tick.
#[derive(Clone, Debug)]
struct Span {
    ticks: u32,
    ask: Ask,
    fault: Fault,
    brakes: Option<Brakes>,
    stop_released: bool,
    slip: u32,
    blind: u8,
    silence: u32,
}

fn asks() -> impl Strategy<Value = Ask> {
    prop_oneof![
        2 => Just(Ask::Nothing),
        4 => Just(Ask::Arm),
        3 => Just(Ask::Clear),
        1 => Just(Ask::Stop),
        3 => Just(Ask::Start),
        1 => Just(Ask::StartElsewhere),
        3 => any::<bool>().prop_map(Ask::Jog),
        2 => Just(Ask::Lower),
        1 => Just(Ask::ConfirmPose),
        1 => Just(Ask::Impossible),
    ]
}

fn spans() -> impl Strategy<Value = Span> {
    let fault = prop_oneof![9 => Just(Fault::None), 1 => proptest::sample::select(Fault::ALL)];
    let brakes = prop_oneof![
        9 => Just(None),
        1 => (0..=ALL, 0..=ALL).prop_map(|(open, closed)| Some(Brakes { open, closed })),
    ];
    let ticks = prop_oneof![Just(1u32), 2..10u32, 200..1_500u32];
    let slip = prop_oneof![12 => Just(0u32), 1 => any::<u32>()];
    let blind = prop_oneof![9 => Just(0u8), 1 => 0..=ALL];
    let silence = prop_oneof![9 => Just(0u32), 1 => Just(10_000u32)];
    let released = prop_oneof![9 => Just(true), 1 => Just(false)];
    (ticks, asks(), fault, brakes, released, slip, blind, silence).prop_map(
        |(ticks, ask, fault, brakes, stop_released, slip, blind, silence)| Span {
            ticks,
            ask,
            fault,
            brakes,
            stop_released,
            slip,
            blind,
            silence,
        },
    )
}

/// What has to be true of the modes before and after a tick.
fn judge(before: &Mode, world: &World, order: Option<&Order>) -> Result<(), TestCaseError> {
    let (from, to) = (before.code(), world.code());
    let listed = TRANSITIONS.iter().any(|(f, _, t)| (*f, *t) == (from, to));
    prop_assert!(from == to || listed, "{from:?} to {to:?}");
    if from != to && to == ModeCode::Arming {
        prop_assert!(order == Some(&Order::Arm) && world.stop_released);
    }
    if from == ModeCode::Latched && to == ModeCode::Boot {
        prop_assert!(order == Some(&Order::Clear) && world.stop_released);
    }
    let levels = world.mode.levels(&world.timing);
    prop_assert_eq!(levels.release & !levels.drives, 0, "{:?}: a brake opens on no torque", to);
    prop_assert!(levels.sto || levels.drives == 0, "{to:?}");
    prop_assert_eq!(levels.drives & world.mode.isolated(), 0, "{:?}: an isolated joint", to);
    let is_live =
        matches!(from, ModeCode::Arming | ModeCode::Holding | ModeCode::Moving | ModeCode::Jogging);
    match Reaction::to(world.finding.fault) {
        Reaction::Sto if is_live || matches!(from, ModeCode::Stopping | ModeCode::BrakeHold) => {
            prop_assert!(levels.drives == 0 && levels.release == 0, "{from:?} to {to:?}");
        }
        Reaction::Ss1 | Reaction::Isolate if is_live => {
            prop_assert!(matches!(to, ModeCode::Stopping | ModeCode::BrakeHold), "{to:?}");
            prop_assert_eq!(world.mode.cause().map(|c| c.finding), Some(world.finding));
        }
        _ => {}
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn no_other_transition_happens(spans in proptest::collection::vec(spans(), 1..60)) {
        let mut world = World::new();
        world.ready = true;
        let (mut is_stopped, mut is_cut) = (false, false);
        for span in spans {
            world.finding = Finding::of_joint(span.fault, 2);
            world.brakes = span.brakes;
            (world.stop_released, world.slip) = (span.stop_released, span.slip);
            (world.blind, world.silence) = (span.blind, span.silence);
            let mut order = span.ask.order(&world);
            for _ in 0..span.ticks {
                let before = world.mode;
                world.tick(order.as_ref());
                judge(&before, &world, order.as_ref())?;
                order = None;
                let to = world.code();
                is_stopped |= world.mode.cause().is_some();
                is_stopped &= to != ModeCode::Boot;
                is_cut |= to == ModeCode::TorqueOff;
                is_cut &= to != ModeCode::Boot;
                let live = world.mode.levels(&world.timing).sto;
                prop_assert!(!(is_cut && live), "{to:?} after torque was cut");
                let moves = matches!(
                    to,
                    ModeCode::Arming | ModeCode::Holding | ModeCode::Moving | ModeCode::Jogging
                );
                prop_assert!(!(is_stopped && moves), "{to:?} after a stop that nobody cleared");
            }
        }
    }
}
