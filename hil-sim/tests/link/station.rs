//! One session: the good path, each refusal with its reason, stops.

use firmware::config::Config;
use firmware::planner::Order;
use hil_sim::console::{Console, KEY, coded};
use shared::command::Command;
use shared::fault::{LinkRefusal, Mode, Refusal};
use shared::link::{Counters, Evidence, Frame, Kind, QueryKind, State, Versions};
use shared::telemetry::Record;

use super::rig::{NOTHING, Rig, console, unowned};

#[test]
fn a_command_becomes_an_order_and_is_answered_with_the_ticks_verdict() {
    for (refusal, reason) in [(Refusal::None, 0), (Refusal::WrongMode, 1)] {
        let (mut rig, mut console) = Rig::in_session();
        let arm = console.command(&Command::Arm);
        let told = rig.send(&arm.to_wire());
        assert_eq!((told.order, told.alive), (Some(Order::Arm), true));
        assert!(rig.heard_by(&mut console).is_empty(), "not before the tick");
        rig.tick(refusal as u8);
        assert_eq!(rig.answer_to(&mut console), (Kind::Command as u8, arm.counter, reason));
        assert_eq!(rig.send(&[]), NOTHING, "once only");
    }
}

#[test]
fn gains_are_set_by_name_and_refused_out_of_range() {
    let (mut rig, mut console) = Rig::in_session();
    let mut order = |name, values| {
        let frame = console.command(&Command::SetGain { name, values });
        let told = rig.send(&frame.to_wire());
        rig.tick(0);
        told.order
    };
    assert!(matches!(order(0, [45.0; 4]), Some(Order::SetGains(_))));
    let refused = [(0, [-1.0; 4]), (7, [1.0; 4]), (5, [1.0; 4]), (1, [f32::NAN; 4])];
    let reasons = refused.map(|(name, values)| match order(name, values) {
        Some(Order::Refused(refusal)) => refusal,
        other => panic!("{other:?}"),
    });
    let range = Refusal::GainOutOfRange;
    assert_eq!(reasons, [range, Refusal::UnknownGain, Refusal::OtherLaw, range]);
}

#[test]
fn queries_are_answered_at_once() {
    let (mut rig, mut console) = Rig::in_session();
    let record =
        Record { tick: 77, mode: Mode::Holding as u8, code: [1, 2, 3, 4], ..Record::default() };
    rig.station.note(&record);
    let mut ask = |what, index| {
        let frame = console.query(what, index);
        assert!(rig.send(&frame.to_wire()).alive);
        rig.station.taken(0);
        rig.heard_by(&mut console)[0]
    };
    assert_eq!(ask(QueryKind::State, 0).payload::<State>(), State::from(&record));
    let versions: Versions = ask(QueryKind::Versions, 0).payload();
    assert_eq!((versions.parameters, versions.boots), (Config::default().crc(), 3));
    assert_eq!(versions.firmware, [0, 1, 0]);
    let counters: Counters = ask(QueryKind::Counters, 0).payload();
    assert_eq!((counters.taken, counters.hellos, counters.malformed), (5, 1, 0));
    for index in 0..2 {
        let piece = ask(QueryKind::Evidence, index);
        assert_eq!(piece.kind, Kind::Evidence as u8);
        assert_eq!(piece.payload::<Evidence>().bytes, [index as u8; 36]);
    }
}

