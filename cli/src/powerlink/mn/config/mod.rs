//! The network file of a managing node.

mod check;
mod places;

use std::path::Path;

use powerlink_core::NodeId;
use powerlink_core::dictionary::ObjectAddress;
use powerlink_core::managing::{Config, NodePlan, ObjectWrite};
use powerlink_core::pdo::MappingEntry;

use crate::scenario::{STANDARD_INPUT, ScenarioError, standard_input, toml_text};
use places::Places;

/// What the file says. The help of the command is its reference.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Network {
    /// With an address of nobody, until the interface is known.
    pub(super) config: Config,
    pub(super) nodes: Vec<Node>,
    pub(super) places: Places,
}

/// A node of the network, with everything that its plan borrows.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Node {
    plan: NodePlan<'static>,
    map_outputs: Vec<MappingEntry>,
    map_inputs: Vec<MappingEntry>,
    writes: Vec<Write>,
    /// The process data of its PReq.
    pub(super) outputs: Vec<u8>,
}

#[derive(Clone, PartialEq, Eq, Debug)]
struct Write {
    at: ObjectAddress,
    data: Vec<u8>,
    may_fail: bool,
}

impl Network {
    pub(super) fn load(path: &Path) -> Result<Self, ScenarioError> {
        let (file, bytes) = match path == Path::new("-") {
            true => (STANDARD_INPUT.into(), standard_input()),
            false => (path.display().to_string(), std::fs::read(path)),
        };
        check::parse(&file, &toml_text(&file, "network", bytes)?)
    }

    /// What is written to each node, for [`plans`](Self::plans).
    pub(super) fn writes(&self) -> Vec<Vec<ObjectWrite<'_>>> {
        self.nodes.iter().map(Node::writes).collect()
    }

    pub(super) fn plans<'p>(&'p self, writes: &'p [Vec<ObjectWrite<'p>>]) -> Vec<NodePlan<'p>> {
        let plan = |(node, writes): (&'p Node, &'p Vec<ObjectWrite<'p>>)| NodePlan {
            outputs: &node.map_outputs,
            inputs: &node.map_inputs,
            writes,
            ..node.plan
        };
        self.nodes.iter().zip(writes).map(plan).collect()
    }
}

impl Node {
    pub(super) const fn id(&self) -> NodeId {
        self.plan.node
    }

    fn writes(&self) -> Vec<ObjectWrite<'_>> {
        self.writes
            .iter()
            .map(|write| ObjectWrite { at: write.at, data: &write.data, may_fail: write.may_fail })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use core::time::Duration;

    use super::check::parse;
    use super::*;

    #[test]
    fn the_network_in_the_readme_is_one() {
        let readme = include_str!("../../../../../README.md");
        let (_, rest) = readme.split_once("<!-- network.toml -->\n```text\n").unwrap();
        let (text, _) = rest.split_once("```").unwrap();
        let network = parse("network.toml", text).unwrap();
        let writes = network.writes();
        let plans = network.plans(&writes);
        assert_eq!((plans[0].output_len(), plans[0].device_type), (1, Some(0x000F_0191)));
        assert_eq!(
            (plans[0].writes[0].data, &network.nodes[0].outputs[..]),
            (&50_000_000_u32.to_le_bytes()[..], &[0x5A][..])
        );
        assert_eq!(plans[0].pres_timeout, Duration::from_millis(2));
    }

    /// The keys of the network, and those of a node that have a default.
    #[test]
    fn the_help_gives_the_defaults() {
        let help = include_str!("../network-file.txt");
        let (defaults, others) = help.split_once("  # What follows has no default.\n").unwrap();
        let told = parse("help", defaults).unwrap();
        let empty = parse("empty", "[[node]]\nnode = 1\n").unwrap();
        assert_eq!((told.config, told.nodes), (empty.config, empty.nodes));
        let whole = parse("help", &format!("{defaults}{others}")).unwrap();
        assert_eq!(whole.nodes[0].writes.len(), 3);
    }

    #[test]
    fn nodes_have_some_cycles_to_follow_and_to_answer() {
        let waits = |text: &str| {
            let config = parse("a.toml", text).unwrap().config;
            (config.command_timeout.as_millis(), config.sdo_timeout.as_millis())
        };
        let node = "[[node]]\nnode = 1\n";
        assert_eq!(waits(node), (500, 1_000));
        assert_eq!(waits(&format!("cycle = \"80ms\"\n{node}")), (800, 1_000));
        assert_eq!(waits(&format!("cycle = \"1s\"\n{node}")), (10_000, 10_000));
        let multiplexed = format!("cycle = \"100ms\"\nmultiplexed_cycles = 3\n{node}");
        assert_eq!(waits(&multiplexed), (3_000, 3_000));
        assert_eq!(waits(&format!("cycle = \"1s\"\nsdo_timeout = \"2s\"\n{node}")), (10_000, 2_000));
    }

    #[test]
    fn objects_follow_one_another_unless_an_offset_is_given() {
        let text = "[[node]]\nnode = 1\nmap_inputs = [{ object = \"0x6000/1\", bits = 8 }, { object = \"0x6401/1\", bits = 16 }, \
                    { object = \"0x6000/2\", bits = 8, offset = 64 }]";
        let network = parse("a.toml", text).unwrap();
        let offsets: Vec<u16> = network.nodes[0].map_inputs.iter().map(|entry| entry.offset).collect();
        assert_eq!(offsets, [0, 8, 64]);
    }

    /// 0x1C14, before what the file writes itself.
    #[test]
    fn every_node_gets_a_tolerance_for_late_socs_unless_the_file_says_0s() {
        let writes = |network: &str, node: &str| {
            let text = format!("{network}[[node]]\nnode = 1\n{node}");
            parse("a.toml", &text).map(|network| network.nodes[0].writes.clone())
        };
        let tolerance = |nanos: u32| Write {
            at: ObjectAddress::new(0x1C14, 0),
            data: nanos.to_le_bytes().to_vec(),
            may_fail: true,
        };
        let (whole, one) = ("loss_of_soc_tolerance = \"2ms\"\n", "loss_of_soc_tolerance = \"3ms\"\n");
        assert_eq!(writes("", "").unwrap(), [tolerance(50_000_000)]);
        assert_eq!(writes(whole, "").unwrap(), [tolerance(2_000_000)]);
        assert_eq!(writes(whole, one).unwrap(), [tolerance(3_000_000)]);
        assert_eq!(writes("", "loss_of_soc_tolerance = \"0s\"").unwrap(), []);
        assert_eq!(writes("loss_of_soc_tolerance = \"0s\"\n", one).unwrap(), [tolerance(3_000_000)]);
        let own = "write = [{ object = \"0x1C14/0\", value = 7, size = 4 }]";
        assert_eq!(writes("", own).unwrap()[1].data, [7, 0, 0, 0]);
        assert!(writes("loss_of_soc_tolerance = \"5s\"\n", "").is_err());
    }

    #[test]
    fn values_are_little_endian_and_may_be_negative() {
        let data = |write: &str| {
            let text = format!("[[node]]\nnode = 1\nwrite = [{{ object = \"0x2000/1\", {write} }}]");
            parse("a.toml", &text).map(|network| network.nodes[0].writes[1].data.clone())
        };
        assert_eq!(data("value = 0x0102, size = 4").unwrap(), [2, 1, 0, 0]);
        assert_eq!(data("value = -2, size = 2").unwrap(), [0xFE, 0xFF]);
        assert_eq!(data("data = \"0102\"").unwrap(), [1, 2]);
        assert!(data("value = 65536, size = 2").is_err() && data("value = -32769, size = 2").is_err());
    }
}
