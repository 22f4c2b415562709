//! Rows 1 to 5: faults of the bus.

use shared::fault::Fault;

use super::Ways;
use crate::campaign::onset::Condition;
use crate::campaign::pose::Pose;
use crate::campaign::row::{Acting, Drop, Expect, POWER_UP, Sign, Variant, fault};
use crate::campaign::witness::{ADC, DAC};
use crate::faults::{Injection, Kind, Target};

pub const LOST: Sign = Sign::Fault(&[Fault::EncoderLost]);
pub const ADC_LOST: Sign = Sign::Fault(&[Fault::TorqueAdcLost]);
const NOT_WRITTEN: Sign = Sign::Fault(&[Fault::DacNotAcknowledged]);

/// Losses that last: rejected from the first on, and a stop once the bucket is full. A DAC that cannot be written is
/// row 5's: it cannot stop along the path.
fn lasting(name: &str, injection: Injection) -> Variant {
    let device = index(injection.target);
    let plain = Variant::new(name, vec![injection], Expect::Ss1, Sign::Rejected(device), 1, 3);
    if device == DAC {
        let plain = Variant { expect: Expect::Sto, ..plain };
        return plain.due(Condition::After(2)).dropping(Drop::Bound(Acting::Held));
    }
    let two = injection.ticks(2);
    plain.due(Condition::BucketFull(device)).twin(vec![two])
}

/// So few that the bucket takes them.
fn few(name: &str, injection: Injection) -> Variant {
    let sign = Sign::Rejected(index(injection.target));
    Variant::tolerated(name, vec![injection], sign, 1)
}

/// Index among the devices of what is hit first.
pub fn index(target: Target) -> usize {
    match target {
        Target::Encoder(j) => j,
        Target::Adc => ADC,
        Target::Dac => DAC,
        _ => 0,
    }
}

/// Check sums of 6, 16 and 8 bits.
const DEVICES: [(Target, &str, f64); 3] =
    [(Target::Encoder(1), "encoder 2", 6.0), (Target::Adc, "ADC", 16.0), (Target::Dac, "DAC", 8.0)];

pub fn flips(_: &Pose) -> Ways {
    let mut ways = Vec::new();
    for (target, name, crc_bits) in DEVICES {
        let flips = |bits| fault(Kind::BitFlips, target).of(bits);
        let burst = fault(Kind::Burst, target).of(crc_bits);
        let fitting = fault(Kind::Mutation, target).of(1.0);
        ways.extend([
            few(&format!("{name}: 1 bit, one tick"), flips(1.0).ticks(1)),
            few(&format!("{name}: 2 bits, two ticks"), flips(2.0).ticks(2)),
            few(&format!("{name}: burst of {crc_bits}"), burst.ticks(1)),
            lasting(&format!("{name}: 1 bit, lasting"), flips(1.0)),
        ]);
        let passes = format!("{name}: contents with a fitting check sum");
        ways.push(match target {
            Target::Dac => lasting(&passes, fitting),
            _ => Variant::new(
                passes,
                vec![fitting],
                Expect::Ss1OrNone,
                Sign::Nothing,
                0,
                u32::MAX / 2,
            ),
        });
        if let Target::Encoder(j) = target {
            let once = few(&format!("{name}: fitting check sum, one tick"), fitting.ticks(1));
            ways.push(Variant { sign: Sign::Rejected(j), ..once });
        }
    }
    Ok(ways)
}

pub fn losses(_: &Pose) -> Ways {
    let lost = |target, share| fault(Kind::FrameLoss, target).of(share);
    let encoder = Target::Encoder(2);
    let mut ways = vec![
        few("encoder 3: 1", lost(encoder, 1.0).ticks(1)),
        few("encoder 3: 2 in a row", lost(encoder, 1.0).ticks(2)),
        few("ADC: 2 in a row", lost(Target::Adc, 1.0).ticks(2)),
        few("DAC: 2 in a row", lost(Target::Dac, 1.0).ticks(2)),
        lasting("encoder 3: 3 in a row", lost(encoder, 1.0).ticks(3)),
        lasting("encoder 3: 10 in a row", lost(encoder, 1.0).ticks(10)),
        lasting("ADC: 3 in a row", lost(Target::Adc, 1.0).ticks(3)),
        lasting("DAC: 3 in a row", lost(Target::Dac, 1.0).ticks(3)),
    ];
    for (target, share) in [(encoder, 0.1), (encoder, 0.3), (Target::Adc, 0.3)] {
        let name = format!("{target}: {} % random", share * 100.0);
        let random = lasting(&name, lost(target, share));
        // The first loss comes when it comes.
        ways.push(Variant { sign: Sign::Nothing, twin: Vec::new(), ..random });
    }
    let rare = Injection { for_s: Some(10.0), ..lost(Target::All, 1e-3) };
    let rare = Variant::harmless("everything: 0.1 % random over 10 s, 20 seeds", vec![rare]);
    ways.push(Variant { runs: 20, path_s: Some(10.0), ..rare });
    Ok(ways)
}

