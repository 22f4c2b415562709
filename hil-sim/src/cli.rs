//! The command line: definitions and parsing only.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use shared::arm::JOINTS;

use crate::campaign;
use crate::faults;
use crate::outcome::{Adaptation, Law};
use crate::scenario::bounds::{TICK_HZ, parse_seed, parse_tick_hz};

const EXIT_CODES: &str = "\
Exit codes:
  0  done
  1  the run ended in a fault that was not expected, or broke one of its accept limits
  2  bad usage or bad input";

const EXAMPLES: &str = "\
Examples:
  hil-sim                                  the paper's Table 3
  hil-sim run payload                      a shipped scenario
  hil-sim run my.toml --law pd --json      a file of your own, with the PD instead
  hil-sim model --q 0.2,1.1,-0.1,4.0       M, C qd, G and torque in one pose";

const RUN_EXAMPLES: &str = "\
Examples:
  hil-sim run paper
  hil-sim run paper --tick-hz 4000 --out out/4khz
  hil-sim run payload --adaptation none --no-output
  hil-sim run scenarios/mine.toml --seed 7 --json";

const FAULTS: &str = "\
Faults that a scenario's [[fault]] tables inject, with their targets:";

const FAULTS_EXAMPLES: &str = "\
Examples:
  hil-sim faults
  hil-sim faults --only 12
  hil-sim faults --seed 7 --json";

const FAULTS_EXIT_CODES: &str = "\
Exit codes:
  0  every cell passes
  1  a cell falls short
  2  bad usage or bad input";

const PIL_EXAMPLES: &str = "\
Examples:
  cargo firmware && hil-sim pil paper
  hil-sim pil payload --law pd";

const PIL_EXIT_CODES: &str = "\
Exit codes:
  0  done, and equal bit for bit
  1  the builds differ, or the run ended in a fault or broke one of its accept limits
  2  bad usage or bad input, no image, or no emulator";

/// Where `cargo firmware` leaves the image.
const IMAGE: &str = "target/thumbv7em-none-eabihf/release/mps2-an386";

const MODEL_EXAMPLES: &str = "\
Examples:
  hil-sim model --q 0.2129,1.1229,-0.1416,4.0915
  hil-sim model --q 0,1,-0.5,4 --qd 0.1,0,-0.2,0.3 --qdd 0,0,0,-1 --json";

/// Runs the lifting arm's controller firmware against a simulated arm.
///
/// Without a command it runs the `paper` scenario with three controllers (backstepping with
/// inertia-weighted adaptation, backstepping with the paper's adaptation, PD) and prints their metrics
/// beside the paper's Table 3.
#[derive(Debug, Parser)]
#[command(name = "hil-sim", version, after_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"))]
pub struct Cli {
    /// What to do; nothing means Table 3.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run one scenario and judge it by its accept limits
    Run(RunArgs),
    /// Run one scenario on the emulated board and compare it bit for bit with software
    Pil(PilArgs),
    /// Run the fault campaign: every fault in every pose, and what comes of it
    Faults(FaultsArgs),
    /// List the shipped scenarios
    List,
    /// Print the arm's dynamics in one state
    ///
    /// Prints M, C qd, G and the torque M qdd + C qd + G. Joints 1 to 3 are in rad and N m, the
    /// prismatic joint 4 in m and N.
    Model(ModelArgs),
}

/// A scenario, with what overrides its own values.
#[derive(Args, Debug)]
pub struct Choice {
    /// Name of a shipped scenario (see `hil-sim list`) or path of a TOML file
    pub scenario: String,
    /// Control law
    #[arg(long, value_enum)]
    pub law: Option<Law>,
    /// Adaptation of the backstepping law; the PD has none
    #[arg(long, value_enum)]
    pub adaptation: Option<Adaptation>,
    /// Control ticks a second, Hz
    #[arg(long, value_name = "N", value_parser = parse_tick_hz)]
    #[arg(help = format!("Control ticks a second, {TICK_HZ}"))]
    pub tick_hz: Option<u32>,
    /// Seed of every random number of the run
    #[arg(long, value_name = "N", value_parser = parse_seed)]
    pub seed: Option<u64>,
}

