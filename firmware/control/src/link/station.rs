//! The station: takes the operator's frames from any stream, plans what they order, and answers.
//!
//! It runs beside the tick. What it has served is handed to the next tick ([`Station::served`]), whose verdict comes
//! back ([`Station::taken`]) and is what the operator is answered; until then no further order is planned.

use embedded_io::{Read, ReadReady, Write};
use shared::command::Command;
use shared::evidence::{CHUNK_BYTES, CHUNKS, Image};
use shared::fault::{LinkRefusal, Mode, Refusal};
use shared::link::{
    Answer, Counters, Evidence, Frame, Kind, Query, QueryKind, Receiver, State, Versions,
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
#[derive(Clone, Copy, Debug, Default)]
pub struct Served {
    /// An order.
    pub order: Option<Order>,
    /// A new authentic frame of the operator came.
    pub alive: bool,
}

/// What a byte led to.
enum Reply {
    None,
    /// The frame that is to be sent is complete.
    Frame,
    /// It needs this piece of evidence.
    Piece(u8, u16),
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
    /// For a validated configuration.
    #[inline(never)]
    pub fn new(config: &Config, access: Access) -> Self {
        let sessions = Sessions::new(access);
        let versions = Versions {
            firmware: const {
                [
                    number(env!("CARGO_PKG_VERSION_MAJOR")),
                    number(env!("CARGO_PKG_VERSION_MINOR")),
                    number(env!("CARGO_PKG_VERSION_PATCH")),
                ]
            },
            default_key: u8::from(sessions.has_default_key()),
            reserved: 0,
            parameters: config.crc(),
            tick_hz: config.tick_hz,
            pieces: CHUNKS as u32,
            boots: sessions.boots(),
            rest: [0; 4],
        };
        Self {
            planner: Planner::new(config),
            sessions,
            receiver: Receiver::new(),
            served: Served { order: None, alive: false },
            state: bytemuck::zeroed(),
            versions,
            counters: bytemuck::zeroed(),
            reply: bytemuck::zeroed(),
            sent: 0,
            asked: None,
            verdict: None,
        }
    }

    /// Takes note of a tick's record.
    pub fn note(&mut self, record: &Record) {
        self.state = State::from(record);
    }

    /// What the next tick is to be told.
    pub fn served(&self) -> &Served {
        &self.served
    }

    /// A tick took what was served; its record names this [`Refusal`].
    pub fn taken(&mut self, refusal: u8) {
        if self.served.order.is_some() {
            self.verdict = Some(refusal);
        }
        self.served = Served { order: None, alive: false };
    }

    /// Takes what has come in, up to an order, and answers.
    #[inline(always)]
    pub fn serve<S: Read + ReadReady + Write>(&mut self, stream: &mut S, archive: &impl Archive) {
        if self.settle() {
            send(stream, &self.reply);
        }
        for _ in 0..BYTES_MAX {
            let mut byte = [0];
            if self.served.order.is_some()
                || !matches!(stream.read_ready(), Ok(true))
                || !matches!(stream.read(&mut byte), Ok(1))
            {
                break;
            }
            let [byte] = byte;
            match self.take(byte) {
                Reply::None => continue,
                Reply::Frame => {}
                Reply::Piece(section, index) => {
                    self.reply_piece(section, index, archive.chunk(section, index));
                }
            }
            send(stream, &self.reply);
        }
        self.lower();
    }

    /// Takes one byte.
    #[inline(never)]
    fn take(&mut self, byte: u8) -> Reply {
        match self.receiver.feed(byte) {
            None => Reply::None,
            Some(Err(refusal)) => {
                count(&mut self.counters.malformed);
                self.refuse(refusal)
            }
            Some(Ok(kind)) => self.judge(kind).unwrap_or_else(|refusal| self.refuse(refusal)),
        }
    }

    /// Takes a well-formed frame.
    fn judge(&mut self, kind: Kind) -> Result<Reply, LinkRefusal> {
        let counters = &mut self.counters;
        match kind {
            Kind::Stop => {
                count(&mut counters.stops);
                self.plan(&Command::Stop);
                return Ok(Reply::None);
            }
            Kind::Hello => {
                let welcome = self.sessions.open(self.receiver.frame());
                let welcome = welcome.inspect_err(|_| count(&mut counters.unauthentic))?;
                count(&mut counters.hellos);
                count(&mut counters.taken);
                self.prepare(Kind::Welcome, bytemuck::cast(welcome));
                return Ok(Reply::Frame);
            }
            Kind::Heartbeat | Kind::Command | Kind::Query => {}
            _ => {
                count(&mut counters.malformed);
                return Err(LinkRefusal::Kind);
            }
        }
        self.sessions.admit(self.receiver.frame()).inspect_err(|refusal| {
            let stale = *refusal == LinkRefusal::Stale;
            count(if stale { &mut counters.stale } else { &mut counters.unauthentic });
        })?;
        self.served.alive = true;
        match kind {
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
    fn plan(&mut self, command: &Command) {
        count(&mut self.counters.taken);
        count(&mut self.counters.orders);
        let frame = self.receiver.frame();
        self.asked = Some((frame.kind, frame.counter));
        let locked = *command == Command::Arm && self.sessions.has_default_key();
        self.served.order = Some(if locked {
            Order::Refused(Refusal::DefaultKey)
        } else {
            self.planner.plan(command, &self.state.code)
        });
    }

    fn query(&mut self) -> Result<Reply, LinkRefusal> {
        let query: Query = self.receiver.frame().payload();
        let what = QueryKind::from_number(query.what).ok_or(LinkRefusal::Malformed)?;
        count(&mut self.counters.taken);
        match what {
            QueryKind::State => self.prepare(Kind::State, bytemuck::cast(self.state)),
            QueryKind::Versions => self.prepare(Kind::Versions, bytemuck::cast(self.versions)),
            QueryKind::Counters => self.prepare(Kind::Counters, bytemuck::cast(self.counters)),
            QueryKind::Evidence => return Ok(Reply::Piece(query.section, query.index)),
        }
        Ok(Reply::Frame)
    }

    #[inline(never)]
    fn reply_piece(&mut self, section: u8, index: u16, piece: Option<[u8; CHUNK_BYTES]>) {
        match piece {
            Some(bytes) => {
                let piece = Evidence { reserved: 0, section, index, bytes };
                self.prepare(Kind::Evidence, bytemuck::cast(piece));
            }
            None => self.answer_received(LinkRefusal::NoSuchPiece as u8),
        }
    }

    fn refuse(&mut self, refusal: LinkRefusal) -> Reply {
        if refusal == LinkRefusal::Malformed {
            count(&mut self.counters.meaningless);
        }
        self.answer_received(refusal as u8);
        Reply::Frame
    }

    /// Answers the frame that was received last.
    fn answer_received(&mut self, reason: u8) {
        let frame = self.receiver.frame();
        self.answer(frame.kind, frame.counter, reason);
    }

    #[inline(never)]
    fn answer(&mut self, kind: u8, counter: u32, reason: u8) {
        let answer = Answer { kind, reason, reserved: [0; 2], counter, rest: [0; 8] };
        self.prepare(Kind::Answer, bytemuck::cast(answer));
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

    /// Completes the frame to be sent.
    #[inline(never)]
    fn prepare(&mut self, kind: Kind, payload: [u32; 10]) {
        self.sent = self.sent.wrapping_add(1);
        self.reply = Frame::new(kind, self.sent, payload);
        sign(self.sessions.key(kind == Kind::Welcome), &mut self.reply);
    }

    /// An arm that a slipping brake lets down needs a way to its rest pose.
    fn lower(&mut self) {
        let waits = self.state.mode == Mode::Lowering as u8 && self.state.path_rate == 0;
        if waits && self.served.order.is_none() {
            self.served.order = Some(self.planner.lower(&self.state.code));
        }
    }
}

fn count(counter: &mut u32) {
    *counter = counter.saturating_add(1);
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
