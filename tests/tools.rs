//! The measuring tools against independent routes, on the demo image.

use std::process::Command;

use tests::board::{self, plugin};
use tests::image::Image;
use tests::stack;
use tests::stage::{self, Stage};
use tests::trace::{self, Cost, Request, Site, Trace};

const STAGES: &[Stage] = &[("law", &["demo::law"]), ("link", &["demo::link"])];
const LAW: usize = 0;
const LINK: usize = 1;

fn demo() -> Image {
    board::open("demo")
}

fn emulator(image: &Image) -> Command {
    let mut command = Command::new("qemu-system-arm");
    command
        .args(["-M", "mps2-an386", "-nographic"])
        .args(["-semihosting-config", "enable=on,target=native"])
        .args(["-icount", "shift=7,align=off,sleep=off", "-kernel"])
        .arg(&image.path);
    command
}

fn traced(tick: &str) -> (Image, Trace) {
    let image = demo();
    let folder = tempfile::tempdir().expect("folder");
    let plugin = plugin();
    let request = Request { plugin: &plugin, folder: folder.path(), tick, stages: STAGES };
    let trace = trace::run(&image, &request, emulator(&image)).expect("trace");
    (image, trace)
}

/// Values of the lines that begin with `name`.
fn values(stdout: &str, name: &str) -> Vec<u64> {
    stdout.lines().filter_map(|l| l.strip_prefix(name)?.trim().parse().ok()).collect()
}

fn total(tick: &[Cost]) -> Cost {
    tick.iter().fold(Cost::default(), |a, b| a + *b)
}

/// Route two: the emulator's own clock. One instruction is 128 ns, SysTick counts at 25 MHz: 3.2 counts each.
#[test]
fn instructions_of_each_tick_agree_with_systick() {
    let (_, trace) = traced("demo::tick");
    let times = values(&trace.stdout, "time ");
    assert_eq!(times.len(), 200);
    assert_eq!(trace.ticks.len(), 200);
    for (n, (tick, counts)) in trace.ticks.iter().zip(&times).enumerate() {
        // Between the two reads: the tick, MOV and BL before it, and one of the two reads itself.
        let instructions = total(tick).instructions + 3;
        let from_clock = *counts as f64 / 3.2;
        assert!((instructions as f64 - from_clock).abs() < 1.0, "{n}: {instructions} {from_clock}");
    }
    let spread = trace.spread(|_| true, |c| c.instructions);
    assert!(spread.min < spread.max, "the demo's ticks differ: {spread:?}");
}

/// Route two: by hand from the disassembly.
/// `push {r4, lr}` 3/3, `movs` 1/1, `adds` 1/1, `vmov s0, r4` 1/2, `vadd s1` 1/1 (only an addend of the next),
/// `vmla s1, s0, s0` 3/3+1 (a factor of the next), `vdiv s2, s1, s0` 14/14, `add.w r3` 1/1+1 (address of the next),
/// `ldr` 2/2, `str` 1/2, `udiv` 12/12, `cbz` 1/1, `b` 3/4 over `nop`, `pop {r4, pc}` 5/6.
#[test]
fn a_straight_line_costs_what_is_counted_by_hand() {
    let (_, trace) = traced("straight");
    let expected = Cost { instructions: 14, plain: 49, pessimistic: 55 };
    assert_eq!(trace.ticks.len(), 200);
    assert!(trace.ticks.iter().all(|tick| total(tick) == expected), "{:?}", trace.ticks[0]);
}

/// Route two: the whole run's counts at each address against the sum over the ticks.
#[test]
fn counts_by_address_add_up_to_the_ticks() {
    let (image, trace) = traced("straight");
    let f = image.function_named("straight").expect("function");
    let executed: u64 = trace.sites.range(f.start..f.end).map(|(_, s)| s.executed).sum();
    let in_ticks: u64 = trace.ticks.iter().map(|tick| total(tick).instructions).sum();
    assert_eq!(executed, in_ticks);
    // CBZ never goes, the NOP that B jumps over is never reached.
    let one_sided = trace.one_sided(&image, f.start..f.end);
    assert_eq!(one_sided, [(f.start + 0x22, Site { executed: 200, taken: 0 })]);
    assert!(!trace.sites.contains_key(&(f.start + 0x26)));
    assert_eq!(trace.sites[&(f.start + 0x24)], Site { executed: 200, taken: 200 });
}

#[test]
fn stages_come_from_the_debug_information() {
    let (_, trace) = traced("demo::tick");
    for figure in [|c: &Cost| c.instructions, |c: &Cost| c.plain, |c: &Cost| c.pessimistic] {
        println!(
            "law {:?} link {:?} none {:?} all {:?}",
            trace.spread(|s| s == LAW, figure),
            trace.spread(|s| s == LINK, figure),
            trace.spread(|s| s == STAGES.len(), figure),
            trace.spread(|_| true, figure)
        );
    }
    let law = trace.spread(|s| s == LAW, |c| c.plain);
    assert!(law.min < law.max, "the root's iterations differ");
}

