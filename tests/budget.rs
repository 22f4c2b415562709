use hil_sim::scenario::Scenario;
use tests::board::{self, LINK, STAGES};
#[test]
fn look() {
    let image = board::open("mps2-an386");
    let plugin = board::plugin();
    let scenario = Scenario::load("paper").unwrap();
    let t = std::time::Instant::now();
    let trace = board::trace(&image, &plugin, &scenario);
    println!("{} ticks {:?}", trace.ticks.len(), t.elapsed());
    for (i, (name, _)) in STAGES.iter().enumerate().chain([(STAGES.len(), &("other", &[][..]))]) {
        println!(
            "{name:26} {:?} {:?}",
            trace.spread(|s| s == i, |c| c.instructions),
            trace.spread(|s| s == i, |c| c.plain)
        );
    }
    println!(
        "total {:?} {:?} {:?}",
        trace.spread(|s| s != LINK, |c| c.instructions),
        trace.spread(|s| s != LINK, |c| c.plain),
        trace.spread(|s| s != LINK, |c| c.pessimistic)
    );
}
