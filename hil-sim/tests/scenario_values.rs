//! Good scenarios: defaults, every key in its field, and every range up to its ends and no further.

use hil_sim::scenario::bounds::{ALL, Bounds, Kind};
use hil_sim::scenario::{Scenario, ScenarioError};

const SHIPPED: [&str; 6] =
    ["paper", "velocity-mismatch", "payload", "coarse-encoders", "noisy-bus", "stuck-encoder"];

/// A minimal scenario with lines before and after its trajectory's table.
fn with(top: &str, end: &str) -> String {
    let trajectory = "[trajectory]\nprofile = \"quintic\"\namplitude = [0, 0, 0.2, -0.5]";
    format!("summary = \"a test\"\n{top}\n{trajectory}\n{end}\n")
}

/// A scenario in which one key has a given value.
fn setting(bounds: &Bounds, value: f64) -> String {
    let number = match bounds.kind {
        Kind::Whole => format!("{value:.0}"),
        Kind::Real => format!("{value:?}"),
        Kind::Four => format!("[{:?}, {:?}, {value:?}, {:?}]", bounds.lo, bounds.hi, bounds.lo),
    };
    let companion = match bounds.key {
        "duration_s" => "",
        "plant.payload.kg" => "duration_s = 60\nplant.payload.at_s = 60",
        "plant.payload.at_s" => "duration_s = 60\nplant.payload.kg = 300",
        _ => "duration_s = 60",
    };
    match bounds.key.strip_prefix("fault.") {
        Some("at_s") => with(companion, &format!("[[fault]]\nkind = \"hang\"\nat_s = {number}")),
        Some(key) => with("", &format!("[[fault]]\nkind = \"hang\"\nat_s = 0\n{key} = {number}")),
        None => with(&format!("{companion}\n{} = {number}", key(bounds)), ""),
    }
}

fn key(bounds: &Bounds) -> String {
    bounds.key.replace('*', "pd")
}

#[test]
fn each_range_includes_its_ends_and_nothing_beyond() {
    for bounds in ALL {
        let beyond = match bounds.kind {
            Kind::Whole => [bounds.lo - 1.0, bounds.hi + 1.0],
            Kind::Real | Kind::Four => [bounds.lo.next_down(), bounds.hi.next_up()],
        };
        for inside in [bounds.lo, bounds.hi] {
            let scenario = Scenario::parse("in.toml", &setting(bounds, inside));
            assert!(scenario.is_ok(), "{} = {inside}: {scenario:?}", bounds.key);
        }
        for outside in beyond {
            let error =
                Scenario::parse("out.toml", &setting(bounds, outside)).expect_err(bounds.key);
            let ScenarioError::Invalid(error) = error else { panic!("{}: {error}", bounds.key) };
            assert!(error.message.contains(&key(bounds)), "{}", error.message);
            assert_eq!(error.label, format!("allowed: {bounds}"));
        }
    }
}

#[test]
fn each_shipped_file_is_listed_and_loads_by_name_and_by_path() {
    let files = std::fs::read_dir("scenarios").expect("the directory is there").count();
    let listed = Scenario::shipped().map(|(name, _)| name).collect::<Vec<_>>();
    assert_eq!(listed, SHIPPED);
    assert_eq!(files, SHIPPED.len());
    for name in SHIPPED {
        let by_name = Scenario::load(name).expect(name);
        let by_path = Scenario::load(&format!("scenarios/{name}.toml")).expect(name);
        assert_eq!(by_name, by_path);
        assert_eq!(by_name.name, name);
    }
}

#[test]
fn absent_keys_take_their_defaults() {
    insta::assert_debug_snapshot!(Scenario::load("paper").expect("it is shipped"));
}

#[test]
fn given_keys_reach_their_fields() {
    let text = with(
        "tick_hz = 4000\nseed = 11\nduration_s = 12\nsettle_s = 1.5",
        r#"
        q0 = [0.1, 1.0, -0.2, 4.0]
        allow_velocity_step = true
        [model]
        mass_scale = 1.1
        payload_kg = 20
        [plant]
        payload_kg = 25
        payload = { kg = 30, at_s = 4 }
        friction = [1, 2, 3, 4]
        disturbance = "each-tick"
        substeps = 5
        [encoders]
        rotary_bits = 21
        linear_lsb_m = 2e-7
        skew_s = 3e-6
        [controller]
        law = "pd"
        adaptation = "paper"
        k1 = 101
        k2 = 102
        kp = 103
        kd = 104
        wa = 105
        psi = [106, 107, 108, 109]
        [accept.backstepping-inertia]
        rse_m = 1e-7
        [accept.backstepping-paper]
        e_max_m = 2e-7
        [accept.backstepping-none]
        rho_s = 3e-7
        [accept.pd]
        rms_m = 4e-7
        [[fault]]
        kind = "jump"
        target = "encoder4"
        at_s = -0.5
        for_s = 0.25
        severity = -2e-3
        [[fault]]
        kind = "config-flip"
        [expect]
        fault = "EncoderImplausible"
        "#,
    );
    insta::assert_debug_snapshot!(
        Scenario::parse("dir/full.toml", &text).expect("all is in range")
    );
}
