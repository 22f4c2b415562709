//! Gives each board's binary its linker script and its own memory map.

use std::env;
use std::path::Path;

fn main() {
    let root = env::var("CARGO_MANIFEST_DIR").expect("cargo sets the manifest's directory");
    let root = Path::new(&root);
    // The emulated board's map is the workspace's; a real board's lies beside its file.
    if env::var_os("CARGO_FEATURE_MPS2_AN386").is_some() {
        link("mps2-an386", &root.join(".."));
        let vectors = root.join("src/bin/mps2_an386");
        println!("cargo:rustc-link-arg-bin=mps2-an386=-L{}", vectors.display());
        println!("cargo:rerun-if-changed={}", vectors.join("device.x").display());
    }
}

fn link(binary: &str, map: &Path) {
    println!("cargo:rustc-link-arg-bin={binary}=-L{}", map.display());
    println!("cargo:rustc-link-arg-bin={binary}=-Tlink.x");
    println!("cargo:rerun-if-changed={}", map.join("memory.x").display());
}
