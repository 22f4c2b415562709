//! Cells of the fault campaign on the emulated board: bit for bit as in software, and in the fault that they are about.

use hil_sim::campaign;
use hil_sim::pil;
use tests::board;

const SEED: u64 = 1;

/// Row, pose, beginning of the way's name, fault in which the run ends.
const CELLS: [(u8, &str, &str, &[&str]); 8] = [
    (1, "lifting", "ADC: 1 bit, lasting", &["TorqueAdcLost"]),
    (2, "reach", "encoder 3: 3 in a row", &["EncoderLost"]),
    (6, "lowering", "encoder 2", &["EncoderStuck"]),
    (12, "lifting", "joint 2", &["DriveLost"]),
    (17, "lowering", "three of 1.2 ticks", &["TickLate"]),
    (20, "lifting", "joint 2: speed is no number", &["NotFinite"]),
    (24, "reach", "gain, bit 40", &["ParameterFlipped"]),
    (27, "lifting", "DAC", &["DacReset"]),
];

#[test]
fn cells_agree_bit_for_bit_on_the_emulated_board() {
    let image = board::open("mps2-an386");
    for (row, pose, way, faults) in CELLS {
        let ways = campaign::scenarios(row, pose, SEED).expect("good poses");
        let (name, scenario) =
            ways.iter().find(|(name, _)| name.starts_with(way)).expect("a way of that name");
        let verdict = pil::run(scenario, &image.path, &|_, _| ()).expect("a comparison");
        assert!(verdict.difference.is_none(), "row {row}, {name}: {:?}", verdict.difference);
        assert_eq!(verdict.outcome.faults, faults, "row {row}, {name}");
    }
}
