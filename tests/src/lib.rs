//! Product tests: loaders of reference data, a controller on its bench, bodies of fuzz targets, and what measures an
//! image in the emulator.

pub mod board;
pub mod closed_loop;
pub mod flow;
pub mod fuzz;
pub mod image;
pub mod it_block;
pub mod mdh;
pub mod price;
pub mod reach;
pub mod rig;
pub mod size;
pub mod stack;
pub mod stage;
pub mod thumb;
pub mod trace;
pub mod variant;
pub mod vectors;
mod vfp;
