#![no_std]
//! What the firmwares have in common: the loop of a driver, and a slave.

mod block;
mod driver;

pub use block::{Block, Server, run};
pub use driver::drive;
