//! Runs an image in the emulator with the trace plug-in, and reads what each tick cost.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

use crate::image::{Function, Image};
use crate::price::price;
use crate::stage::{self, Stage};
use crate::thumb::Class;

/// Work of one stage of one tick, or of a whole tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Instructions executed.
    pub instructions: u64,
    /// Modelled cycles, plain variant.
    pub plain: u64,
    /// Modelled cycles, pessimistic variant.
    pub pessimistic: u64,
}

impl std::ops::Add for Cost {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self {
            instructions: self.instructions + b.instructions,
            plain: self.plain + b.plain,
            pessimistic: self.pessimistic + b.pessimistic,
        }
    }
}

/// What happened at one instruction over the whole run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Site {
    /// Times that it was executed.
    pub executed: u64,
    /// Times that the next instruction executed was not the next in memory.
    pub taken: u64,
}

/// A finished run.
#[derive(Debug)]
pub struct Trace {
    /// Costs of each tick, one for each stage and last what belongs to none.
    pub ticks: Vec<Vec<Cost>>,
    /// Every instruction that was executed, by address.
    pub sites: BTreeMap<u32, Site>,
    /// What the image wrote.
    pub stdout: String,
}

const TICKS: &str = "ticks.csv";
const SITES: &str = "sites.csv";

/// What to trace.
pub struct Request<'a> {
    /// Plug-in library.
    pub plugin: &'a Path,
    /// Folder for the price list and the results.
    pub folder: &'a Path,
    /// Part of the name of the function that is one tick; it must be called, not inlined.
    pub tick: &'a str,
    /// Stages of the tick.
    pub stages: &'a [Stage<'a>],
}

/// Writes the price list and gives the emulator's arguments that load the plug-in.
pub fn arguments(image: &Image, request: &Request) -> Result<[String; 2], String> {
    let file = |name: &str| request.folder.join(name);
    let prices = file("prices.csv");
    let tick = image.function_named(request.tick)?;
    std::fs::write(&prices, price_list(image, tick, request.stages)?).map_err(|e| e.to_string())?;
    let argument = format!(
        "{},prices={},stages={},ticks={},sites={},start={}",
        request.plugin.display(),
        prices.display(),
        request.stages.len(),
        file(TICKS).display(),
        file(SITES).display(),
        tick.start,
    );
    Ok(["-plugin".into(), argument])
}

/// Reads what the plug-in left in `folder` when the emulator ended.
pub fn results(folder: &Path) -> Result<Trace, String> {
    let read = |name| {
        let path = folder.join(name);
        std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))
    };
    Ok(Trace {
        ticks: parse_ticks(&read(TICKS)?)?,
        sites: parse_sites(&read(SITES)?)?,
        stdout: String::new(),
    })
}

/// Runs `image` under `emulator`, which holds the emulator's command line but for the plug-in.
pub fn run(image: &Image, request: &Request, mut emulator: Command) -> Result<Trace, String> {
    let output = emulator.args(arguments(image, request)?).output().map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(format!("{}: {}", output.status, String::from_utf8_lossy(&output.stderr)));
    }
    let stdout = String::from_utf8_lossy(&output.stdout).into_owned();
    Ok(Trace { stdout, ..results(request.folder)? })
}

/// One line an instruction: address, size, stage (the number of stages means none, empty the one that ran before, as
/// in a routine that several stages call), then plain and pessimistic cycles when the flow goes through and when not.
pub fn price_list(image: &Image, tick: &Function, stages: &[Stage]) -> Result<String, String> {
    let mut list = String::new();
    for (at, stage) in stage::attribute(image, stages)? {
        let insn = &image.code[&at];
        if insn.class == Class::Unknown {
            continue;
        }
        let price = price(insn, image.code.get(&(at + insn.size())));
        let none = (tick.start..tick.end).contains(&at).then_some(stages.len());
        let stage = stage.or(none).map_or(String::new(), |s| s.to_string());
        let (through, taken) = (price.through, price.taken);
        let line = writeln!(
            list,
            "{at},{},{stage},{},{},{},{}",
            insn.size(),
            through.plain,
            through.pessimistic,
            taken.plain,
            taken.pessimistic
        );
        line.map_err(|e| e.to_string())?;
    }
    Ok(list)
}

fn numbers(line: &str) -> Result<Vec<u64>, String> {
    line.split(',').map(|n| n.parse().map_err(|e| format!("{line:?}: {e}"))).collect()
}

fn parse_ticks(text: &str) -> Result<Vec<Vec<Cost>>, String> {
    let row = |line| -> Result<Vec<Cost>, String> {
        let cells = numbers(line)?;
        let cost = |c: &[u64]| Cost { instructions: c[0], plain: c[1], pessimistic: c[2] };
        Ok(cells.chunks_exact(3).map(cost).collect())
    };
    text.lines().map(row).collect()
}

fn parse_sites(text: &str) -> Result<BTreeMap<u32, Site>, String> {
    let row = |line| match numbers(line)?[..] {
        [at, executed, taken] => Ok((at as u32, Site { executed, taken })),
        _ => Err(format!("{line:?} has not three cells")),
    };
    text.lines().map(row).collect()
}

/// Least, mean and greatest of one figure over the ticks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Least.
    pub min: u64,
    /// Mean.
    pub mean: f64,
    /// Greatest.
    pub max: u64,
    /// First tick with the greatest.
    pub worst_tick: usize,
}

impl Trace {
    /// Spread of a figure over the ticks, of the stages that `counts` accepts by index (one past the last is "none").
    pub fn spread(&self, counts: impl Fn(usize) -> bool, figure: impl Fn(&Cost) -> u64) -> Spread {
        let sum = |tick: &Vec<Cost>| {
            let parts = tick.iter().enumerate().filter(|(i, _)| counts(*i)).map(|(_, c)| *c);
            figure(&parts.fold(Cost::default(), |a, b| a + b))
        };
        let sums: Vec<u64> = self.ticks.iter().map(sum).collect();
        let max = sums.iter().copied().max().unwrap_or(0);
        Spread {
            min: sums.iter().copied().min().unwrap_or(0),
            mean: sums.iter().sum::<u64>() as f64 / sums.len().max(1) as f64,
            max,
            worst_tick: sums.iter().position(|&s| s == max).unwrap_or(0),
        }
    }

    /// Conditional branches of `range` that went only one way or were never reached: address and what was seen.
    pub fn one_sided(&self, image: &Image, range: std::ops::Range<u32>) -> Vec<(u32, Site)> {
        let seen = |at| self.sites.get(at).copied().unwrap_or(Site { executed: 0, taken: 0 });
        image
            .code
            .range(range)
            .filter(|(_, insn)| insn.is_conditional_branch())
            .map(|(at, _)| (*at, seen(at)))
            .filter(|(_, s)| s.taken == 0 || s.taken == s.executed)
            .collect()
    }
}
