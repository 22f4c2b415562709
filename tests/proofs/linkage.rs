//! No panic, no allocator.

use tests::board;
use tests::image::Image;
use tests::variant;

use crate::BOARDS;

/// What every image's panic handler calls and nobody defines.
const PANIC: &str = "a_panic_is_reachable";

/// Names of the global allocator's entries, its default bodies, C's and what would call them.
fn allocates(name: &str) -> bool {
    let parts = ["__rust_alloc", "__rust_realloc", "__rust_dealloc", "__rdl_", "__rg_", "alloc::"];
    let whole =
        ["malloc", "calloc", "realloc", "free", "_sbrk", "_malloc_r", "__rust_no_alloc_shim"];
    parts.iter().any(|part| name.contains(part)) || whole.contains(&name)
}

fn panics(name: &str) -> bool {
    name.contains("panic")
}

fn named(image: &Image, is_meant: impl Fn(&str) -> bool) -> Vec<&str> {
    image.symbols.iter().map(|(_, name)| name.as_str()).filter(|name| is_meant(name)).collect()
}

#[test]
fn a_reachable_panic_does_not_link() {
    let refusal = variant::build("reachable_panic").expect_err("an image with a panic");
    assert!(refusal.contains(&format!("undefined symbol: {PANIC}")), "{refusal}");
}

#[test]
fn no_image_holds_a_panic() {
    for name in BOARDS {
        let image = board::open(name);
        let found = named(&image, panics);
        assert!(found.is_empty(), "{name}: {found:?}");
    }
}

#[test]
fn no_image_holds_an_allocator() {
    for name in BOARDS {
        let image = board::open(name);
        let found = named(&image, allocates);
        assert!(found.is_empty(), "{name}: {found:?}");
        assert!(image.symbols.len() > 20, "{name} is stripped of its symbols");
    }
}

/// Route two: this test program, which does both.
#[test]
fn a_program_with_allocator_and_panics_is_found_out() {
    let path = std::env::current_exe().expect("path of the test program");
    let image = Image::open(&path).expect("a readable program");
    assert!(!named(&image, allocates).is_empty() && !named(&image, panics).is_empty());
}
