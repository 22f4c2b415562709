//! Bad input of every kind gives exactly one error that names place, value and allowed range; the full
//! texts are kept as snapshots.

use std::fs;

use clap::{CommandFactory, Parser};
use hil_sim::cli::Cli;
use hil_sim::scenario::{MAX_BYTES, Scenario, ScenarioError};
use miette::{GraphicalReportHandler, GraphicalTheme};
use proptest::prelude::*;

const SUMMARY: &str = "summary = \"a test\"\n";
const TRAJECTORY: &str = "\n[trajectory]\nprofile = \"quintic\"\namplitude = [0, 0, 0.2, -0.5]\n";
const SHIPPED: [&str; 6] =
    ["paper", "velocity-mismatch", "payload", "coarse-encoders", "noisy-bus", "stuck-encoder"];

/// A fault with these lines.
fn fault(lines: &str) -> String {
    with("", &format!("[[fault]]\n{lines}"))
}

/// The error as a terminal of 100 columns without colour shows it.
fn rendered(error: &ScenarioError) -> String {
    let mut text = String::new();
    GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
        .with_width(100)
        .with_links(false)
        .render_report(&mut text, error)
        .expect("a String takes any text");
    text
}

/// Title and error of each bad text, one after the other.
fn gallery<'a>(bad: impl IntoIterator<Item = (&'a str, String)>) -> String {
    let page = |(title, text): (&str, String)| {
        let error = Scenario::parse("bad.toml", &text).expect_err(title);
        format!("--- {title}\n{}\n", rendered(&error))
    };
    bad.into_iter().map(page).collect()
}

/// A minimal scenario with lines before and after its trajectory's table.
fn with(top: &str, end: &str) -> String {
    format!("{SUMMARY}{top}\n{TRAJECTORY}{end}\n")
}

#[test]
fn wrong_values() {
    let bad = [
        ("tick too slow", with("tick_hz = 500", "")),
        ("tick too fast", with("tick_hz = 10_000", "")),
        ("tick with a point", with("tick_hz = 2000.0", "")),
        ("negative seed", with("seed = -1", "")),
        ("endless settling", with("settle_s = inf", "")),
        ("duration not a number", with("duration_s = nan", "")),
        ("duration as text", with("duration_s = \"ten\"", "")),
        ("velocity step as number", with("", "allow_velocity_step = 1")),
        ("start outside the limits", with("", "q0 = [0.2, 1.5, -0.1, 4.0]")),
        ("end outside the limits", with("", "q0 = [0.2, 1.1, -0.1, 3.3]")),
        ("model too light", with("", "[model]\nmass_scale = 0.4")),
        ("model payload above the rating", with("", "[model]\npayload_kg = 301")),
        ("pick-up after the end", with("duration_s = 8", "[plant.payload]\nkg = 300\nat_s = 9")),
        ("friction of three joints", with("", "[plant]\nfriction = [1, 2, 3]")),
        ("friction as one number", with("", "[plant]\nfriction = 200")),
        (
            "one entry wrong, list on several lines",
            with("", "[plant]\ndisturbance = [\n    0.1, # one\n    0.2,\n    1.3,\n    0.4,\n]"),
        ),
        ("one entry not a number", with("", "[controller]\npsi = [1e9, \"1e9\", 1e9, 1e9]")),
        ("psi not positive", with("", "[controller]\npsi = [1e9, 1e9, 0, 1e9]")),
        ("disturbance as a wrong word", with("", "[plant]\ndisturbance = \"each tick\"")),
        ("too many encoder bits", with("", "[encoders]\nrotary_bits = 32")),
        ("linear encoder too coarse", with("", "[encoders]\nlinear_lsb_m = 1e-3")),
        ("unknown law", with("", "[controller]\nlaw = \"pid\"")),
        ("adaptation as a number", with("", "[controller]\nadaptation = 3")),
        ("gain out of range", with("", "[controller]\nk1 = 5")),
        ("accept limit negative", with("", "[accept.pd]\nrse_m = -1e-6")),
        ("summary of two lines", format!("summary = \"a\\nb\"\n{TRAJECTORY}")),
        ("a very long value", with(&format!("seed = \"{}\"", "x".repeat(200)), "")),
    ];
    insta::assert_snapshot!(gallery(bad));
}

