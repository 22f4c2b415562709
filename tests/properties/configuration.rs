//! Every number of the configuration is refused by name when it is no number or out of range.

use std::collections::HashSet;

use firmware::config::{Body, Config, ConfigError, Law};
use shared::arm::JOINTS;

type Set = fn(&mut Config, usize, f32);

/// Consecutive numbers of the configuration: their name in the error, how many, how to set one, and values
/// just below and above what is allowed; with a positive quantity the lower one has the wrong sign.
struct Field {
    name: &'static str,
    count: usize,
    set: Set,
    wrong: [f32; 2],
}

const fn field(name: &'static str, count: usize, wrong: [f32; 2], set: Set) -> Field {
    Field { name, count, set, wrong }
}

/// Link 0 to 3, payload 4.
fn body(config: &mut Config, index: usize) -> &mut Body {
    if index < JOINTS { &mut config.arm.links[index] } else { &mut config.arm.payload }
}

const BODIES: usize = JOINTS + 1;
const HUGE: f32 = 1e13;

#[rustfmt::skip]
const FIELDS: [Field; 60] = [
    field("tick_hz", 1, [999.0, 8_001.0], |c, _, v| c.tick_hz = v as u32),
    field("geometry_m", 1, [-20.1, 20.1], |c, _, v| c.arm.geometry.a1_m = v),
    field("geometry_m", 1, [-20.1, 20.1], |c, _, v| c.arm.geometry.a2_m = v),
    field("geometry_m", 1, [-20.1, 20.1], |c, _, v| c.arm.geometry.a3_m = v),
    field("geometry_m", 1, [-20.1, 20.1], |c, _, v| c.arm.geometry.d1_m = v),
    field("geometry_m", 1, [-20.1, 20.1], |c, _, v| c.arm.geometry.d3_m = v),
    field("gravity_m_s2", 1, [-9.81, 20.1], |c, _, v| c.arm.gravity_m_s2 = v),
    field("links.mass_kg", JOINTS, [-900.0, 20_001.0], |c, i, v| c.arm.links[i].mass_kg = v),
    field("payload.mass_kg", 1, [-1.0, 5_001.0], |c, _, v| c.arm.payload.mass_kg = v),
    field("com_m", 3 * BODIES, [-20.1, 20.1], |c, i, v| body(c, i / 3).com_m[i % 3] = v),
    field("inertia_com_kg_m2 moments", 3 * BODIES, [-1.0, 1.1e6],
        |c, i, v| body(c, i / 3).inertia_com_kg_m2[i % 3] = v),
    field("inertia_com_kg_m2 products", 3 * BODIES, [-1.1e6, 1.1e6],
        |c, i, v| body(c, i / 3).inertia_com_kg_m2[3 + i % 3] = v),
    field("q_min", JOINTS, [-60.1, 60.1], |c, i, v| c.joints[i].q_min = v),
    field("q_max", JOINTS, [-59.0, 60.1], |c, i, v| c.joints[i].q_max = v),
    field("qd_max", JOINTS, [-0.5, 10.1], |c, i, v| c.joints[i].qd_max = v),
    field("tau_max", JOINTS, [-100.0, 1.1e6], |c, i, v| c.joints[i].tau_max = v),
    field("encoder_bits", JOINTS, [11.0, 33.0], |c, i, v| c.joints[i].encoder_bits = v as u32),
    field("encoder_lsb", JOINTS, [-1e-7, 1.1e-3], |c, i, v| c.joints[i].encoder_lsb = v),
    field("encoder_zero", JOINTS, [-70.0, 60.0], |c, i, v| c.joints[i].encoder_zero = v),
    field("latch_offset_s", JOINTS, [-1e-6, 2.6e-4], |c, i, v| c.joints[i].latch_offset_s = v),
    field("drive_full_scale", JOINTS, [-1e5, 2.1e6], |c, i, v| c.joints[i].drive_full_scale = v),
    field("torque_full_scale", JOINTS, [-1e5, 2.1e6], |c, i, v| c.joints[i].torque_full_scale = v),
    // What is no number of a law becomes one that no law has.
    field("law", 1, [4.0, 5.0],
        |c, _, v| c.gains.law = Law(if v >= 0.0 { v as u32 } else { u32::MAX })),
    field("k1", JOINTS, [-200.0, 1_001.0], |c, i, v| c.gains.k1[i] = v),
    field("k2", JOINTS, [-200.0, 1_001.0], |c, i, v| c.gains.k2[i] = v),
    field("wa_rad_s", 1, [-100.0, 201.0], |c, _, v| c.gains.wa_rad_s = v),
    field("psi", JOINTS, [-1e9, 1.1e12], |c, i, v| c.gains.psi[i] = v),
    field("d_max", JOINTS, [-1.0, 1.1e6], |c, i, v| c.gains.d_max[i] = v),
    field("kp", JOINTS, [-9_000.0, 1.1e6], |c, i, v| c.gains.kp[i] = v),
    field("kd", JOINTS, [-80.0, 1_001.0], |c, i, v| c.gains.kd[i] = v),
    field("observer_rad_s", 1, [-2_400.0, 6_001.0], |c, _, v| c.gains.observer_rad_s = v),
    field("stop_s", 1, [0.04, 1.1], |c, _, v| c.safety.stop_s = v),
    field("preload_s", 1, [0.004, 1.1], |c, _, v| c.safety.preload_s = v),
    field("brake_open_s", 1, [0.01, 5.1], |c, _, v| c.safety.brake_open_s = v),
    field("brake_set_s", 1, [0.01, 5.1], |c, _, v| c.safety.brake_set_s = v),
    field("torque_tail_s", 1, [-0.05, 1.1], |c, _, v| c.safety.torque_tail_s = v),
    field("test_move_s", 1, [0.04, 5.1], |c, _, v| c.safety.test_move_s = v),
    field("test_move", JOINTS, [9e-6, 1.1e-2], |c, i, v| c.safety.test_move[i] = v),
    field("link_timeout_s", 1, [0.01, 10.1], |c, _, v| c.safety.link_timeout_s = v),
    field("jog_timeout_s", 1, [0.01, 1.1], |c, _, v| c.safety.jog_timeout_s = v),
    field("rest_pose", JOINTS - 1, [-60.1, 60.1], |c, i, v| c.safety.rest_pose[i] = v),
    field("lowering_share", 1, [0.009, 0.51], |c, _, v| c.safety.lowering_share = v),
    field("rated_payload_kg", 1, [-1.0, 5_001.0], |c, _, v| c.safety.rated_payload_kg = v),
    field("torque_reserve", 1, [0.09, 1.1], |c, _, v| c.safety.torque_reserve = v),
    field("parked_tolerance", 1, [9e-4, 1.1], |c, _, v| c.safety.parked_tolerance = v),
    field("unforeseen", JOINTS, [0.09, 1_001.0], |c, i, v| c.safety.unforeseen[i] = v),
    field("violent", JOINTS, [0.9, 1.1e4], |c, i, v| c.safety.violent[i] = v),
    field("torque_warn", JOINTS, [0.9, 1.1e6], |c, i, v| c.safety.torque_warn[i] = v),
    field("torque_wrong", JOINTS, [0.9, 1.1e6], |c, i, v| c.safety.torque_wrong[i] = v),
    field("speed_error", JOINTS, [9e-5, 10.1], |c, i, v| c.safety.speed_error[i] = v),
    field("swing", JOINTS, [9e-6, 10.1], |c, i, v| c.safety.swing[i] = v),
    field("tracking", JOINTS, [9e-6, 1.1], |c, i, v| c.safety.tracking[i] = v),
    field("tracking_s", 1, [0.004, 5.1], |c, _, v| c.safety.tracking_s = v),
    field("error_window", JOINTS, [9e-5, 1.1], |c, i, v| c.safety.error_window[i] = v),
    field("overspeed", 1, [0.9, 3.1], |c, _, v| c.safety.overspeed = v),
    field("overtravel", JOINTS, [-0.01, 1.1], |c, i, v| c.safety.overtravel[i] = v),
    field("slip", JOINTS, [9e-8, 1.1e-2], |c, i, v| c.safety.slip[i] = v),
    field("clock_hz", 1, [9e5, 1.1e9], |c, _, v| c.safety.clock_hz = v as u32),
    field("budget", 1, [0.04, 0.96], |c, _, v| c.safety.budget = v),
    field("conversions_hz", 1, [1_900.0, 1.1e6], |c, _, v| c.safety.conversions_hz = v),
];