/// Arguments of `run`.
#[derive(Args, Debug)]
#[command(after_help = format!("{RUN_EXAMPLES}\n\n{EXIT_CODES}"))]
#[command(after_long_help = format!("{RUN_EXAMPLES}\n\n{EXIT_CODES}\n\n{FAULTS}\n{}", faults::table()))]
pub struct RunArgs {
    /// What to run
    #[command(flatten)]
    pub choice: Choice,
    /// Directory for the run's files
    #[arg(long, value_name = "DIR", conflicts_with = "no_output")]
    pub out: Option<PathBuf>,
    /// Write no files
    #[arg(long)]
    pub no_output: bool,
    /// Print the outcome as JSON
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `faults`.
#[derive(Args, Clone, Debug)]
#[command(after_help = format!("{FAULTS_EXAMPLES}\n\n{FAULTS_EXIT_CODES}"))]
pub struct FaultsArgs {
    /// Run this row of the fault table only, 1 to 27
    #[arg(long, value_name = "N", value_parser = row_number, allow_hyphen_values = true)]
    pub only: Option<u8>,
    /// Seed of every random number; rows that need several take those that follow
    #[arg(long, value_name = "N", value_parser = parse_seed, default_value = "1")]
    pub seed: u64,
    /// Image of the emulated board, for row 25
    #[arg(long, value_name = "ELF", default_value = IMAGE)]
    pub image: PathBuf,
    /// Print the outcome as JSON
    #[arg(long)]
    pub json: bool,
}

/// Number of a row of the fault table.
fn row_number(text: &str) -> Result<u8, String> {
    let number = text.parse().ok().filter(|number| campaign::NUMBERS.contains(number));
    number.ok_or_else(|| {
        format!(
            "must be a row of the fault table, {} to {}",
            campaign::NUMBERS.start(),
            campaign::NUMBERS.end()
        )
    })
}

/// Arguments of `pil`.
#[derive(Args, Debug)]
#[command(after_help = format!("{PIL_EXAMPLES}\n\n{PIL_EXIT_CODES}"))]
pub struct PilArgs {
    /// What to run
    #[command(flatten)]
    pub choice: Choice,
    /// Image of the emulated board, as `cargo firmware` builds it
    #[arg(long, value_name = "ELF", default_value = IMAGE)]
    pub image: PathBuf,
    /// Directory for what the board kept of a run that ended in a fault
    #[arg(long, value_name = "DIR", conflicts_with = "no_output")]
    pub out: Option<PathBuf>,
    /// Write no files
    #[arg(long)]
    pub no_output: bool,
}

/// Arguments of `model`.
#[derive(Args, Clone, Copy, Debug)]
#[command(after_help = format!("{MODEL_EXAMPLES}\n\n{EXIT_CODES}"))]
pub struct ModelArgs {
    /// Joint positions, rad (joint 4: m)
    #[arg(long, value_name = "A,B,C,D", value_parser = four, allow_hyphen_values = true)]
    pub q: [f64; JOINTS],
    /// Joint speeds, rad/s (joint 4: m/s)
    #[arg(long, value_name = "A,B,C,D", value_parser = four, allow_hyphen_values = true, default_value = "0,0,0,0")]
    pub qd: [f64; JOINTS],
    /// Joint accelerations, rad/s² (joint 4: m/s²)
    #[arg(long, value_name = "A,B,C,D", value_parser = four, allow_hyphen_values = true, default_value = "0,0,0,0")]
    pub qdd: [f64; JOINTS],
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// Four finite numbers with commas between them.
fn four(text: &str) -> Result<[f64; JOINTS], String> {
    let words = text.split(',').map(str::trim).collect::<Vec<_>>();
    let words = <[&str; JOINTS]>::try_from(words)
        .map_err(|words| format!("needs exactly {JOINTS} numbers, got {}", words.len()))?;
    let mut numbers = [0.0; JOINTS];
    for (joint, (slot, word)) in numbers.iter_mut().zip(words).enumerate() {
        *slot = word
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite())
            .ok_or_else(|| format!("joint {}: `{word}` is not a finite number", joint + 1))?;
    }
    Ok(numbers)
}
