//! A node and a managing node by hand: what is sent, heard and shown, in the order of time.

mod aborts;
mod bench;
mod boot;
mod bytes;
mod clients;
mod commands;
mod cycle;
mod data;
mod errors;
mod faults;
mod history;
mod long_values;
mod losses;
mod objects;
mod resets;
mod sequence;
mod started;
mod time;
mod transitions;