/// Each number of the configuration with its field.
fn numbers() -> impl Iterator<Item = (&'static Field, usize)> {
    FIELDS.iter().flat_map(|field| (0..field.count).map(move |index| (field, index)))
}

fn with(field: &Field, index: usize, value: f32) -> Config {
    let mut config = Config::default();
    (field.set)(&mut config, index, value);
    config
}

#[test]
fn each_wrong_number_is_refused_by_its_name() {
    for (field, index) in numbers() {
        let [below, above] = field.wrong;
        // A whole number cannot be NaN or negative; the cast makes those 0, which is out of range too.
        for value in [f32::NAN, f32::NEG_INFINITY, f32::INFINITY, -HUGE, HUGE, below, above] {
            let error = with(field, index, value).validate().expect_err(field.name);
            assert!(error.to_string().starts_with(field.name), "{error}");
            let ConfigError::OutOfRange { field: name, value: found, min, max, .. } = error else {
                panic!("{value} at {index}: {error}");
            };
            assert_eq!(name.name(), field.name, "{value} at {index}: {error}");
            assert!(!(found >= min && found <= max), "{error}");
        }
    }
}

/// A new field has to be added to the table: it covers every word, and none twice.
#[test]
fn the_table_covers_the_whole_configuration() {
    let words = size_of::<Config>() / size_of::<f32>();
    assert_eq!(numbers().count(), words);
    let distinct: HashSet<String> =
        numbers().map(|(field, index)| format!("{:?}", with(field, index, 77.0))).collect();
    assert_eq!(distinct.len(), numbers().count());
}