pub fn repeats(pose: &Pose) -> Ways {
    let adc = fault(Kind::Repeat, Target::Adc);
    let adc = Variant::new("ADC", vec![adc], Expect::Ss1, Sign::Rejected(ADC), 1, 3);
    // Twice identical: the second repetition is the first that counts.
    let adc = Variant { observable: Condition::After(1), ..adc.due(Condition::After(3)) };
    let adc = adc.twin(vec![fault(Kind::Repeat, Target::Adc).ticks(2)]);
    let mut ways = vec![adc];
    for j in [0, 1, 3] {
        let again = fault(Kind::Repeat, Target::Encoder(j));
        ways.push(repeated_encoder(pose, j, again));
    }
    Ok(ways)
}

fn repeated_encoder(pose: &Pose, j: usize, again: Injection) -> Variant {
    let name = format!("encoder {}", j + 1);
    if pose.moves() {
        let plain = Variant::new(name, vec![again], Expect::Ss1, Sign::Rejected(j), 1, 3);
        Variant { observable: Condition::Still(j, 0), ..plain.due(Condition::Still(j, 2)) }
    } else {
        Variant::harmless(name, vec![again]).or_stopped()
    }
}

pub fn swaps(pose: &Pose) -> Ways {
    let swap = |j, other| fault(Kind::Swap, Target::Encoder(j)).of(other);
    let way = |j: usize, other: usize, fault, seen| {
        let name = format!("encoders {} and {other}", j + 1);
        let swapped = vec![swap(j, other as f64)];
        let way = Variant::new(name, swapped, Expect::Ss1, Sign::Fault(fault), 1, 2);
        way.from(seen).twin(vec![swap(j, other as f64).ticks(1)])
    };
    let running = [(0, 2), (1, 3), (0, 3)];
    let running =
        running.map(|(j, other)| way(j, other, &[Fault::EncodersSwapped], Condition::After(1)));
    let mut ways = Vec::from(running);
    // A frame of the scale has another length: its CRC is wrong at the other's place, and the other way round.
    let lost = (0..3).map(|j| way(j, 4, &[Fault::EncoderLost], Condition::BucketFull(j)));
    ways.extend(lost);
    let boot = swap(0, 2.0).at(POWER_UP);
    let boot = Variant::new(
        "encoders 1 and 2 from power-up",
        vec![boot],
        Expect::NoArm,
        Sign::Nothing,
        0,
        0,
    );
    ways.extend(super::parked(pose, vec![boot]).unwrap_or_default());
    Ok(ways)
}

pub fn dead(_: &Pose) -> Ways {
    let mut ways = Vec::new();
    for (severity, how) in [(0.0, "zeros"), (1.0, "ones"), (2.0, "bus error")] {
        let dead = |target| vec![fault(Kind::Dead, target).of(severity)];
        ways.extend([
            Variant::new(
                format!("encoders: {how}"),
                dead(Target::Encoders),
                Expect::Ss1,
                LOST,
                3,
                5,
            ),
            Variant::new(format!("ADC: {how}"), dead(Target::Adc), Expect::Ss1, ADC_LOST, 3, 5),
            Variant::new(format!("DAC: {how}"), dead(Target::Dac), Expect::Sto, NOT_WRITTEN, 3, 5)
                .dropping(Drop::Bound(Acting::Held)),
        ]);
    }
    let all = vec![fault(Kind::Dead, Target::All).of(2.0)];
    let all = Variant::new("everything: bus error", all, Expect::Sto, NOT_WRITTEN, 3, 5);
    ways.push(all.dropping(Drop::Bound(Acting::Held)));
    Ok(ways)
}
