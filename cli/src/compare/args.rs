//! `devicenet compare` on the command line.

use std::path::PathBuf;

use clap::Args;
use link_core::BitRate;

use super::Plan;

/// `devicenet compare`.
#[derive(Args, Clone, Debug)]
#[command(after_long_help = "\
DeviceNeX is DeviceNet over 29-bit identifiers, after the paper of Tang and McLaughlin. Here both run on the same simulated bus, \
which is exact to the bit, with the same bit rate, the same devices and two bytes of I/O. Every figure is measured in these \
networks; what contradicts the paper is said.

Exit codes:
  0  every claim holds
  1  some claim does not
  2  wrong usage, or the picture cannot be written

Examples:
  devicenet compare
  devicenet compare --bit-rate 125k --devices 20
  devicenet compare --svg compare.svg
  devicenet compare --json | jq -c 'select(.holds | not) | [.claim, .finding]'")]
pub struct CompareArgs {
    /// The bit rate of both networks: 125k, 250k or 500k
    #[arg(long, value_name = "RATE", value_parser = parse_bit_rate, default_value = "500k")]
    pub bit_rate: BitRate,
    /// Devices beside the master or manager, 3 to 63
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(3..=63), default_value_t = 63)]
    pub devices: u8,
    /// The seed of the moments at which something happens
    #[arg(long, value_name = "N", value_parser = crate::args::parse_seed, allow_hyphen_values = true, default_value_t = 1)]
    pub seed: u64,
    /// Draw the figures
    #[arg(long, value_name = "FILE")]
    pub svg: Option<PathBuf>,
}

impl CompareArgs {
    pub(super) const fn plan(&self) -> Plan {
        Plan { bit_rate: self.bit_rate, devices: self.devices, seed: self.seed }
    }
}

fn parse_bit_rate(text: &str) -> Result<BitRate, String> {
    let rate = crate::args::parse_bit_rate(text).map(BitRate);
    rate.ok()
        .filter(|rate| [BitRate::K125, BitRate::K250, BitRate::K500].contains(rate))
        .ok_or_else(|| "125k, 250k or 500k expected: devices find no other".to_owned())
}
