//! The first difference between what the board and the software put on bus, pins and telemetry.

use std::fmt;

use shared::evidence::Image;
use shared::telemetry::Record;

use crate::bench::Event;

/// A difference, by tick, place and field.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Tick since reset; `None` outside the ticks.
    pub tick: Option<u64>,
    /// Device, pin or record field.
    pub place: String,
    /// On the board.
    pub board: String,
    /// In software.
    pub software: String,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.tick {
            Some(tick) => write!(f, "tick {tick}, ")?,
            None => write!(f, "outside the ticks, ")?,
        }
        write!(f, "{}: board {}, software {}", self.place, self.board, self.software)
    }
}

/// Compares what the configuration became.
pub fn coefficients(board: &[u8], software: &[u8]) -> Option<Difference> {
    let differ = |place: String, board: String, software: String| {
        Some(Difference { tick: None, place, board, software })
    };
    if board.len() != software.len() {
        return differ(
            "size of the coefficients".into(),
            board.len().to_string(),
            software.len().to_string(),
        );
    }
    words("coefficient", board, software)
}

/// Compares what both kept of the run.
pub fn evidence(board: &Image, software: &Image) -> Option<Difference> {
    words("evidence", bytemuck::bytes_of(board), bytemuck::bytes_of(software))
}

/// The first word that differs.
fn words(of: &str, board: &[u8], software: &[u8]) -> Option<Difference> {
    let mut pairs = board.chunks_exact(4).zip(software.chunks_exact(4)).enumerate();
    pairs.find(|(_, (a, b))| a != b).map(|(i, (a, b))| Difference {
        tick: None,
        place: format!("{of} word {i}"),
        board: hex(a),
        software: hex(b),
    })
}

/// What a side shows of one tick.
pub struct Shown<'a> {
    /// Bus and pins in their order.
    pub traffic: Vec<Event>,
    /// What it said on the operator link.
    pub said: &'a [u8],
    /// Its record.
    pub record: Record,
}

/// Compares one tick: bus and pins, the operator link, then the record field by field.
pub fn tick(tick: u64, board: &Shown<'_>, software: &Shown<'_>) -> Option<Difference> {
    let differ = |place: String, board: String, software: String| {
        Some(Difference { tick: Some(tick), place, board, software })
    };
    for (a, b) in board.traffic.iter().zip(&software.traffic) {
        if a != b {
            return differ(format!("bus, {}", b.place()), a.to_string(), b.to_string());
        }
    }
    if board.traffic.len() != software.traffic.len() {
        return differ(
            "number of bus and pin events".into(),
            board.traffic.len().to_string(),
            software.traffic.len().to_string(),
        );
    }
    if board.said != software.said {
        return differ("operator link".into(), hex(board.said), hex(software.said));
    }
    if board.record.to_bytes() == software.record.to_bytes() {
        return None;
    }
    let fields = |record: &Record| named_fields(record).into_iter().collect::<Vec<_>>();
    fields(&board.record)
        .into_iter()
        .zip(fields(&software.record))
        .find(|((_, a), (_, b))| a != b)
        .and_then(|((name, a), (_, b))| differ(format!("record, {name}"), a, b))
}

/// Each field of a record by name, floats with their bits.
fn named_fields(r: &Record) -> Vec<(String, String)> {
    let floats = |name: &str, values: &[f32; 4]| {
        let name = name.to_owned();
        values
            .iter()
            .enumerate()
            .map(move |(j, v)| {
                (format!("{name} of joint {}", j + 1), format!("{v:e} ({:#010x})", v.to_bits()))
            })
            .collect::<Vec<_>>()
    };
    let whole = |name: &str, values: &[i64]| {
        let several = values.len() > 1;
        let name = name.to_owned();
        values
            .iter()
            .enumerate()
            .map(move |(j, v)| {
                let name =
                    if several { format!("{name} of joint {}", j + 1) } else { name.clone() };
                (name, v.to_string())
            })
            .collect::<Vec<_>>()
    };
    [
        whole("tick", &[r.tick.into()]),
        whole("mode", &[r.mode.into()]),
        whole("refusal", &[r.refusal.into()]),
        whole("fault", &[r.fault.into()]),
        whole("code", &r.code.map(i64::from)),
        whole("adc", &r.adc.map(i64::from)),
        whole("phase", &[r.phase.into()]),
        floats("qd", &r.qd),
        floats("e1", &r.e1),
        floats("e1_dot", &r.e1_dot),
        floats("d_hat", &r.d_hat),
        whole("dac", &r.dac.map(i64::from)),
        whole("saturated", &[r.saturated.into()]),
        whole("adaptation_bound", &[r.adaptation_bound.into()]),
        whole("rejected", &[r.rejected.into()]),
        whole("dropped", &[r.dropped.into()]),
        whole("limits", &[r.limits.into()]),
        whole("joints", &[r.joints.into()]),
        whole("powered", &[r.powered.into()]),
        whole("path_rate", &[r.path_rate.into()]),
        whole("irregular", &[r.irregular.into()]),
        whole("bucket", &[r.bucket.into()]),
    ]
    .concat()
}

fn hex(bytes: &[u8]) -> String {
    if bytes.is_empty() {
        return "nothing".into();
    }
    bytes.iter().map(|b| format!("{b:02x}")).collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests {
    use shared::telemetry::RECORD_BYTES;

    use super::*;

    #[test]
    fn every_bit_of_a_record_is_compared() {
        let bytes = Record::default().to_bytes();
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes;
            flipped[bit / 8] ^= 1 << (bit % 8);
            let [board, software] = [bytes, flipped].map(|bytes| shown(&[], &bytes));
            let found = tick(7, &board, &software);
            assert_eq!(found.and_then(|d| d.tick), Some(7), "bit {bit}");
        }
    }

    #[test]
    fn an_answer_of_one_side_alone_is_a_difference() {
        let bytes = Record::default().to_bytes();
        assert_eq!(tick(7, &shown(&[1, 2], &bytes), &shown(&[1, 2], &bytes)), None);
        let found = tick(7, &shown(&[1, 2], &bytes), &shown(&[], &bytes)).expect("a difference");
        assert_eq!(found.to_string(), "tick 7, operator link: board 01 02, software nothing");
    }

    fn shown<'a>(said: &'a [u8], record: &[u8; RECORD_BYTES]) -> Shown<'a> {
        Shown { traffic: Vec::new(), said, record: Record::from_bytes(record) }
    }
}
