//! Puts the memory map where the linker finds it.
fn main() {
    let root = std::env::var("CARGO_MANIFEST_DIR").expect("cargo sets the manifest's directory");
    println!("cargo:rustc-link-search={root}");
    println!("cargo:rustc-link-arg=-Tlink.x");
    println!("cargo:rerun-if-changed=memory.x");
}
