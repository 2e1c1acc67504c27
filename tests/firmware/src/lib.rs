#![no_std]
//! What the firmwares have in common: the loop of a driver, and a slave.

mod block;
mod driver;
mod routines;

pub use block::{Block, Server, run};
pub use driver::{drive, drive_ethernet, drive_extended};
