//! The emulated board's image with one deliberate defect, built on demand beside the ordinary one.

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Mutex, PoisonError};

use crate::board::target_folder;

const TARGET: &str = "thumbv7em-none-eabihf";
const BOARD: &str = "mps2-an386";

/// All variants are built under one name.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Builds the image with `--cfg defect="…"`, named in the board's `defect.rs`.
///
/// # Errors
/// What the compiler said where it failed.
pub fn build(defect: &str) -> Result<PathBuf, String> {
    let _turn = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    let folder = target_folder().join("variants");
    let output = Command::new(env!("CARGO"))
        .args(["rustc", "--quiet", "--release", "--package", "firmware", "--bin", BOARD])
        .args(["--features", BOARD, "--target", TARGET, "--target-dir"])
        .arg(&folder)
        .args(["--", "--cfg", &format!("defect=\"{defect}\"")])
        .output()
        .map_err(|e| e.to_string())?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned());
    }
    let image = folder.join(defect);
    std::fs::copy(folder.join(TARGET).join("release").join(BOARD), &image)
        .map_err(|e| e.to_string())?;
    Ok(image)
}
