//! Gives each board's binary its linker script and its own memory map.

use std::env;
use std::path::Path;

fn main() {
    let root = env::var("CARGO_MANIFEST_DIR").expect("cargo sets the manifest's directory");
    let root = Path::new(&root);
    // The emulated board's map is the workspace's; a real board's lies beside its file. The linker runs in
    // the workspace and looks for `memory.x` there first, so the latter is named by its whole path.
    if env::var_os("CARGO_FEATURE_MPS2_AN386").is_some() {
        link("mps2-an386", &root.join(".."));
        let vectors = root.join("src/bin/mps2_an386");
        println!("cargo:rustc-link-arg-bin=mps2-an386=-L{}", vectors.display());
        println!("cargo:rerun-if-changed={}", vectors.join("device.x").display());
    }
    if env::var_os("CARGO_FEATURE_NUCLEO_F446RE").is_some() {
        for script in ["memory.x", "sections.x"] {
            let script = root.join("src/bin/nucleo_f446re").join(script);
            println!("cargo:rustc-link-arg-bin=nucleo-f446re=-T{}", script.display());
            println!("cargo:rerun-if-changed={}", script.display());
        }
    }
}

fn link(binary: &str, map: &Path) {
    println!("cargo:rustc-link-arg-bin={binary}=-L{}", map.display());
    println!("cargo:rustc-link-arg-bin={binary}=-Tlink.x");
    println!("cargo:rerun-if-changed={}", map.join("memory.x").display());
}
