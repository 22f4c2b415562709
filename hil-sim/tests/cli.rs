//! The command line as its user meets it: exit codes, what is printed where, and which files appear.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;
use tempfile::{TempDir, tempdir};

const SHIPPED: [&str; 6] =
    ["paper", "velocity-mismatch", "payload", "coarse-encoders", "noisy-bus", "stuck-encoder"];

/// A short lift whose limits are set by the test.
const SHORT: &str = "summary = \"a short lift\"\nduration_s = 1\nsettle_s = 0.1\n\
    [trajectory]\nprofile = \"quintic\"\namplitude = [0, 0, 0.01, -0.02]\n";

/// Exit code, standard output and standard error.
struct Answer {
    code: Option<i32>,
    out: String,
    err: String,
}

/// Runs the program with `folder` as its working directory.
fn hil_sim(folder: &Path, arguments: &[&str]) -> Answer {
    let output = Command::cargo_bin("hil-sim")
        .expect("cargo builds the program before its tests")
        .args(arguments)
        .current_dir(folder)
        .output()
        .expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    Answer { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
}

fn folder() -> TempDir {
    tempdir().expect("a temporary folder")
}

fn names_in(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder");
    let name = |entry: std::io::Result<fs::DirEntry>| {
        entry.expect("an entry").file_name().into_string().expect("UTF-8")
    };
    let mut names: Vec<String> = entries.map(name).collect();
    names.sort();
    names
}

/// A folder with `short.toml`, its limit on the mean error as given.
fn folder_with_short(rse_m: &str) -> TempDir {
    let folder = folder();
    let text = format!("{SHORT}[accept.backstepping-inertia]\nrse_m = {rse_m}\n");
    fs::write(folder.path().join("short.toml"), text).expect("a writable folder");
    folder
}

#[test]
fn run_prints_one_json_object_with_the_agreed_keys() {
    const KEYS: [&str; 14] = [
        "scenario",
        "law",
        "adaptation",
        "tick_hz",
        "seed",
        "ticks",
        "rms_m",
        "rse_m",
        "rho_s",
        "e_max_m",
        "v_max_m_s",
        "mode",
        "faults",
        "realtime_factor",
    ];
    let folder = folder();
    let answer = hil_sim(folder.path(), &["run", "paper", "--no-output", "--json"]);
    assert_eq!((answer.code, answer.err.as_str()), (Some(0), ""));
    assert_eq!(answer.out.trim_end().lines().count(), 1, "{}", answer.out);
    let value: Value = serde_json::from_str(&answer.out).expect("JSON");
    let object = value.as_object().expect("an object");
    let mut keys: Vec<&str> = object.keys().map(String::as_str).collect();
    keys.retain(|key| *key != "broken_limits");
    let mut expected = KEYS.to_vec();
    expected.sort_unstable();
    keys.sort_unstable();
    assert_eq!(keys, expected);
    assert_eq!(value["scenario"], "paper");
    assert_eq!((&value["law"], &value["adaptation"]), (&"backstepping".into(), &"inertia".into()));
    assert_eq!((value["tick_hz"].as_u64(), value["seed"].as_u64()), (Some(2000), Some(1)));
    assert_eq!(value["rms_m"].as_array().map(Vec::len), Some(3));
    assert_eq!(value["faults"], Value::Array(Vec::new()));
    assert!(value["rse_m"].as_f64().expect("a number") < 2.7e-7);
    assert_eq!(names_in(folder.path()), Vec::<String>::new());
}

#[test]
fn options_reach_the_run() {
    let folder = folder_with_short("1");
    let arguments = ["run", "short.toml", "--no-output", "--json", "--law", "pd"];
    let more = ["--tick-hz", "1000", "--seed", "5"];
    let answer = hil_sim(folder.path(), &[&arguments[..], &more[..]].concat());
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    let value: Value = serde_json::from_str(&answer.out).expect("JSON");
    assert_eq!((&value["law"], &value["adaptation"]), (&"pd".into(), &"none".into()));
    assert_eq!((value["tick_hz"].as_u64(), value["seed"].as_u64()), (Some(1000), Some(5)));
}

#[test]
fn run_writes_its_folder_and_no_output_writes_nothing() {
    let files = ["log.csv", "report.html", "summary.json"];
    let folder = folder_with_short("1");
    let answer = hil_sim(folder.path(), &["run", "short.toml", "--out", "here/and/there"]);
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    let out = folder.path().join("here/and/there");
    assert_eq!(names_in(&out), files);
    assert!(answer.out.contains("here/and/there/report.html"), "{}", answer.out);
    let summary = fs::read_to_string(out.join("summary.json")).expect("a summary");
    let summary: Value = serde_json::from_str(&summary).expect("JSON");
    assert_eq!(summary["scenario"], "short");

    let answer = hil_sim(folder.path(), &["run", "short.toml"]);
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    assert_eq!(names_in(&folder.path().join("out/short")), files);

    let bare = folder_with_short("1");
    let answer = hil_sim(bare.path(), &["run", "short.toml", "--no-output"]);
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    assert_eq!(names_in(bare.path()), ["short.toml"]);
}

#[test]
fn a_fault_leaves_its_evidence_beside_the_log() {
    let folder = folder();
    let answer = hil_sim(folder.path(), &["run", "stuck-encoder", "--out", "stop"]);
    assert_eq!(answer.code, Some(0), "{}{}", answer.out, answer.err);
    assert!(answer.out.contains("Evidence: stop/evidence.csv"), "{}", answer.out);
    let out = folder.path().join("stop");
    let files = ["evidence.csv", "evidence.json", "log.csv", "report.html", "summary.json"];
    assert_eq!(names_in(&out), files);
    let text = fs::read_to_string(out.join("evidence.json")).expect("errors");
    let summary: Value = serde_json::from_str(&text).expect("JSON");
    let error = &summary["errors"][0];
    assert_eq!((&error["fault"], &error["joints"]), (&"EncoderStuck".into(), &[3].into()));
    assert_eq!(error["tick"], summary["trigger_tick"]);
    // The ring at full rate is the log's last 64 rows up to the trigger.
    let [evidence, log] = ["evidence.csv", "log.csv"].map(|name| {
        let mut reader = csv::Reader::from_path(out.join(name)).expect("a table");
        let place = |column: &str| {
            reader.headers().expect("a header").iter().position(|h| h == column).expect("a column")
        };
        let places = ["tick", "mode", "encoder4_count"].map(place);
        let rows = reader.records().map(|row| row.expect("a row"));
        rows.map(|row| {
            let ring = row[0].to_owned();
            (ring, places.map(|at| row[at].parse::<f64>().expect("a number")))
        })
        .collect::<Vec<_>>()
    });
    let full: Vec<_> = evidence.iter().filter(|row| row.0 == "full").map(|row| row.1).collect();
    let trigger = error["tick"].as_f64().expect("a tick");
    let judged: Vec<_> = log.iter().map(|row| row.1).filter(|row| row[0] < trigger).collect();
    assert_eq!((full.len(), full[63][0]), (64, trigger));
    assert_eq!(full[..63], judged[judged.len() - 63..]);
    // 2 s at 50 Hz, the last of them from the time of the stop.
    let thin: Vec<_> = evidence.iter().filter(|row| row.0 == "thin").map(|row| row.1[0]).collect();
    assert_eq!((thin.len(), thin[99] - thin[0]), (100, 99.0 * 40.0));
    assert!(thin[99] > trigger);
}

#[test]
fn a_broken_limit_is_named_and_ends_with_1() {
    let folder = folder_with_short("1e-9");
    let answer = hil_sim(folder.path(), &["run", "short.toml", "--no-output"]);
    assert_eq!(answer.code, Some(1), "{}", answer.err);
    assert!(answer.out.contains("LIMIT"), "{}", answer.out);
    assert!(answer.out.contains("is above its limit of 1.000e-9 m"), "{}", answer.out);
    let answer = hil_sim(folder.path(), &["run", "short.toml", "--no-output", "--json"]);
    assert_eq!(answer.code, Some(1), "{}", answer.err);
    let value: Value = serde_json::from_str(&answer.out).expect("JSON");
    assert_eq!(value["broken_limits"].as_array().map(Vec::len), Some(1));
}

#[test]
fn bad_input_ends_with_2_and_says_what_is_allowed() {
    let bad: [(&[&str], &[&str]); 12] = [
        (&["run", "papre"], &["`papre`", "did you mean `paper`", "payload"]),
        (&["run", "none.toml"], &["none.toml", "shipped scenarios"]),
        (&["run", "paper", "--tick-hz", "500"], &["500", "1000", "8000", "limit cycle"]),
        (&["run", "paper", "--tick-hz", "2k"], &["2k", "1000", "8000"]),
        (&["run", "paper", "--seed", "-1"], &["-1"]),
        (&["run", "paper", "--law", "pid"], &["pid", "backstepping", "pd"]),
        (
            &["run", "paper", "--law", "pd", "--adaptation", "paper"],
            &["--adaptation", "--law backstepping"],
        ),
        (&["run", "paper", "--out", "x", "--no-output"], &["--out", "--no-output"]),
        (&["run"], &["<SCENARIO>"]),
        (&["model", "--q", "1,2,3"], &["exactly 4 numbers, got 3"]),
        (&["model", "--q", "1,2,x,4"], &["joint 3", "`x`", "not a finite number"]),
        (&["model", "--q", "1,2,nan,4"], &["joint 3", "`nan`", "not a finite number"]),
    ];
    let folder = folder();
    for (arguments, parts) in bad {
        let answer = hil_sim(folder.path(), arguments);
        assert_eq!((answer.code, answer.out.as_str()), (Some(2), ""), "{arguments:?}");
        // A narrow terminal breaks lines.
        let err = answer.err.split_whitespace().collect::<Vec<_>>().join(" ");
        for part in parts {
            assert!(err.contains(part), "{arguments:?} does not say {part:?}: {err}");
        }
    }
    assert_eq!(names_in(folder.path()), Vec::<String>::new());
}

#[test]
fn list_prints_each_scenario_on_its_line() {
    let answer = hil_sim(folder().path(), &["list"]);
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    let lines: Vec<&str> = answer.out.lines().collect();
    assert_eq!(lines.len(), SHIPPED.len());
    for (line, name) in lines.iter().zip(SHIPPED) {
        let (first, summary) = line.trim().split_once(' ').expect("a name and a summary");
        assert_eq!(first, name);
        assert!(summary.trim().len() > 20, "{line}");
    }
}

#[test]
fn model_prints_both_sides_and_they_agree() {
    let lengths = [
        ("position_m", 3),
        ("rotation", 9),
        ("inertia", 16),
        ("coriolis", 4),
        ("gravity", 4),
        ("torque", 4),
    ];
    let state = ["--q", "0.2,1.1,-0.1,4.0", "--qd", "-0.1,0.2,-0.3,0.4", "--qdd", "0.5,0,-1,1"];
    let answer = hil_sim(folder().path(), &[&["model", "--json"], &state[..]].concat());
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    let value: Value = serde_json::from_str(&answer.out).expect("JSON");
    assert_eq!(value.as_object().map(serde_json::Map::len), Some(2));
    for side in ["firmware", "plant"] {
        assert_eq!(value[side].as_object().map(serde_json::Map::len), Some(lengths.len()));
    }
    for (key, length) in lengths {
        let numbers = |side: &str| -> Vec<f64> {
            let list = value[side][key].as_array().expect(key);
            list.iter().map(|number| number.as_f64().expect(key)).collect()
        };
        let (firmware, plant) = (numbers("firmware"), numbers("plant"));
        assert_eq!((firmware.len(), plant.len()), (length, length), "{key}");
        let largest = plant.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert!(largest > 0.0, "{key}");
        for (f, p) in firmware.iter().zip(&plant) {
            assert!((f - p).abs() < 1e-5 * largest, "{key}: {f} and {p}");
        }
    }
    let table = hil_sim(folder().path(), &["model", "--q", "0.2,1.1,-0.1,4.0"]);
    assert_eq!(table.code, Some(0), "{}", table.err);
    assert!(table.out.contains("firmware (f32)") && table.out.contains("plant (f64)"));
}

/// A full disk must not look like a good run; the files are written before.
#[test]
#[cfg(target_os = "linux")]
fn json_that_cannot_be_written_is_an_error() {
    let folder = folder();
    fs::write(folder.path().join("short.toml"), SHORT).expect("a scenario");
    for arguments in
        [&["model", "--q", "0,1,-1,3", "--json"] as &[&str], &["run", "short.toml", "--json"]]
    {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("the full device");
        let output = std::process::Command::new(env!("CARGO_BIN_EXE_hil-sim"))
            .args(arguments)
            .current_dir(folder.path())
            .stdout(full)
            .output()
            .expect("the program starts");
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
        assert!(told.contains("standard output"), "{told}");
    }
    assert!(folder.path().join("out/short/report.html").exists());
}

#[test]
fn no_arguments_print_table_3_and_name_the_report() {
    let folder = folder();
    let answer = hil_sim(folder.path(), &[]);
    assert_eq!(answer.code, Some(0), "{}{}", answer.out, answer.err);
    for part in ["inertia-weighted", "paper's psi", "PD (Eq 29)", "RSE, m", "ρ, s"] {
        assert!(answer.out.contains(part), "{part} is missing: {}", answer.out);
    }
    let report = answer.out.lines().find_map(|line| line.strip_prefix("Report: "));
    let page = fs::read_to_string(folder.path().join(report.expect("a line with the report")));
    assert!(page.expect("the report named").contains("Table 3"));
}
