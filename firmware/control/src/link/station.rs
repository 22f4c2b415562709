//! The station: takes the operator's frames from any stream, plans what they order, and answers.
//!
//! It runs beside the tick. What it has served is handed to the next tick ([`Station::served`]), whose verdict comes
//! back ([`Station::taken`]) and is what the operator is answered; until then no further order is planned.

use embedded_io::{Read, ReadReady, Write};
use shared::command::Command;
use shared::evidence::{CHUNK_BYTES, CHUNKS, Image};
use shared::fault::{LinkRefusal, Mode, Refusal};
use shared::link::{
    Answer, Counters, Evidence, Frame, Hello, Kind, Query, QueryKind, Receiver, State, Versions,
};
use shared::telemetry::Record;

use super::code::sign;
use super::session::{Access, Sessions};
use crate::config::Config;
use crate::planner::{Order, Planner};

/// What is kept for reading back.
pub trait Archive {
    /// A piece of a section, if there is one.
    fn chunk(&self, section: u8, index: u16) -> Option<[u8; CHUNK_BYTES]>;
}

/// Keeps nothing.
impl Archive for () {
    fn chunk(&self, _section: u8, _index: u16) -> Option<[u8; CHUNK_BYTES]> {
        None
    }
}

/// One section, the whole image.
impl Archive for Image {
    fn chunk(&self, section: u8, index: u16) -> Option<[u8; CHUNK_BYTES]> {
        if section == 0 { self.chunk(usize::from(index)) } else { None }
    }
}

/// What the next tick is to be told.
#[derive(Clone, Copy, Debug)]
pub struct Served {
    /// Meaningful while `ordered`: all bytes of nothing are zero, so that it takes no room in an image.
    order: Order,
    ordered: bool,
    /// A new authentic frame of the operator came.
    pub alive: bool,
}

impl Served {
    /// Nothing.
    pub const NONE: Self = Self { order: Order::Arm, ordered: false, alive: false };

    /// An order, if there is one.
    #[inline(always)]
    pub fn order(&self) -> Option<&Order> {
        if self.ordered { Some(&self.order) } else { None }
    }
}

/// What a byte led to.
enum Reply {
    None,
    /// The frame that is to be sent is complete.
    Frame,
    /// It needs the piece of evidence that was asked for.
    Piece,
}

/// Bytes taken at a time: three frames.
const BYTES_MAX: usize = 213;

/// See the module's documentation.
pub struct Station {
    planner: Planner,
    sessions: Sessions,
    receiver: Receiver,
    served: Served,
    state: State,
    versions: Versions,
    counters: Counters,
    /// Frame to be sent.
    reply: Frame,
    /// Frames sent.
    sent: u32,
    /// Kind and counter of the frame whose order a tick has to take first.
    asked: Option<(u8, u32)>,
    /// What the tick made of it.
    verdict: Option<u8>,
}

impl Station {
    /// Without a configuration.
    pub const fn new() -> Self {
        Self {
            planner: bytemuck::zeroed(),
            sessions: Sessions::NONE,
            receiver: Receiver::new(),
            served: Served::NONE,
            state: bytemuck::zeroed(),
            versions: bytemuck::zeroed(),
            counters: bytemuck::zeroed(),
            reply: bytemuck::zeroed(),
            sent: 0,
            asked: None,
            verdict: None,
        }
    }

    /// Takes a validated configuration and who may command; to be called once, before anything else.
    #[inline(never)]
    pub fn configure(&mut self, config: &Config, access: &Access) {
        self.planner.set(config);
        self.sessions.set(access);
        self.versions = Versions {
            firmware: const {
                [
                    number(env!("CARGO_PKG_VERSION_MAJOR")),
                    number(env!("CARGO_PKG_VERSION_MINOR")),
                    number(env!("CARGO_PKG_VERSION_PATCH")),
                ]
            },
            default_key: u8::from(self.sessions.has_default_key()),
            reserved: 0,
            parameters: config.crc(),
            tick_hz: config.tick_hz,
            pieces: CHUNKS as u32,
            boots: access.boots,
            rest: [0; 4],
        };
    }

