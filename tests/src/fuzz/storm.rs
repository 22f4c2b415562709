//! Mutated frames of the operator link by the million: nothing may come of them, and no stop be missed.
//!
//! The frames are a session's own, with right codes. A tenth is repeated as it was: its counter is stale. Of the rest
//! each has bits changed, before COBS or behind it, is cut short or runs into the next; half of all get a new CRC.

use firmware::planner::Order;
use hil_sim::console::Console;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use shared::command::Command;
use shared::fault::LinkRefusal;
use shared::link::{FRAME_BYTES, Frame, Kind, QueryKind, WIRE_BYTES};

use super::link::{Board, Effect};

/// A well-formed stop comes after as many frames.
const STOP_EVERY: u64 = 100;
/// Frames that the mutants are made of.
const FRAMES: usize = 1_024;

/// What was sent and what came of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    /// Mutated frames.
    pub mutants: u64,
    /// Of these with a new CRC.
    pub resealed: u64,
    /// Repetitions, whose code is right.
    pub stale: u64,
    /// Stops, and those among the mutants that the new CRC has made one.
    pub stops: u64,
    /// Answers of the board, with which reason: index is the number less 100.
    pub refusals: [u64; 12],
}

struct Storm {
    board: Board,
    fresh: Vec<Frame>,
    old: Vec<Frame>,
    random: Xoshiro256PlusPlus,
    tally: Tally,
}

/// Sends `count` mutated frames to one board.
///
/// # Panics
/// Where anything comes of one that should not, or a stop is missed.
pub fn storm(seed: u64, count: u64) -> Tally {
    let mut board = Board::new();
    let old = frames(&mut board.console);
    // The last of them makes all others stale.
    let last = old.last().expect("there are some");
    board.serve(&last.to_wire());
    let fresh = frames(&mut board.console);
    let random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut storm = Storm { board, fresh, old, random, tally: Tally::default() };
    for i in 1..=count {
        if i % 10 == 0 {
            storm.repeat()
        } else {
            storm.mutate()
        }
        if i % STOP_EVERY == 0 {
            storm.tally.stops += 1;
            let effect = storm.board.serve(&Console::stop().to_wire());
            assert_eq!(effect, Effect { alive: false, orders: vec![Order::Stop] }, "frame {i}");
        }
        storm.count_answers();
    }
    storm.still_heard();
    storm.tally
}

/// Heartbeats, commands and queries with rising counters.
fn frames(console: &mut Console) -> Vec<Frame> {
    let gain = Command::SetGain { name: 0, values: [45.0; 4] };
    let commands = [Command::Arm, Command::Clear, Command::Jog([0.01; 4]), gain];
    let frame = |i: usize| match i % 8 {
        0..4 => console.command(&commands[i % 4]),
        4 => console.query(QueryKind::State, 0),
        _ => console.heartbeat(),
    };
    (0..FRAMES).map(frame).collect()
}

impl Storm {
    fn below(&mut self, limit: usize) -> usize {
        (self.random.next_u64() % limit as u64) as usize
    }

    fn repeat(&mut self) {
        let frame = self.old[self.random.next_u64() as usize % FRAMES];
        self.tally.stale += 1;
        let effect = self.board.serve(&frame.to_wire());
        assert_eq!(effect, Effect::default(), "{frame:?}");
    }

    fn mutate(&mut self) {
        self.tally.mutants += 1;
        let place = self.below(FRAMES);
        let mut frame = self.fresh[place];
        let reseal = self.tally.mutants.is_multiple_of(9) || self.tally.mutants % 9 < 5;
        if reseal {
            self.tally.resealed += 1;
            self.spoil(&mut bytemuck::bytes_of_mut(&mut frame)[..FRAME_BYTES - 4]);
            frame.seal();
        }
        let mut wire = frame.to_wire().to_vec();
        match if reseal { 0 } else { 1 + self.below(4) } {
            1 => self.spoil(&mut wire[1..WIRE_BYTES - 1]),
            2 => {
                self.spoil(bytemuck::bytes_of_mut(&mut frame));
                wire = frame.to_wire().to_vec();
            }
            3 => {
                let left = self.below(WIRE_BYTES - 2);
                wire.truncate(1 + left);
            }
            4 => {
                let next = self.below(FRAMES);
                wire.pop();
                wire.extend(&self.fresh[next].to_wire()[1..]);
            }
            _ => {}
        }
        let stops = frame.check() == Ok(Kind::Stop) && reseal;
        self.tally.stops += u64::from(stops);
        let orders = if stops { vec![Order::Stop] } else { Vec::new() };
        assert_eq!(self.board.serve(&wire), Effect { alive: false, orders }, "{frame:?}");
    }

    /// Up to four flipped bits, or a burst of up to 32.
    fn spoil(&mut self, bytes: &mut [u8]) {
        let bits = 8 * bytes.len();
        let before = bytes.to_vec();
        if self.below(2) == 0 {
            for _ in 0..=self.below(4) {
                let bit = self.below(bits);
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
        } else {
            let (first, burst) = (self.below(bits), self.random.next_u64() as u32 | 1);
            for bit in (first..bits.min(first + 32)).filter(|bit| burst >> (bit - first) & 1 == 1) {
                bytes[bit / 8] ^= 1 << (bit % 8);
            }
        }
        // Two flips may cancel.
        if bytes == before {
            bytes[0] ^= 1;
        }
    }

    fn count_answers(&mut self) {
        for frame in self.board.console.heard() {
            let reason = frame.payload::<shared::link::Answer>().reason;
            if frame.kind == Kind::Answer as u8 && LinkRefusal::from_number(reason).is_some() {
                self.tally.refusals[usize::from(reason - 100)] += 1;
            }
        }
    }

    /// The operator's next frame counts, and its session is the one it was.
    fn still_heard(&mut self) {
        let frame = self.fresh[0];
        assert_eq!(self.board.serve(&frame.to_wire()).orders, [Order::Arm]);
    }
}
