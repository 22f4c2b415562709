//! scratch
use tests::{board, stack};
fn main() {
    let image = board::open("mps2-an386");
    for root in ["Reset", "SysTick"] {
        let f = image.function_named(root).unwrap();
        let b = stack::bound(&image, f.start, &[]).unwrap();
        println!("{root} {} {:?}", b.bytes, b.path);
    }
    // frame of each function reachable, deepest below
    let mut v = vec![];
    for (start, f) in &image.functions {
        if let Ok(b) = stack::bound(&image, *start, &[]) {
            v.push((b.bytes, f.name.clone(), b.path));
        }
    }
    v.sort();
    v.reverse();
    for (b, n, _) in v.iter().take(70) {
        println!("{b} {}", &n[..n.len().min(110)]);
    }
}
