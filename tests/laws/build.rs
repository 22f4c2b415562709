//! Links the image by the emulated board's memory map, which the linker finds in the workspace's root.

fn main() {
    println!("cargo:rustc-link-arg-bins=-Tlink.x");
    // The product's stack is too small for the recursions and for printing: this one has all of the map's RAM.
    println!("cargo:rustc-link-arg-bins=--defsym=_stack_start=ORIGIN(RAM)+LENGTH(RAM)");
    println!("cargo:rerun-if-changed=../../memory.x");
}
