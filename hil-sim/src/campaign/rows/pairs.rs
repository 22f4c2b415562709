//! Faults of the bus two at a time: the stronger reaction within the shorter time.

use crate::campaign::onset::Condition;
use crate::campaign::pose::Pose;
use crate::campaign::row::{Acting, Drop, Expect, Sign, Variant, fault};
use crate::campaign::witness::ADC;
use crate::faults::{Kind, Target};

/// Rows that concern the bus.
const ROWS: [u8; 7] = [1, 2, 3, 4, 5, 9, 10];

/// Every pair in a pose, with the number of the row that it counts for: that of the stronger reaction, else the first.
pub fn pairs(pose: &Pose) -> Vec<(u8, Variant)> {
    let firsts = ROWS.iter().enumerate();
    let both = firsts.flat_map(|(i, &a)| ROWS[i + 1..].iter().map(move |&b| (a, b)));
    both.map(|(a, b)| {
        let way = together(&one(a, false, pose), &one(b, true, pose));
        let counts_for = if b == 5 { b } else { a };
        (counts_for, Variant { name: format!("rows {a} and {b}: {}", way.name), ..way })
    })
    .collect()
}

/// The row's fault in the first of a pair or in the second: devices do not meet.
fn one(row: u8, second: bool, pose: &Pose) -> Variant {
    let j = if second { 3 } else { 0 };
    let encoder = Target::Encoder(j);
    let at_encoder = |what: &str| format!("{what} on encoder {}", j + 1);
    let ss1 =
        |name, faults, limit| Variant::new(name, faults, Expect::Ss1, Sign::Nothing, 0, limit);
    match row {
        1 => ss1(at_encoder("flipped bits"), vec![fault(Kind::BitFlips, encoder)], 3)
            .from(Condition::BucketFull(j)),
        2 => ss1(at_encoder("lost frames"), vec![fault(Kind::FrameLoss, encoder)], 3)
            .from(Condition::BucketFull(j)),
        3 if second => ss1("repeated ADC frames".into(), vec![fault(Kind::Repeat, Target::Adc)], 3)
            .from(Condition::After(3)),
        3 => {
            let condition = if pose.moves() { Condition::Still(j, 2) } else { Condition::Never };
            ss1(at_encoder("repeated frames"), vec![fault(Kind::Repeat, encoder)], 3)
                .from(condition)
        }
        4 => ss1(
            "encoders 2 and 3 swapped".into(),
            vec![fault(Kind::Swap, Target::Encoder(1)).of(3.0)],
            2,
        )
        .from(Condition::After(1)),
        5 => {
            let dead = ss1("dead DAC".into(), vec![fault(Kind::Dead, Target::Dac)], 5);
            Variant { expect: Expect::Sto, ..dead }.dropping(Drop::Bound(Acting::Held))
        }
        9 if second => {
            let over = ss1("overrange".into(), vec![fault(Kind::Overrange, Target::Joint(1))], 3);
            over.from(Condition::BucketFull(ADC)).due(Condition::After(2))
        }
        9 => ss1(at_encoder("error bit"), vec![fault(Kind::ErrorBit, encoder)], 3)
            .from(Condition::After(2)),
        _ => {
            let condition = if pose.moves() { Condition::Doubtful(j) } else { Condition::Never };
            ss1(at_encoder("old samples"), vec![fault(Kind::LateSamples, encoder)], 10)
                .from(condition)
        }
    }
}

fn together(a: &Variant, b: &Variant) -> Variant {
    let strong = if b.expect == Expect::Sto { b } else { a };
    let (condition, _) = strong.react[0];
    Variant {
        name: format!("{}, {}", a.name, b.name),
        faults: [a.faults.clone(), b.faults.clone()].concat(),
        react: [a.react.clone(), b.react.clone()].concat(),
        observable: condition,
        ..strong.clone()
    }
}
