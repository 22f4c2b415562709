//! A board that breaks down in the middle of a lift: its own handler switches everything off, the cause outlives the
//! reset, and nothing moves again until an operator has cleared it and vouched for the pose.

use hil_sim::bench::OutputLevels;
use hil_sim::pil::{self, Breakable, Crash, Crashed};
use hil_sim::run::kept_of;
use hil_sim::scenario::Scenario;
use hil_sim::session::Session;
use shared::command::Command;
use shared::evidence::Entry;
use shared::fault::{Fault, Mode, Refusal};
use shared::telemetry::Record;
use tests::board;
use tests::stack;

const CRASHES: [(Crash, Fault); 2] =
    [(Crash::HardFault, Fault::HardFault), (Crash::StackOverflow, Fault::StackOverflow)];

fn paper() -> Scenario {
    Scenario::load("paper").expect("a shipped scenario")
}

fn is_off(pins: &OutputLevels) -> bool {
    !pins.sto && pins.drive_enable == [false; 4] && pins.brake_release == [false; 4]
}

/// What board and simulator show in the second after the crash.
#[test]
fn a_crash_switches_off_at_once_and_is_latched_over_the_reset() {
    let image = board::open("mps2-an386");
    for (crash, fault) in CRASHES {
        let run = pil::crash(&paper(), &image.path, crash, 1.0, 1.0).expect("a run");
        let Crashed { tape, at, fall, evidence } = run;
        let (before, after) = (&tape.frames[at - 1], &tape.frames[at..]);
        assert!(before.pins.sto && before.torque[1] != 0.0);
        assert_eq!((before.record.mode, before.record.powered), (Mode::Moving as u8, 0xFF));
        // In the handler, in the very tick; no pin or torque comes back.
        assert!(is_off(&fall.pins), "{crash:?}: {:?}", fall.pins);
        assert!(after.len() > 2_000 && after.iter().all(|frame| is_off(&frame.pins)));
        assert!(after.iter().all(|frame| frame.torque == [0.0; 4]));
        // The reset: ticks begin anew, and every record tells the cause.
        assert_eq!(after[1].record.tick, 0);
        let told = |r: &Record| r.mode == Mode::Latched as u8 && r.fault == fault as u16;
        assert!(after[1..].iter().all(|frame| told(&frame.record)), "{crash:?}");
        assert!(fall.status != 0 && evidence.crash_status == fall.status);
        assert_eq!((evidence.boots, evidence.crash_fault()), (2, Some(fault)));
        // Every tick up to the crash, in the ring at full rate.
        let last: Vec<_> =
            tape.frames[at - 64..at].iter().map(|frame| Entry::from(&frame.record)).collect();
        assert!(evidence.full_in_order().eq(&last), "{crash:?}");
        let errors: Vec<_> = evidence.errors_in_order().map(|e| (e.tick, e.fault)).collect();
        assert_eq!(errors, [(before.record.tick, fault as u16)]);
    }
}

/// What the operator gives with a tick, and the record of one much later.
fn after(session: &mut Session<'_>, board: &mut Breakable, command: Command) -> Record {
    session.order(command);
    (0..600).fold(Record::default(), |_, _| session.tick(board).expect("a tick"))
}

#[test]
fn a_crash_is_left_by_clear_and_a_confirmed_pose_only() {
    let scenario = paper();
    let image = board::open("mps2-an386");
    let mut session = Session::new(&scenario, false);
    let kept = kept_of(&scenario);
    let mut board =
        Breakable::start(&image.path, kept, session.retained(), session.bench()).expect("a board");
    while session.start_s().is_none() || session.progress().0 < 12_000 {
        session.tick(&mut board).expect("a tick");
    }
    board.crash(Crash::HardFault);
    session.tick(&mut board).expect("a tick");
    assert!(board.fall().is_some());
    let brief = |record: Record| {
        (
            Mode::from_number(record.mode).expect("a mode"),
            Fault::from_number(record.fault).expect("a fault"),
            Refusal::from_number(record.refusal).expect("a refusal"),
        )
    };
    // The board has forgotten the operator's session.
    let record = after(&mut session, &mut board, Command::Clear);
    assert_eq!(brief(record), (Mode::Latched, Fault::HardFault, Refusal::None));
    session.reconnect();
    let mut order = |command| brief(after(&mut session, &mut board, command));
    let crashed = (Mode::Latched, Fault::HardFault, Refusal::WrongMode);
    assert_eq!(order(Command::Arm), crashed);
    // The arm has moved since it was parked.
    let moved = (Mode::Boot, Fault::ParkedPoseDiffers);
    assert_eq!(order(Command::Clear), (moved.0, moved.1, Refusal::None));
    assert_eq!(order(Command::Arm), (moved.0, moved.1, Refusal::WrongMode));
    let ready = (Mode::Standby, Fault::None, Refusal::None);
    assert_eq!(order(Command::ConfirmPose), ready);
    let evidence = board.stop().expect("an end").evidence;
    assert_eq!(evidence.crash_fault(), Some(Fault::HardFault), "until the next arming");
    assert!(evidence.parked_pose().is_some());
}

/// The handler's own way: so short that at 25 MHz even 10 cycles an instruction take far less than 1 ms.
#[test]
fn the_handler_is_short() {
    let image = board::open("mps2-an386");
    let end = image.function_named("crash::end").expect("the handler's body").start;
    let functions = stack::reachable(&image, end, &[]).expect("a call graph");
    let instructions = |start: &u32| {
        let function = &image.functions[start];
        image.code.range(function.start..function.end).count()
    };
    let count: usize = functions.iter().map(instructions).sum();
    assert!((10..250).contains(&count), "{count} instructions");
}
