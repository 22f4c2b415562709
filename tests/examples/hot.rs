//! Prints where a tick's cycles go.
use hil_sim::scenario::Scenario;
use std::collections::BTreeMap;
use tests::{board, price::price};
fn main() {
    let path = std::path::PathBuf::from("target/thumbv7em-none-eabihf/release/mps2-an386");
    let image = tests::image::Image::open(&path).unwrap();
    let plugin =
        std::path::PathBuf::from("target/release/libtrace_plugin.so").canonicalize().unwrap();
    let mut scenario = Scenario::load(&std::env::args().nth(1).unwrap_or("paper".into())).unwrap();
    scenario.duration_s = 1.0;
    scenario.trajectory.amplitude = scenario.trajectory.amplitude.map(|a| a * 0.1);
    let trace = board::trace(&image, &plugin, &scenario);
    let n = trace.ticks.len() as f64;
    let debug = addr2line::Loader::new(&image.path).unwrap();
    let mut by_line: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    let mut by_fn: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    for (&at, site) in &trace.sites {
        let Some(insn) = image.code.get(&at) else { continue };
        let p = price(insn, image.code.get(&(at + insn.size())));
        let cycles = ((site.executed - site.taken) * p.through.plain as u64
            + site.taken * p.taken.plain as u64) as f64
            / n;
        let mut frames = debug.find_frames(at.into()).unwrap();
        let mut names = vec![];
        let mut line = String::new();
        while let Some(f) = frames.next().unwrap() {
            if line.is_empty()
                && let Some(l) = &f.location
            {
                line = format!(
                    "{}:{}",
                    l.file.unwrap_or("?").rsplit('/').take(2).collect::<Vec<_>>().join("<"),
                    l.line.unwrap_or(0)
                );
            }
            if let Some(f) = f.function {
                names.push(f.demangle().unwrap().rsplit("::").next().unwrap().to_string());
            }
        }
        names.reverse();
        if !names.iter().any(|n| n == "tick")
            && image.function_at(at).is_some_and(|f| f.name.contains("link"))
        {
            continue;
        }
        if names.first().is_some_and(|n| n.contains("main")) {
            continue;
        }
        let key = names.iter().take(4).cloned().collect::<Vec<_>>().join(">");
        let e = by_fn.entry(key).or_default();
        e.0 += cycles;
        e.1 += site.executed as f64 / n;
        let e = by_line
            .entry(format!("{line} {}", names.last().unwrap_or(&String::new())))
            .or_default();
        e.0 += cycles;
        e.1 += site.executed as f64 / n;
    }
    for (title, map, k) in [("FUNCTIONS", by_fn, 60), ("LINES", by_line, 40)] {
        println!("== {title}");
        let mut v: Vec<_> = map.into_iter().collect();
        v.sort_by(|a, b| b.1.0.total_cmp(&a.1.0));
        for (k, (c, i)) in v.into_iter().take(k) {
            println!("{c:8.1} {i:8.1} {k}");
        }
    }
}
