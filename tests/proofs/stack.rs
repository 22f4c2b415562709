//! The stack suffices: bounded from the machine code, compared with what a run touched, guarded at its end.

use hil_sim::pil::{self, EmulatorError, PilError};
use hil_sim::scenario::Scenario;
use tests::board;
use tests::image::Image;
use tests::reach::Reach;
use tests::stack;
use tests::variant;

use crate::BOARDS;

/// Thread code preempted by each handler in turn, bytes. HardFault is left out: it empties the stack first.
pub fn worst_case_bytes(image: &Image) -> Result<u32, String> {
    let mut bounds = Vec::new();
    for (name, bound) in stack::bounds(image, &[]) {
        if name != "HardFault" {
            bounds.push(bound?);
        }
    }
    let (thread, handlers) = bounds.split_first().ok_or("no vectors")?;
    Ok(stack::nested_bytes(thread, &handlers.iter().collect::<Vec<_>>()))
}

fn paper() -> Scenario {
    Scenario::load("paper").expect("a shipped scenario")
}

#[test]
fn both_images_have_a_bound() {
    for name in BOARDS {
        let image = board::open(name);
        for (handler, bound) in stack::bounds(&image, &[]) {
            println!("{name} {handler}: {bound:?}");
        }
        println!("{name}: {} bytes at most", worst_case_bytes(&image).expect("a bound"));
    }
}

/// Route two: the painted stack after a whole run.
#[test]
fn the_bound_covers_what_a_run_touched() {
    let image = board::open("mps2-an386");
    let bound = worst_case_bytes(&image).expect("a bound");
    let verdict = pil::run(&paper(), &image.path, &|_, _| ()).expect("a run");
    let mark = u32::from(verdict.stack_bytes);
    println!("stack: at most {bound} bytes, a run touched {mark}");
    assert!(mark <= bound, "{mark} bytes touched, bound {bound}");
    // A mark that nobody painted, or a bound far beyond it, would prove nothing. Idle's deepest path and the tick's
    // need not meet in one run.
    assert!(5 * mark > 2 * bound, "{mark} bytes touched, bound {bound}");
}

/// Route two: every function on the deepest path is one that the call graph reaches.
#[test]
fn the_deepest_path_lies_in_the_call_graph() {
    for name in BOARDS {
        let image = board::open(name);
        let reach = Reach::from(&image, &image.vectors).expect("a call graph");
        let reached: Vec<_> = reach.functions().filter_map(|at| image.function_at(at)).collect();
        for (handler, bound) in stack::bounds(&image, &[]).into_iter().filter(|b| b.1.is_ok()) {
            for step in bound.expect("a bound").path {
                assert!(reached.iter().any(|f| f.name == step), "{handler}: {step}");
            }
        }
    }
}

#[test]
fn an_overflow_has_no_bound_and_faults_at_the_guard() {
    let path = variant::build("stack_overflow").expect("a variant");
    let image = Image::open(&path).expect("a readable image");
    let refusal = worst_case_bytes(&image).expect_err("recursion");
    assert!(refusal.contains("is recursive"), "{refusal}");
    let error = pil::run(&paper(), &path, &|_, _| ()).expect_err("an overflow");
    let PilError::Emulator(EmulatorError::Fault { status }) = error else { panic!("{error}") };
    // DACCVIOL: the protection unit refused a data access (Armv7-M ARM B3.2.15).
    assert!(status & 1 << 1 != 0, "{status:#x}");
}