/// Route two: executions of the link's own addresses, and one call of the routine that it shares with the tick.
#[test]
fn a_shared_routine_counts_for_its_caller() {
    let (image, trace) = traced("demo::tick");
    let attributed = stage::attribute(&image, STAGES).expect("stages");
    let own = attributed.iter().filter(|(_, stage)| *stage == Some(LINK));
    let own: u64 = own.filter_map(|(at, _)| trace.sites.get(at)).map(|s| s.executed).sum();
    let mix = image.function_named("demo::mix").expect("mix");
    let shared: Vec<u64> = trace.sites.range(mix.start..mix.end).map(|(_, s)| s.executed).collect();
    assert!(shared.len() > 4 && shared.iter().all(|&n| n == 400), "{shared:?}");
    let link = trace.spread(|s| s == LINK, |c| c.instructions);
    assert_eq!((link.min, link.max), (own / 200 + shared.len() as u64, link.min));
}

#[test]
fn the_innermost_named_function_is_the_stage() {
    let image = demo();
    let count = |stages: &[Stage], index| {
        let found = stage::attribute(&image, stages).expect("stages");
        found.iter().filter(|(_, stage)| *stage == Some(index)).count()
    };
    let (law, root): (Stage, Stage) = (("law", &["demo::law"]), ("root", &["demo::law::root"]));
    assert!(count(&[root], 0) > 20);
    assert_eq!(count(&[root, law], 0), count(&[root], 0));
    assert_eq!(count(&[root, law], 1) + count(&[root], 0), count(&[law], 0));
    // Inlined into law::step, which encloses it.
    let step: Stage = ("step", &["demo::law::step"]);
    assert_eq!(count(&[root, step], 0), count(&[root], 0));
}

/// Route two: the deepest byte that the run touched, of stack painted beforehand. By hand: when the tick comes, Reset
/// holds nothing, `main` and the entry function eight bytes each (r7, lr), and the exception frame is the basic one of
/// 32 bytes, as no float is live there.
#[test]
fn the_stack_bound_covers_the_painted_stack() {
    let image = demo();
    let output = emulator(&image).output().expect("emulator");
    let touched = values(&String::from_utf8_lossy(&output.stdout), "stack ")[0] as u32;
    let of = |name: &str| {
        let start = image.function_named(name).expect("root").start;
        stack::bound(&image, start, &[]).expect("bound")
    };
    let (reset, tick) = (of("Reset"), of("SysTick"));
    let bound = stack::nested_bytes(&reset, &[&tick]);
    println!("reset {reset:?} tick {tick:?} touched {touched} bound {bound}");
    assert_eq!(touched, 8 + 8 + 32 + tick.bytes);
    assert!(touched <= bound);
}

#[test]
fn what_cannot_be_bounded_is_refused_by_name() {
    let image = demo();
    for (name, why) in [
        ("PendSV", "calls or jumps through a register"),
        ("SVCall", "sets the stack pointer"),
        ("DebugMonitor", "is recursive"),
        ("UsageFault", "returns before it has popped all"),
        ("BusFault", "moves the stack pointer under a condition"),
    ] {
        let start = image.function_named(name).expect("handler").start;
        let refusal = stack::bound(&image, start, &[]).expect_err(name);
        assert!(refusal.starts_with(name) && refusal.contains(why), "{refusal}");
    }
    let start = image.function_named("PendSV").expect("handler").start;
    let told = stack::bound(&image, start, &[("PendSV", &["straight"])]).expect("bound");
    assert_eq!(told.path, ["PendSV", "straight"]);
    // r4, r6, r7, lr and two words; r4 and lr.
    assert_eq!(told.bytes, 24 + 8);
}

/// By hand: two registers pushed, then 40 bytes on the second arm of the jump table, more than the 20 after it.
#[test]
fn a_jump_table_and_a_conditional_return_are_followed() {
    let image = demo();
    let start = image.function_named("NonMaskableInt").expect("handler").start;
    assert_eq!(stack::bound(&image, start, &[]).expect("bound").bytes, 8 + 40);
}

/// By hand: five registers pushed, and three words more where the condition does not return.
#[test]
fn an_epilogue_under_a_condition_is_followed_both_ways() {
    let image = demo();
    let start = image.function_named("MemoryManagement").expect("handler").start;
    assert_eq!(stack::bound(&image, start, &[]).expect("bound").bytes, 20 + 12);
}
