//! scratch
use hil_sim::scenario::Scenario;
use std::collections::BTreeMap;
use tests::{board, price::price};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let image = board::open("mps2-an386");
    let plugin = std::path::PathBuf::from("/tmp/libtrace_plugin.so");
    let mut scenario = Scenario::load(&args[1]).unwrap();
    scenario.duration_s = 1.0;
    scenario.settle_s = 0.1;
    scenario.trajectory.amplitude = scenario.trajectory.amplitude.map(|a| 0.1 * a);
    if let Some(p) = &mut scenario.plant.payload {
        p.at_s = 0.5;
    }
    for a in &args[3..] {
        match a.split_once('=') {
            Some(("hz", v)) => scenario.tick_hz = v.parse().unwrap(),
            Some(("err", v)) => scenario.bus.error_share = v.parse().unwrap(),
            Some(("psi", _)) => {
                scenario.controller.adaptation = hil_sim::outcome::Adaptation::Paper
            }
            _ => panic!(),
        }
    }
    let trace = board::trace(&image, &plugin, &scenario);
    let one = std::env::var("TRACE_TICK").is_ok();
    let n = if one { 1 } else { trace.ticks.len() as u64 };
    // worst ticks
    let mut sums: Vec<(u64, usize)> = trace
        .ticks
        .iter()
        .enumerate()
        .map(|(i, t)| (t.iter().skip(1).map(|c| c.plain).sum(), i))
        .collect();
    sums.sort();
    sums.reverse();
    println!("ticks {} min {} worst {:?}", trace.ticks.len(), sums.last().unwrap().0, &sums[..12]);
    let show = std::env::var("TRACE_TICK").ok().map_or(sums[0].1, |v| v.parse().unwrap());
    for (i, (name, _)) in board::STAGES.iter().enumerate() {
        println!("  {name}: {}", trace.ticks[show][i].plain);
    }
    println!("  other: {}", trace.ticks[show][board::STAGES.len()].plain);
    let tick = image.function_named("tick").unwrap();
    let reached = tests::stack::reachable(&image, tick.start, &[]).unwrap();
    let debug = addr2line::Loader::new(&image.path).unwrap();
    let mut by: BTreeMap<String, u64> = BTreeMap::new();
    let level = args[2].as_str();
    for start in reached {
        let f = &image.functions[&start];
        for (at, site) in trace.sites.range(f.start..f.end) {
            let Some(insn) = image.code.get(at) else { continue };
            let p = price(insn, image.code.get(&(at + insn.size())));
            let cyc = site.taken * u64::from(p.taken.plain)
                + (site.executed - site.taken) * u64::from(p.through.plain);
            let mut frames = debug.find_frames(u64::from(*at)).unwrap();
            let mut chain = vec![];
            while let Some(fr) = frames.next().unwrap() {
                let Some(function) = fr.function else { continue };
                let name = function.demangle().unwrap().into_owned();
                let loc = fr
                    .location
                    .map(|l| {
                        format!(
                            "{}:{}",
                            l.file.unwrap_or("").rsplit('/').next().unwrap(),
                            l.line.unwrap_or(0)
                        )
                    })
                    .unwrap_or_default();
                chain.push((name, loc));
            }
            let ours: Vec<&(String, String)> = chain
                .iter()
                .filter(|(n, _)| {
                    n.contains("control::")
                        || n.contains("firmware::")
                        || n.contains("shared::")
                        || n.contains("mps2")
                })
                .collect();
            let key = match (level, ours.first()) {
                ("line", Some((n, l))) => format!("{l} {n}"),
                (_, Some((n, _))) => format!("{n}  [in {}]", &f.name[..f.name.len().min(60)]),
                _ => f.name.clone(),
            };
            *by.entry(key).or_default() += cyc;
        }
    }
    let mut v: Vec<_> = by.into_iter().map(|(k, c)| (c, k)).collect();
    v.sort();
    v.reverse();
    for (c, k) in v.iter().take(90) {
        if *c as f64 / n as f64 >= 1.0 {
            println!("{:8.1} {}", *c as f64 / n as f64, &k[..k.len().min(170)]);
        }
    }
}
