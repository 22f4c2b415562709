//! The operator's console: speaks the operator link's frames, with codes of its own making.

mod line;

use std::collections::VecDeque;

use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;
use shared::command::Command;
use shared::link::{
    CODED_BYTES, Frame, Hello, Key, Kind, Query, QueryKind, Receiver, Welcome, session_message,
};

pub use line::Line;

/// Key of the boards in this harness.
pub const KEY: Key = *b"a key for simulated boards only.";

/// Heartbeats a second.
const HEARTBEAT_HZ: u32 = 50;

/// See the module's documentation.
#[derive(Debug)]
pub struct Console {
    key: Key,
    challenge: [u8; 16],
    /// Key of the session, once there is one.
    session: Option<Key>,
    /// Counter of the last frame sent.
    sent: u32,
    /// Counter of the last frame heard in this session.
    heard: u32,
    receiver: Receiver,
    frames: VecDeque<Frame>,
    /// Ticks between two heartbeats, and to the next one.
    interval: u32,
    left: u32,
    greeted: bool,
    /// Commands that wait for a session.
    waiting: VecDeque<Command>,
}

impl Console {
    /// Of an operator who has `key`; `challenge` must never have been used before.
    pub fn new(key: Key, challenge: [u8; 16], tick_hz: u32) -> Self {
        Self {
            key,
            challenge,
            session: None,
            sent: 0,
            heard: 0,
            receiver: Receiver::new(),
            frames: VecDeque::new(),
            interval: (tick_hz / HEARTBEAT_HZ).max(1),
            left: 0,
            greeted: false,
            waiting: VecDeque::new(),
        }
    }

    /// What is sent before the coming tick: a Hello first of all; in the session heartbeats, and commands one a tick.
    pub fn speak(&mut self, command: Option<Command>) -> Vec<u8> {
        self.waiting.extend(command);
        if !self.greeted {
            self.greeted = true;
            return self.hello().to_wire().to_vec();
        }
        let mut bytes = Vec::new();
        if self.session.is_none() {
            return bytes;
        }
        if self.left == 0 {
            self.left = self.interval;
            bytes.extend(self.heartbeat().to_wire());
        }
        self.left -= 1;
        if let Some(command) = self.waiting.pop_front() {
            bytes.extend(self.command(&command).to_wire());
        }
        bytes
    }

    /// A Hello.
    pub fn hello(&mut self) -> Frame {
        let hello = Hello { challenge: self.challenge, reserved: [0; 24] };
        coded(&self.key, Frame::new(Kind::Hello, 0, hello))
    }

    /// A heartbeat.
    pub fn heartbeat(&mut self) -> Frame {
        self.next(Kind::Heartbeat, [0; 40])
    }

    /// A command.
    pub fn command(&mut self, command: &Command) -> Frame {
        self.next(Kind::Command, command.to_bytes())
    }

    /// A query; `index` is that of a piece of evidence.
    pub fn query(&mut self, what: QueryKind, index: u16) -> Frame {
        let query = Query { what: what as u8, section: 0, index, rest: [0; 9] };
        self.next(Kind::Query, bytemuck::cast(query))
    }

    /// A stop, which anybody can send.
    pub fn stop() -> Frame {
        let mut frame = Frame::new(Kind::Stop, 0, [0_u8; 40]);
        frame.seal();
        frame
    }

    /// The session's next frame; without a session nobody will take it.
    pub fn next(&mut self, kind: Kind, payload: [u8; 40]) -> Frame {
        self.sent += 1;
        let frame = Frame::new(kind, self.sent, payload);
        coded(&self.session.unwrap_or(self.key), frame)
    }

    /// Takes what the board says.
    pub fn hear(&mut self, bytes: &[u8]) {
        for byte in bytes {
            if let Some(Ok(kind)) = self.receiver.feed(*byte) {
                let frame = *self.receiver.frame();
                self.take(kind, frame);
            }
        }
    }

    /// What the board said since this was last asked, as far as it is authentic.
    pub fn heard(&mut self) -> Vec<Frame> {
        self.frames.drain(..).collect()
    }

    /// Whether there is a session.
    pub fn is_in_session(&self) -> bool {
        self.session.is_some()
    }

    fn take(&mut self, kind: Kind, frame: Frame) {
        if kind == Kind::Welcome {
            let Welcome { challenge, boots, hellos, .. } = frame.payload();
            let key = hmac(&self.key, &session_message(challenge, boots, hellos));
            if challenge == self.challenge && is_coded(&key, &frame) {
                (self.session, self.sent, self.heard) = (Some(key), 0, frame.counter);
                self.frames.push_back(frame);
            }
            return;
        }
        let key = self.session.unwrap_or(self.key);
        if is_coded(&key, &frame) && frame.counter > self.heard {
            self.heard = frame.counter;
            self.frames.push_back(frame);
        }
    }
}

fn hmac(key: &Key, message: &[u8]) -> Key {
    let mut mac = Hmac::<Sha256>::new_from_slice(key).expect("any length will do");
    mac.update(message);
    mac.finalize().into_bytes().into()
}

/// Whether the frame carries this key's code.
fn is_coded(key: &Key, frame: &Frame) -> bool {
    hmac(key, frame.coded())[..16] == frame.code
}

/// `frame` with code and CRC.
pub fn coded(key: &Key, mut frame: Frame) -> Frame {
    let bytes: [u8; 68] = bytemuck::cast(frame);
    frame.code.copy_from_slice(&hmac(key, &bytes[..CODED_BYTES])[..16]);
    frame.seal();
    frame
}