    /// Takes note of a tick's record.
    #[inline(never)]
    pub fn note(&mut self, record: &Record) {
        self.state = State::from(record);
    }

    /// What the next tick is to be told.
    pub fn served(&self) -> &Served {
        &self.served
    }

    /// A tick took what was served; its record names this [`Refusal`].
    pub fn taken(&mut self, refusal: u8) {
        if self.served.ordered {
            self.verdict = Some(refusal);
        }
        (self.served.ordered, self.served.alive) = (false, false);
    }

    /// Takes what has come in, up to an order, and answers.
    #[inline(always)]
    pub fn serve<S: Read + ReadReady + Write>(&mut self, stream: &mut S, archive: &impl Archive) {
        if self.settle() {
            send(stream, &self.reply);
        }
        for _ in 0..BYTES_MAX {
            let mut byte = [0];
            if self.served.ordered
                || !matches!(stream.read_ready(), Ok(true))
                || !matches!(stream.read(&mut byte), Ok(1))
            {
                break;
            }
            let [byte] = byte;
            match self.take(byte) {
                Reply::None => continue,
                Reply::Frame => {}
                Reply::Piece => self.reply_piece(archive),
            }
            send(stream, &self.reply);
        }
        self.lower();
    }

    /// Takes one byte. Little is kept on the stack here: checking a code takes most of it.
    #[inline(never)]
    fn take(&mut self, byte: u8) -> Reply {
        let Some(received) = self.receiver.feed(byte) else { return Reply::None };
        let taken = received.and_then(|kind| {
            let frame = self.receiver.frame();
            match kind {
                Kind::Stop => {}
                Kind::Hello => self.sessions.open(frame)?,
                Kind::Heartbeat | Kind::Command | Kind::Query => self.sessions.admit(frame)?,
                _ => return Err(LinkRefusal::Kind),
            }
            self.obey(kind)
        });
        taken.unwrap_or_else(|refusal| self.refuse(refusal))
    }

    /// Does what a frame asks that passed its checks.
    #[inline(never)]
    fn obey(&mut self, kind: Kind) -> Result<Reply, LinkRefusal> {
        self.served.alive |= matches!(kind, Kind::Heartbeat | Kind::Command | Kind::Query);
        match kind {
            Kind::Stop => {
                count(&mut self.counters.stops);
                self.plan(&Command::Stop);
            }
            Kind::Hello => {
                count(&mut self.counters.hellos);
                count(&mut self.counters.taken);
                let challenge = self.receiver.frame().payload::<Hello>().challenge;
                let welcome = self.sessions.welcome(challenge);
                self.reply.payload = bytemuck::cast(welcome);
                self.prepare(Kind::Welcome);
                return Ok(Reply::Frame);
            }
            Kind::Command => {
                let command = Command::from_bytes(&self.receiver.frame().payload());
                self.plan(&command.ok_or(LinkRefusal::Malformed)?);
            }
            Kind::Query => return self.query(),
            _ => count(&mut self.counters.taken),
        }
        Ok(Reply::None)
    }

    /// Plans an order for the next tick.
    #[inline(never)]
    fn plan(&mut self, command: &Command) {
        count(&mut self.counters.taken);
        count(&mut self.counters.orders);
        let frame = self.receiver.frame();
        self.asked = Some((frame.kind, frame.counter));
        let locked = *command == Command::Arm && self.sessions.has_default_key();
        if locked {
            self.served.order = Order::Refused(Refusal::DefaultKey);
        } else {
            self.planner.plan(command, &self.state.code, &mut self.served.order);
        }
        self.served.ordered = true;
    }

