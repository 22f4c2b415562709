//! The run folder as its reader finds it: files, headers, figures, and what happens to broken input.

use std::fs;
use std::path::Path;

use hil_sim::outcome::{Adaptation, Law, Metrics, Outcome, TickRow};
use hil_sim::report;
use shared::arm::{JOINTS, Q0, REFERENCE};
use shared::telemetry::Record;

/// Title, panels, and strokes of the adaptive law and of the PD: one a panel and one in the legend.
const FIGURES: [(&str, usize, usize, usize); 9] = [
    ("Figure 1. The lift from the side", 1, 0, 0),
    ("Figure 2. Position errors", 4, 5, 5),
    ("Figure 3. Position tracking", 4, 5, 5),
    ("Figure 4. Velocity errors", 4, 5, 5),
    ("Figure 5. Velocity tracking", 4, 5, 5),
    ("Figure 6. End-point error", 4, 5, 5),
    ("Figure 7. Joint torques", 4, 5, 5),
    ("Figure 8. Disturbance and its estimate", 4, 5, 0),
    ("Figure 9. Lyapunov function", 2, 3, 3),
];

/// A ten-second lift at `tick_hz` whose errors have size `error` and whose torques are those at rest.
fn run(law: Law, adaptation: Adaptation, error: f64, tick_hz: u32) -> Outcome {
    let rows =
        (0..=10 * tick_hz).map(|tick| row(tick, f64::from(tick) / f64::from(tick_hz), error));
    Outcome {
        scenario: "nominal <lift>".into(),
        law,
        adaptation,
        tick_hz,
        seed: 7,
        ticks: u64::from(10 * tick_hz),
        metrics: Metrics {
            rms_m: [error; 3],
            rse_m: error,
            rho_s: 1e-3,
            e_max_m: error,
            v_max_m_s: 0.2272,
        },
        mode: "Tracking".into(),
        faults: Vec::new(),
        realtime_factor: 40.0,
        broken_limits: Vec::new(),
        expected: None,
        start_s: None,
        happenings: Vec::new(),
        torque_limit: REFERENCE.limits.map(|limit| limit.tau_max),
        rows: rows.collect(),
        evidence: None,
    }
}

fn row(tick: u32, t_s: f64, error: f64) -> TickRow {
    const LIFT: [f64; JOINTS] = [-0.02473, 0.01236, 0.24726, -0.67503];
    const AT_REST: [f64; JOINTS] = [0.0, 13_917.0, 6_674.0, -873.0];
    let x = t_s / 10.0;
    let s = x.powi(3) * (10.0 - 15.0 * x + 6.0 * x * x);
    let s_dot = 3.0 * x * x * (1.0 - x) * (1.0 - x);
    let q_d = [0, 1, 2, 3].map(|j| Q0[j] + LIFT[j] * s);
    let qd_d = LIFT.map(|a| a * s_dot);
    let wave = error * ((9.0 * t_s).cos() * (-t_s).exp() + 0.2 * (3.0 * t_s).sin());
    let disturbance =
        [0.81, 0.91, 0.13, 0.91].map(|r| 30.0 * r * (std::f64::consts::PI * t_s).sin());
    TickRow {
        t_s,
        q: q_d.map(|q| q + wave),
        qd: qd_d.map(|qd| qd + 30.0 * wave),
        q_d,
        qd_d,
        tip_m: [0.0; 3],
        tip_error_m: [wave, 0.5 * wave, -wave],
        torque: [0, 1, 2, 3].map(|j| AT_REST[j] + disturbance[j]),
        disturbance,
        v: 2.0e4 * wave * wave,
        va: 2.0e4 * wave * wave + 1e-9,
        record: Record {
            tick,
            dac: [32_768, 36_479, 49_152, 0],
            d_hat: disturbance.map(|d| d as f32),
            ..Record::default()
        },
    }
}

fn both() -> [Outcome; 2] {
    [
        run(Law::Backstepping, Adaptation::Inertia, 3e-7, 200),
        run(Law::Pd, Adaptation::None, 3e-5, 200),
    ]
}

fn written(outcomes: &[Outcome]) -> (tempfile::TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let page = report::write(dir.path(), outcomes).unwrap();
    assert_eq!(page, dir.path().join("report.html"));
    let html = fs::read_to_string(page).unwrap();
    (dir, html)
}

fn csv_columns(path: &Path) -> (csv::StringRecord, Vec<csv::StringRecord>) {
    let mut reader = csv::Reader::from_path(path).unwrap();
    (reader.headers().unwrap().clone(), reader.records().map(Result::unwrap).collect())
}

#[test]
fn log_has_a_row_a_tick_and_units_in_its_header() {
    let (dir, _) = written(&both()[..1]);
    let (header, rows) = csv_columns(&dir.path().join("log.csv"));
    assert_eq!(rows.len(), 2_001);
    let value = |row: usize, name: &str| -> f64 {
        let column = header.iter().position(|h| h == name).unwrap_or_else(|| panic!("no {name}"));
        rows[row][column].parse().unwrap()
    };
    for name in ["qd1_rad_s", "qd4_m_s", "q_desired3_rad", "tip_error_z_m", "tau1_nm", "d_hat4_n"] {
        assert!(value(1_000, name).is_finite());
    }
    assert_eq!([value(1, "t_s"), value(1, "tick")], [0.005, 1.0]);
    assert_eq!(value(0, "q4_m"), Q0[3] + 3e-7);
    // DAC codes are offset binary: 32 768 is zero, 36 479 = 3 711 / 32 000 of the boom's limit.
    let commanded = ["tau_command1_nm", "tau_command2_nm", "tau_command3_nm", "tau_command4_n"];
    let expected = [0.0, 3_711.0 / 32_000.0 * 120_000.0, 35_840.0, -30_720.0];
    for (name, expected) in commanded.into_iter().zip(expected) {
        assert!((value(0, name) - expected).abs() < 1e-9, "{name}");
    }
}