#[test]
fn wrong_structure() {
    let bad = [
        ("empty file", String::new()),
        ("no summary", TRAJECTORY.to_owned()),
        ("no trajectory", SUMMARY.to_owned()),
        ("no amplitude", format!("{SUMMARY}\n[trajectory]\nprofile = \"quintic\"\n")),
        ("no profile", format!("{SUMMARY}\n[trajectory]\namplitude = [0, 0, 0, 0]\n")),
        ("payload without its time", with("", "[plant.payload]\nkg = 300")),
        ("unknown key", with("", "[controller]\nk3 = 600")),
        ("unknown key at the top", with("tick = 2000", "")),
        ("unknown table", with("", "[motor]\nlag_s = 0.01")),
        ("unknown controller to accept", with("", "[accept.pid]\nrse_m = 1e-6")),
        ("key given twice", with("seed = 1\nseed = 2", "")),
        ("value where a table belongs", with("plant = 3", "")),
        ("value where the trajectory belongs", format!("{SUMMARY}trajectory = 3")),
        ("table where a value belongs", with("", "[controller.k1]\nvalue = 200")),
        ("no value", with("seed =", "")),
        ("unclosed text", with("seed = \"1", "")),
        ("not TOML at all", "{ \"summary\": 1 }".to_owned()),
    ];
    insta::assert_snapshot!(gallery(bad));
}

#[test]
fn wrong_faults() {
    let bad = [
        ("no kind", fault("at_s = 1")),
        ("unknown kind", fault("kind = \"stuck-encodr\"\nat_s = 1")),
        ("kind unlike any", fault("kind = \"xyz\"\nat_s = 1")),
        ("kind as a number", fault("kind = 6\nat_s = 1")),
        ("no target", fault("kind = \"repeat\"\nat_s = 1")),
        ("target of another kind", fault("kind = \"brake-slip\"\ntarget = \"joint1\"\nat_s = 1")),
        ("target where there is but one", fault("kind = \"hang\"\ntarget = \"adc\"\nat_s = 1")),
        ("no time", fault("kind = \"hang\"")),
        ("time out of range", fault("kind = \"hang\"\nat_s = 2000")),
        ("time where there is but one", fault("kind = \"config-flip\"\nat_s = 0")),
        ("negative duration", fault("kind = \"hang\"\nat_s = 1\nfor_s = -1")),
        ("severity without meaning", fault("kind = \"hang\"\nat_s = 1\nseverity = 1")),
        (
            "severity out of range",
            fault("kind = \"mutation\"\ntarget = \"all\"\nat_s = 1\nseverity = 1.5"),
        ),
        (
            "severity not whole",
            fault("kind = \"bit-flips\"\ntarget = \"adc\"\nat_s = 1\nseverity = 1.5"),
        ),
        ("no severity", fault("kind = \"payload\"\nat_s = 1")),
        (
            "bit beyond its place",
            fault("kind = \"flip\"\ntarget = \"limit\"\nat_s = 1\nseverity = 128"),
        ),
        (
            "encoder exchanged with itself",
            fault("kind = \"swap\"\ntarget = \"encoder2\"\nat_s = 1\nseverity = 2"),
        ),
        ("unknown key", fault("kind = \"hang\"\nat_s = 1\nuntil_s = 2")),
        ("one table in place of a list", with("", "[fault]\nkind = \"hang\"\nat_s = 1")),
        ("unknown fault expected", with("", "[expect]\nfault = \"EncoderStock\"")),
        ("no fault expected", with("", "[expect]\nfault = \"None\"")),
    ];
    insta::assert_snapshot!(gallery(bad));
}