    fn query(&mut self) -> Result<Reply, LinkRefusal> {
        let query: Query = self.receiver.frame().payload();
        let what = QueryKind::from_number(query.what).ok_or(LinkRefusal::Malformed)?;
        count(&mut self.counters.taken);
        let (kind, payload) = match what {
            QueryKind::State => (Kind::State, bytemuck::cast_ref(&self.state)),
            QueryKind::Versions => (Kind::Versions, bytemuck::cast_ref(&self.versions)),
            QueryKind::Counters => (Kind::Counters, bytemuck::cast_ref(&self.counters)),
            QueryKind::Evidence => return Ok(Reply::Piece),
        };
        self.reply.payload = *payload;
        self.prepare(kind);
        Ok(Reply::Frame)
    }

    #[inline(never)]
    fn reply_piece(&mut self, archive: &impl Archive) {
        let Query { section, index, .. } = self.receiver.frame().payload();
        match archive.chunk(section, index) {
            Some(bytes) => {
                let piece = Evidence { reserved: 0, section, index, bytes };
                self.reply.payload = bytemuck::cast(piece);
                self.prepare(Kind::Evidence);
            }
            None => self.answer_received(LinkRefusal::NoSuchPiece as u8),
        }
    }

    fn refuse(&mut self, refusal: LinkRefusal) -> Reply {
        use LinkRefusal::{BadCode, Malformed, NoSession, SessionsUsedUp, Stale};
        let counters = &mut self.counters;
        count(match refusal {
            Stale => &mut counters.stale,
            Malformed => &mut counters.meaningless,
            NoSession | BadCode | SessionsUsedUp => &mut counters.unauthentic,
            _ => &mut counters.malformed,
        });
        self.answer_received(refusal as u8);
        Reply::Frame
    }

    /// Answers the frame that was received last.
    fn answer_received(&mut self, reason: u8) {
        let frame = self.receiver.frame();
        self.answer(frame.kind, frame.counter, reason);
    }

    fn answer(&mut self, kind: u8, counter: u32, reason: u8) {
        let answer = Answer { kind, reason, reserved: [0; 2], counter, rest: [0; 8] };
        self.reply.payload = bytemuck::cast(answer);
        self.prepare(Kind::Answer);
    }

    /// Answers a command whose order a tick has taken; whether there is one.
    #[inline(never)]
    fn settle(&mut self) -> bool {
        let Some(reason) = self.verdict.take() else { return false };
        let Some((kind, counter)) = self.asked.take() else { return false };
        if reason != Refusal::None as u8 {
            count(&mut self.counters.refused);
        }
        self.answer(kind, counter, reason);
        true
    }

    /// Completes the frame to be sent, whose payload is there.
    #[inline(never)]
    fn prepare(&mut self, kind: Kind) {
        self.sent = self.sent.wrapping_add(1);
        self.reply.begin(kind, self.sent);
        sign(self.sessions.key(kind == Kind::Welcome), &mut self.reply);
    }

    /// An arm that a slipping brake lets down needs a way to its rest pose.
    fn lower(&mut self) {
        let waits = self.state.mode == Mode::Lowering as u8 && self.state.path_rate == 0;
        if waits && !self.served.ordered {
            self.planner.lower(&self.state.code, &mut self.served.order);
            self.served.ordered = true;
        }
    }
}

#[inline(never)]
fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
}

impl Default for Station {
    fn default() -> Self {
        Self::new()
    }
}

/// Sends a frame; what a broken line does not take is lost.
#[inline(never)]
fn send(stream: &mut impl Write, frame: &Frame) {
    let wire = frame.to_wire();
    let mut done = 0;
    // Each turn sends a byte at least.
    for _ in 0..wire.len() {
        let Some(rest) = wire.get(done..).filter(|rest| !rest.is_empty()) else { return };
        match stream.write(rest) {
            Ok(sent @ 1..) => done += sent,
            _ => return,
        }
    }
}

/// A decimal number of a version.
const fn number(digits: &str) -> u16 {
    match u16::from_str_radix(digits, 10) {
        Ok(number) => number,
        Err(_) => panic!("a version's number"),
    }
}
