//! Counts and prices: every executed instruction is charged when its successor shows where the flow went.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufWriter, Write};

/// Plain and pessimistic cycles.
type Cycles = [u64; 2];

/// One instruction.
struct Site {
    at: u32,
    size: u32,
    /// Stage, or `None` to stay in the caller's.
    stage: Option<usize>,
    /// Cycles when the flow goes through, and when it does not; `None` outside the price list.
    price: Option<[Cycles; 2]>,
    executed: u64,
    taken: u64,
}

/// Instructions, plain and pessimistic cycles.
type Cost = [u64; 3];

/// A tick that is running: it ends when the address that its caller goes on at is executed.
struct Tick {
    back: u32,
    costs: Vec<Cost>,
}

/// All that is counted, and the files it goes to.
pub struct Recorder {
    sites: Vec<Site>,
    by_address: HashMap<u32, usize>,
    /// Number of stages; the next number stands for none of them.
    stages: usize,
    start: u32,
    tick: Option<Tick>,
    /// The last executed instruction, not charged yet, and the stage that it ran in.
    last: Option<(usize, usize)>,
    ticks: BufWriter<File>,
    sites_path: String,
    error: Option<String>,
}

impl Recorder {
    /// Reads the price list and creates the files that the arguments name.
    pub fn open(arguments: &[String]) -> Result<Self, String> {
        let value = |name: &str| {
            let found = arguments.iter().find_map(|a| a.strip_prefix(name)?.strip_prefix('='));
            found.ok_or_else(|| format!("argument {name} is missing"))
        };
        let prices = std::fs::read_to_string(value("prices")?).map_err(|e| e.to_string())?;
        let sites = prices.lines().map(parse_site).collect::<Result<Vec<_>, _>>()?;
        let ticks = File::create(value("ticks")?).map_err(|e| e.to_string())?;
        Ok(Self {
            by_address: sites.iter().enumerate().map(|(i, s)| (s.at, i)).collect(),
            stages: value("stages")?.parse().map_err(|e| format!("stages: {e}"))?,
            sites,
            start: value("start")?.parse().map_err(|e| format!("start: {e}"))?,
            tick: None,
            last: None,
            ticks: BufWriter::new(ticks),
            sites_path: value("sites")?.into(),
            error: None,
        })
    }

    /// Number of the instruction at `at`.
    pub fn site(&mut self, at: u32, size: u32) -> usize {
        let sites = &mut self.sites;
        *self.by_address.entry(at).or_insert_with(|| {
            sites.push(Site { at, size, stage: None, price: None, executed: 0, taken: 0 });
            sites.len() - 1
        })
    }

    /// Notes that instruction `site` is about to be executed.
    pub fn execute(&mut self, site: usize) {
        let at = self.sites[site].at;
        let came_from = self.last.map(|(last, stage)| self.charge(last, stage, at));
        let none = self.stages;
        if self.tick.as_ref().is_some_and(|t| t.back == at) {
            self.close_tick();
        }
        if at == self.start {
            self.open_tick(came_from);
        }
        let inherited = match self.last {
            Some((_, stage)) if at != self.start => stage,
            _ => none,
        };
        self.sites[site].executed += 1;
        self.last = Some((site, self.sites[site].stage.unwrap_or(inherited)));
    }

    /// Charges an instruction whose successor is at `next`; returns the address past it.
    fn charge(&mut self, site: usize, stage: usize, next: u32) -> u32 {
        let s = &mut self.sites[site];
        let past = s.at + s.size;
        let is_taken = next != past;
        s.taken += u64::from(is_taken);
        if let Some(tick) = &mut self.tick {
            match s.price {
                Some(price) => {
                    let [plain, pessimistic] = price[usize::from(is_taken)];
                    let cost = &mut tick.costs[stage];
                    cost[0] += 1;
                    cost[1] += plain;
                    cost[2] += pessimistic;
                }
                None => self.error = Some(format!("{:#x} has no price", s.at)),
            }
        }
        past
    }

    fn open_tick(&mut self, came_from: Option<u32>) {
        match (&self.tick, came_from) {
            (None, Some(back)) => {
                self.tick = Some(Tick { back, costs: vec![[0; 3]; self.stages + 1] });
            }
            _ => self.error = Some("a tick began inside a tick, or was not called".into()),
        }
    }

    fn close_tick(&mut self) {
        let Some(tick) = self.tick.take() else { return };
        let cells: Vec<String> = tick.costs.iter().flatten().map(u64::to_string).collect();
        if let Err(e) = writeln!(self.ticks, "{}", cells.join(",")) {
            self.error = Some(e.to_string());
        }
    }

    /// Writes what is left; says what went wrong on the way.
    pub fn finish(mut self) -> Result<(), String> {
        self.ticks.flush().map_err(|e| e.to_string())?;
        let file = File::create(&self.sites_path).map_err(|e| e.to_string())?;
        let mut file = BufWriter::new(file);
        for s in self.sites.iter().filter(|s| s.executed > 0) {
            writeln!(file, "{},{},{}", s.at, s.executed, s.taken).map_err(|e| e.to_string())?;
        }
        file.flush().map_err(|e| e.to_string())?;
        self.error.map_or(Ok(()), Err)
    }
}

/// Address, size, stage or nothing, then plain and pessimistic cycles through and taken.
fn parse_site(line: &str) -> Result<Site, String> {
    let cells: Vec<&str> = line.split(',').collect();
    let [at, size, stage, a, b, c, d] = cells[..] else {
        return Err(format!("{line:?} is no price"));
    };
    let number = |s: &str| s.parse::<u64>().map_err(|e| format!("{line:?}: {e}"));
    Ok(Site {
        at: number(at)? as u32,
        size: number(size)? as u32,
        stage: if stage.is_empty() { None } else { Some(number(stage)? as usize) },
        price: Some([[number(a)?, number(b)?], [number(c)?, number(d)?]]),
        executed: 0,
        taken: 0,
    })
}