#[test]
fn relations_between_numbers_are_kept() {
    let refused = |change: fn(&mut Config)| {
        let mut config = Config::default();
        change(&mut config);
        config.validate().expect_err("a broken relation").field()
    };
    assert_eq!(refused(|c| c.joints[1].q_max = c.joints[1].q_min - 0.1), "q_max");
    assert_eq!(refused(|c| c.joints[1].encoder_zero = c.joints[1].q_min + 0.1), "encoder_zero");
    assert_eq!(refused(|c| c.joints[3].encoder_lsb = 2e-9), "encoder_zero");
    assert_eq!(refused(|c| c.joints[2].tau_max = 1e5), "drive_full_scale");
    let fast = |c: &mut Config| (c.joints[0].qd_max, c.joints[0].encoder_lsb) = (9.0, 1e-7);
    assert_eq!(refused(fast), "qd_max against encoder_lsb");
}

#[test]
fn the_defaults_are_accepted_at_every_offered_rate() {
    for tick_hz in [1_000, 2_000, 4_000, 8_000] {
        let config = Config::for_arm(&shared::arm::REFERENCE, tick_hz);
        assert_eq!(config.validate(), Ok(()), "{tick_hz} Hz");
    }
}

#[test]
fn a_flipped_bit_anywhere_is_damage() {
    let config = Config::default();
    let crc = config.crc();
    assert_eq!(config.check(crc), Ok(()));
    for bit in 0..8 * size_of::<Config>() {
        let mut flipped = config;
        bytemuck::bytes_of_mut(&mut flipped)[bit / 8] ^= 1 << (bit % 8);
        assert_eq!(flipped.check(crc), Err(ConfigError::Damaged), "bit {bit}");
    }
}
