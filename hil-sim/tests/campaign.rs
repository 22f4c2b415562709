//! The fault campaign as its user meets it.

use assert_cmd::Command;
use serde_json::Value;
use tempfile::tempdir;

/// Exit code, standard output, standard error, and whether the report appeared.
fn faults(arguments: &[&str]) -> (Option<i32>, String, String, bool) {
    let folder = tempdir().expect("a temporary folder");
    let output = Command::cargo_bin("hil-sim")
        .expect("cargo builds the program before its tests")
        .arg("faults")
        .args(arguments)
        .current_dir(folder.path())
        .output()
        .expect("the program starts");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    // Named after the row, which `--only` gives.
    let report = folder.path().join(format!("out/faults-{}/report.html", arguments[1])).exists();
    (output.status.code(), text(output.stdout), text(output.stderr), report)
}

fn is_count(value: &Value) -> bool {
    value.is_null() || value.is_u64()
}

#[test]
fn json_has_these_keys_and_nothing_else() {
    let (code, out, err, report) = faults(&["--only", "22", "--json"]);
    assert_eq!((code, err.as_str(), report), (Some(0), "", true));
    let all: Value = serde_json::from_str(&out).expect("nothing but JSON");
    assert_eq!(keys(&all), ["passed", "rows", "total"]);
    let rows = all["rows"].as_array().expect("a list");
    assert_eq!(all["total"], rows.len());
    assert_eq!(all["passed"], rows.iter().filter(|row| row["pass"] == true).count());
    let expected = [
        "bound_m",
        "detect_ticks",
        "drop_m",
        "fault",
        "pass",
        "pose",
        "react_ticks",
        "reaction",
        "twin_tripped",
    ];
    for row in rows {
        assert_eq!(keys(row), expected);
        assert_eq!(row["fault"], 22);
        assert!(["rest", "lifting", "lowering", "reach"].contains(&row["pose"].as_str().unwrap()));
        assert!(row["reaction"].is_string() && row["drop_m"].is_f64() && row["bound_m"].is_f64());
        assert!(is_count(&row["detect_ticks"]) && is_count(&row["react_ticks"]));
        assert!(row["twin_tripped"].is_boolean() && row["pass"].is_boolean());
    }
}

/// Sorted.
fn keys(value: &Value) -> Vec<&str> {
    let mut keys =
        value.as_object().expect("an object").keys().map(String::as_str).collect::<Vec<_>>();
    keys.sort_unstable();
    keys
}

#[test]
fn table_names_row_pose_and_seed() {
    let (code, out, _, report) = faults(&["--only", "17", "--seed", "5"]);
    assert_eq!((code, report), (Some(0), true), "{out}");
    for part in
        ["late ticks: three of 1.2 ticks", "lowering", "SS1, TickLate", "(seed 5)", "Report: "]
    {
        assert!(out.contains(part), "{part} is not in\n{out}");
    }
}

#[test]
fn runs_repeat_with_their_seed() {
    let once = || faults(&["--only", "7", "--json"]).1;
    assert_eq!(once(), once());
}

#[test]
fn rows_that_are_none_are_refused_with_the_range() {
    for bad in ["0", "28", "-1", "nine", "1.5"] {
        let (code, out, err, report) = faults(&["--only", bad]);
        assert_eq!((code, out.as_str(), report), (Some(2), "", false), "{bad}");
        assert!(err.contains("1 to 27"), "{bad}: {err}");
    }
}
