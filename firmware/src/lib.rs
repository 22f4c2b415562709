#![no_std]
//! x
pub mod drivers;
