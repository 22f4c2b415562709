//! A station without a tick, and consoles to talk to it.

use firmware::config::Config;
use firmware::link::{Access, Archive, Station};
use firmware::planner::Order;
use hil_sim::console::{Console, KEY, Line};
use shared::evidence::CHUNK_BYTES;
use shared::link::{Answer, DEFAULT_KEY, Frame, Key, Kind};

/// Two pieces of evidence.
struct Pieces;

impl Archive for Pieces {
    fn chunk(&self, section: u8, index: u16) -> Option<[u8; CHUNK_BYTES]> {
        (section == 0 && index < 2).then_some([index as u8; CHUNK_BYTES])
    }
}

/// See the module's documentation.
pub struct Rig {
    pub station: Station,
    line: Line,
    said: Vec<u8>,
}

pub fn console(challenge: u8) -> Console {
    Console::new(KEY, [challenge; 16], 2_000)
}

impl Rig {
    /// A board with this key that has booted as often.
    pub fn new(key: Key, boots: u32) -> Self {
        let mut station = Station::new();
        station.configure(&Config::default(), &Access { key, boots });
        Self { station, line: Line::default(), said: Vec::new() }
    }

    /// With the usual key and a console in session.
    pub fn in_session() -> (Self, Console) {
        let (mut rig, mut console) = (Self::new(KEY, 3), console(1));
        rig.greet(&mut console);
        (rig, console)
    }

    /// Opens a session and makes it current.
    pub fn greet(&mut self, console: &mut Console) {
        let hello = console.hello();
        self.send(&hello.to_wire());
        console.hear(&self.said);
        assert!(console.is_in_session());
        let heartbeat = console.heartbeat();
        assert!(self.send(&heartbeat.to_wire()).alive);
        self.tick(0);
    }

    /// Delivers these bytes; gives what the next tick would be told.
    pub fn send(&mut self, bytes: &[u8]) -> Told {
        self.line.deliver(bytes);
        self.station.serve(&mut self.line, &Pieces);
        self.said = self.line.take();
        let served = self.station.served();
        Told { order: served.order().copied(), alive: served.alive }
    }

    /// The tick takes what was served, with this refusal.
    pub fn tick(&mut self, refusal: u8) {
        self.station.taken(refusal);
        self.said.extend({
            self.station.serve(&mut self.line, &Pieces);
            self.line.take()
        });
    }

    /// What the console understands of what the board said last.
    pub fn heard_by(&mut self, console: &mut Console) -> Vec<Frame> {
        console.heard();
        console.hear(&self.said);
        console.heard()
    }

    /// Kind, counter and reason of the one answer that the console got.
    pub fn answer_to(&mut self, console: &mut Console) -> (u8, u32, u8) {
        let heard = self.heard_by(console);
        assert_eq!(heard.len(), 1, "{heard:?}");
        assert_eq!(heard[0].kind, Kind::Answer as u8);
        let Answer { kind, counter, reason, .. } = heard[0].payload();
        (kind, counter, reason)
    }
}

/// What the next tick is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    pub order: Option<Order>,
    pub alive: bool,
}

/// Nothing at all.
pub const NOTHING: Told = Told { order: None, alive: false };

/// A board that nobody gave a key.
pub fn unowned() -> (Rig, Console) {
    let (mut rig, mut console) =
        (Rig::new(DEFAULT_KEY, 1), Console::new(DEFAULT_KEY, [1; 16], 2_000));
    rig.greet(&mut console);
    (rig, console)
}
