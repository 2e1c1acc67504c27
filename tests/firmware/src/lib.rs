#![no_std]
//! What the firmwares have in common: the loop of a driver, a driver for a port, and a slave.

mod block;
mod chip;
mod driver;
mod routines;

pub use block::{Block, Server, ServerPort, run, run_on_port};
pub use driver::{drive, drive_ethernet, drive_extended};