#[test]
fn wrong_files() {
    let dir = tempfile::tempdir().expect("a temporary directory");
    let file = |name: &str, bytes: &[u8]| {
        let path = dir.path().join(name);
        fs::write(&path, bytes).expect("the directory is writable");
        path.to_str().expect("temporary paths are UTF-8").to_owned()
    };
    let asked = [
        "paperr".to_owned(),
        "lift".to_owned(),
        "scenarios/payloda.toml".to_owned(),
        file("latin1.toml", b"summary = \"a\"\n# caf\xe9\n"),
        file("huge.toml", &vec![b'#'; MAX_BYTES as usize + 1]),
    ];
    let here = dir.path().to_str().expect("temporary paths are UTF-8");
    let page = |name: String| {
        // Unwrapped, because the directory's length differs from run to run.
        let mut text = String::new();
        GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor())
            .with_wrap_lines(false)
            .render_report(&mut text, &Scenario::load(&name).expect_err(&name))
            .expect("a String takes any text");
        text.replace(here, "DIR")
    };
    insta::assert_snapshot!(asked.map(page).join("\n"));
}

#[test]
fn a_directory_is_refused_and_a_file_of_the_largest_size_is_read() {
    assert!(matches!(Scenario::load("scenarios/"), Err(ScenarioError::Unreadable { .. })));
    let dir = tempfile::tempdir().expect("a temporary directory");
    let path = dir.path().join("largest.toml");
    let mut text = format!("{}#", with("", ""));
    text.push_str(&"-".repeat(MAX_BYTES as usize - text.len()));
    fs::write(&path, text).expect("the directory is writable");
    let scenario = Scenario::load(path.to_str().expect("temporary paths are UTF-8"));
    assert_eq!(scenario.expect("it is just short enough").name, "largest");
}

#[test]
fn wrong_command_lines() {
    let lines = [
        "run",
        "runn paper",
        "run paper --tick-hz 500",
        "run paper --tick-hz fast",
        "run paper --seed -1",
        "run paper --law pid",
        "run paper --out here --no-output",
        "model",
        "model --q 1,2,3",
        "model --q -1,-2,x,4",
        "model --q -1,-2,-3,nan",
        "model --q 0,0,0,4 --qd 1,2,3,4,5",
    ];
    let page = |line: &str| {
        let words = ["hil-sim"].into_iter().chain(line.split(' '));
        let error = Cli::try_parse_from(words).expect_err(line);
        assert_eq!(error.exit_code(), 2, "{line}");
        format!("--- hil-sim {line}\n{error}")
    };
    insta::assert_snapshot!(lines.map(page).join("\n"));
}

#[test]
fn help_texts() {
    let mut cli = Cli::command();
    cli.build();
    let mut pages = vec![cli.render_long_help().to_string()];
    for name in ["run", "model"] {
        let command = cli.find_subcommand_mut(name).expect("it is a command");
        pages.push(command.render_long_help().to_string());
    }
    insta::assert_snapshot!(pages.join("\n----------------\n"));
}

/// Reads a text as a file, and its error as a user would.
fn parse_and_render(text: &str) {
    if let Err(error) = Scenario::parse("any.toml", text) {
        assert!(!rendered(&error).is_empty());
    }
}

proptest! {
    #[test]
    fn any_text_gives_a_scenario_or_an_error(text in any::<String>()) {
        parse_and_render(&text);
    }

    #[test]
    fn a_damaged_scenario_gives_a_scenario_or_an_error(
        name in prop::sample::select(&SHIPPED[..]),
        cuts in prop::collection::vec((any::<prop::sample::Index>(), 0..12_usize, PATCH), 1..4),
    ) {
        let file = fs::read_to_string(format!("scenarios/{name}.toml")).expect("it is shipped");
        let mut text = file.chars().collect::<Vec<_>>();
        for (at, length, patch) in cuts {
            let start = at.index(text.len() + 1);
            let end = (start + length).min(text.len());
            text.splice(start..end, patch.chars());
        }
        parse_and_render(&text.into_iter().collect::<String>());
    }
}

/// What replaces a stretch of a damaged file: syntax, numbers at the edge and any character.
const PATCH: &str = "([\\[\\]{}=.,\"'\n#-]|é|nan|inf|1e999|[0-9]{1,25}|\\PC){0,3}";
