//! A node and a managing node by hand: what is sent, heard and shown, in the order of time.

mod bench;
mod boot;
mod commands;
mod errors;
mod objects;