#[test]
fn summary_is_an_object_for_one_run_and_an_array_for_more() {
    let summary = |outcomes: &[Outcome]| -> serde_json::Value {
        let (dir, _) = written(outcomes);
        serde_json::from_slice(&fs::read(dir.path().join("summary.json")).unwrap()).unwrap()
    };
    assert_eq!(summary(&both()[..1])["rse_m"], 3e-7);
    assert_eq!(summary(&both())[1]["law"], "pd");
}

#[test]
fn each_of_several_runs_has_its_own_log() {
    let (dir, _) = written(&both());
    for name in ["log-backstepping-inertia.csv", "log-pd-none.csv"] {
        assert_eq!(csv_columns(&dir.path().join(name)).1.len(), 2_001, "{name}");
    }
    assert!(!dir.path().join("log.csv").exists());
}

#[test]
fn page_stands_alone_and_holds_every_figure() {
    let (_dir, html) = written(&both());
    let foreign = html.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for outside in ["http:", "https:", "<script", "<link", "@import", "url(", "src="] {
        assert!(!foreign.contains(outside), "{outside}");
    }
    let figures: Vec<&str> = html.split("<figure>").skip(1).collect();
    let curves = |figure: &str, color| figure.matches(&format!("stroke=\"{color}\"")).count();
    for (figure, (title, panels, adaptive, pd)) in figures.iter().zip(FIGURES) {
        assert!(figure.contains(title), "{title}");
        assert_eq!(figure.matches("<svg role=\"img\"").count(), panels, "{title}");
        assert_eq!(
            [curves(figure, "#0072B2"), curves(figure, "#D55E00")],
            [adaptive, pd],
            "{title}"
        );
    }
    assert_eq!(figures.len(), FIGURES.len());
    assert!(html.contains("nominal &lt;lift&gt;") && !html.contains("<lift>"));
}

#[test]
fn page_stays_small_with_many_ticks() {
    let long = [
        run(Law::Backstepping, Adaptation::Inertia, 3e-7, 2_000),
        run(Law::Backstepping, Adaptation::Paper, 3e-6, 2_000),
        run(Law::Pd, Adaptation::None, 3e-5, 2_000),
    ];
    let (_dir, html) = written(&long);
    assert!(html.len() < 3_000_000, "{} bytes", html.len());
}

#[test]
fn values_that_are_not_finite_are_left_out_and_counted() {
    let mut broken = both();
    broken[0].rows[100].q[2] = f64::NAN;
    broken[0].rows[101].q[2] = f64::INFINITY;
    let (_dir, html) = written(&broken);
    let noted = html.matches("not finite: 2.").count();
    // Position errors, position tracking and the tip's path in the side view.
    assert_eq!(noted, 3);
    assert_eq!(html.matches("<svg role=\"img\"").count(), 31);
    assert!(!html.contains("NaN") && !html.contains("inf<"));
    assert!(!written(&both()).1.contains("not finite"));
}

#[test]
fn page_says_what_failed() {
    let mut failed = both();
    failed[0].faults = vec!["EmergencyStop".into()];
    failed[1].broken_limits = vec!["rse_m is 3e-5 and may be 1e-6".into()];
    failed[1].faults = vec!["Overspeed".into()];
    let (_dir, html) = written(&failed);
    for text in [
        "failed: fault",
        "EmergencyStop",
        "failed: 1 limit broken",
        "rse_m is 3e-5 and may be 1e-6",
        "Overspeed",
    ] {
        assert!(html.contains(text), "{text}");
    }
    assert!(!html.contains("passed") && written(&both()).1.contains("passed"));
}

#[test]
fn runs_without_ticks_have_a_page_without_figures() {
    let mut bare = both();
    bare.iter_mut().for_each(|outcome| outcome.rows.clear());
    let (_dir, html) = written(&bare);
    assert!(html.contains("Table 3") && html.contains("without a tick of its trajectory"));
    assert!(!html.contains("<figure>"));
}

#[test]
fn table_puts_our_figures_beside_the_papers() {
    let text = report::table3(&both());
    let rse = text.lines().find(|line| line.contains("RSE, m")).unwrap();
    let figures: Vec<&str> = rse.split(['|', '┆', '│']).map(str::trim).collect();
    for figure in ["3.0000e-7", "3.0000e-5", "2.7134e-6", "8.674e-5"] {
        assert!(figures.contains(&figure), "{figure} is not in {figures:?}");
    }
    assert!(text.contains("impossible") && text.contains("1.8e-3 *"));
}

#[test]
fn a_folder_that_cannot_be_written_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("taken");
    fs::write(&file, "").unwrap();
    let error = report::write(&file, &both()).unwrap_err();
    assert!(error.to_string().contains(file.to_str().unwrap()), "{error}");
}

#[test]
fn runs_that_would_share_a_log_are_refused() {
    let twice = [both()[0].clone(), both()[0].clone()];
    let dir = tempfile::tempdir().unwrap();
    let error = report::write(dir.path(), &twice).unwrap_err();
    assert!(error.to_string().contains("backstepping, inertia-weighted"), "{error}");
    assert!(report::write(dir.path(), &[]).is_err());
}