/// Each with its own reason, none with an effect, all counted.
#[test]
fn what_fails_a_check_is_refused_with_its_reason() {
    let (mut rig, mut console) = Rig::in_session();
    let heartbeat = |console: &mut Console, change: fn(&mut Frame)| {
        let mut frame = console.heartbeat();
        change(&mut frame);
        frame
    };
    let sealed = |mut frame: Frame| {
        frame.seal();
        frame
    };
    let mut cut = console.heartbeat().to_wire().to_vec();
    cut.truncate(40);
    cut.push(0);
    let session = |console: &mut Console, payload| console.next(Kind::Command, payload);
    let cases: Vec<(Vec<u8>, LinkRefusal)> = vec![
        (cut, LinkRefusal::Length),
        (heartbeat(&mut console, |f| f.counter ^= 1).to_wire().to_vec(), LinkRefusal::Damaged),
        (
            sealed(heartbeat(&mut console, |f| f.version = 2)).to_wire().to_vec(),
            LinkRefusal::Version,
        ),
        (
            sealed(heartbeat(&mut console, |f| f.reserved[0] = 1)).to_wire().to_vec(),
            LinkRefusal::Reserved,
        ),
        (sealed(heartbeat(&mut console, |f| f.kind = 0x20)).to_wire().to_vec(), LinkRefusal::Kind),
        (console.next(Kind::Welcome, [0; 40]).to_wire().to_vec(), LinkRefusal::Kind),
        (
            sealed(heartbeat(&mut console, |f| f.payload[3] = 9)).to_wire().to_vec(),
            LinkRefusal::BadCode,
        ),
        (
            sealed(heartbeat(&mut console, |f| f.counter += 1)).to_wire().to_vec(),
            LinkRefusal::BadCode,
        ),
        (coded(&KEY, console.heartbeat()).to_wire().to_vec(), LinkRefusal::BadCode),
    ];
    let count = cases.len() as u32;
    for (wire, refusal) in cases {
        assert_eq!(rig.send(&wire), NOTHING, "{refusal:?}");
        assert_eq!(rig.answer_to(&mut console).2, refusal as u8, "{refusal:?}");
    }
    let meaningless = session(&mut console, [0xEE; 40]);
    assert_eq!(rig.send(&meaningless.to_wire()).order, None);
    assert_eq!(rig.answer_to(&mut console).2, LinkRefusal::Malformed as u8);
    let missing = console.query(QueryKind::Evidence, 2);
    rig.send(&missing.to_wire());
    assert_eq!(rig.answer_to(&mut console).2, LinkRefusal::NoSuchPiece as u8);
    let query = console.query(QueryKind::Counters, 0);
    rig.send(&query.to_wire());
    let counters: Counters = rig.heard_by(&mut console)[0].payload();
    assert_eq!(counters.malformed + counters.unauthentic, count);
    assert_eq!((counters.meaningless, counters.stale, counters.orders), (1, 0, 0));
}

#[test]
fn without_a_session_everything_but_hello_and_stop_is_refused() {
    let (mut rig, mut console) = (Rig::new(KEY, 1), console(1));
    let arm = console.command(&Command::Arm);
    assert_eq!(rig.send(&arm.to_wire()), NOTHING);
    assert_eq!(rig.answer_to(&mut console).2, LinkRefusal::NoSession as u8);
}

#[test]
fn the_default_key_does_not_arm() {
    let (mut rig, mut console) = unowned();
    let arm = console.command(&Command::Arm);
    let told = rig.send(&arm.to_wire());
    assert_eq!(told.order, Some(Order::Refused(Refusal::DefaultKey)));
    rig.tick(Refusal::DefaultKey as u8);
    assert_eq!(rig.answer_to(&mut console).2, Refusal::DefaultKey as u8);
}

#[test]
fn a_stop_needs_nothing_but_its_form() {
    let stop = Console::stop();
    let sent_to = |mut rig: Rig, before: &[u8]| {
        rig.send(before);
        let told = rig.send(&stop.to_wire());
        (told.order, told.alive)
    };
    let expected = (Some(Order::Stop), false);
    assert_eq!(sent_to(Rig::new(KEY, 1), &[]), expected);
    assert_eq!(sent_to(Rig::in_session().0, &[]), expected);
    assert_eq!(sent_to(unowned().0, &[]), expected);
    assert_eq!(sent_to(Rig::in_session().0, &[0x55; 100]), expected, "behind garbage");
    let damaged = Frame { counter: 1, ..stop };
    assert_eq!(Rig::new(KEY, 1).send(&damaged.to_wire()), NOTHING);
}

#[test]
fn a_stop_behind_another_order_comes_one_tick_later() {
    let (mut rig, mut console) = Rig::in_session();
    let arm = console.command(&Command::Arm);
    let both = [arm.to_wire(), Console::stop().to_wire()].concat();
    assert_eq!(rig.send(&both).order, Some(Order::Arm));
    rig.tick(0);
    assert_eq!(rig.station.served().order(), Some(&Order::Stop));
}

#[test]
fn a_slipping_arm_is_given_its_way_down_until_it_has_one() {
    let mut rig = Rig::new(KEY, 1);
    let code = [1 << 24, 1 << 24, 1 << 24, 1 << 26];
    let lowering = Record { mode: Mode::Lowering as u8, code, ..Record::default() };
    for _ in 0..2 {
        rig.station.note(&lowering);
        assert!(matches!(rig.send(&[]).order, Some(Order::Lower(_))));
        rig.station.taken(0);
    }
    rig.station.note(&Record { path_rate: 1 << 15, ..lowering });
    assert_eq!(rig.send(&[]).order, None);
}
