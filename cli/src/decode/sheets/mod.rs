//! Electronic Data Sheets beside a recording: what values of parameters and pieces of I/O data are called, and what they mean.

mod naming;

use core::fmt;
use std::collections::HashMap;

use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode, VendorId};
use cip_core::eds::{Eds, Severity};
use cip_core::scan::IoType;
use devicenet_core::MacId;
use devicenet_core::monitor::{Fields, Kind, Monitor, NodeRecord, Predefined, Reading};

use crate::args::EdsFile;
use crate::eds;
use crate::exit::Failure;
use crate::output;
use crate::text::{count, printable};
use naming::Flow;
pub(super) use naming::Named;

/// The files, and which node of which bus each is for.
#[derive(Default)]
pub struct Sheets {
    files: Vec<Sheet>,
    /// Nodes that the command line gives a file.
    fixed: HashMap<u8, usize>,
    nodes: HashMap<(usize, u8), Node>,
}

/// A file.
struct Sheet {
    name: String,
    eds: Eds,
    is_used: bool,
    /// Paths of parameters.
    params: HashMap<(ClassId, InstanceId, AttributeId), u16>,
}

/// What is known of a node besides what the monitor knows.
#[derive(Default)]
pub(super) struct Node {
    sheet: Option<usize>,
    /// Paths of predefined connections that were read or written.
    paths: HashMap<(Predefined, Flow), Vec<u8>>,
    /// The last value of each parameter, for those that are scaled by others.
    values: HashMap<u16, i128>,
}

/// What the values in a message are.
pub(super) struct Note<'a> {
    pub(super) file: &'a str,
    pub(super) values: Vec<Named>,
}

impl Sheets {
    /// Reads the files of the command line.
    ///
    /// # Errors
    /// [`Failure::Usage`] when one cannot be read, or two are for one node.
    pub fn read(files: &[EdsFile]) -> Result<Self, Failure> {
        let mut sheets = Self::default();
        for EdsFile { mac, path } in files {
            let eds = eds::read_sheet(path)?;
            let name = path.display().to_string();
            let errors = eds.diagnostics().iter().filter(|found| found.severity() == Severity::Error).count();
            if errors > 0 {
                let errors = count(errors as u64, "error");
                output::note(format_args!("{name}: {errors}, which `devicenet eds check` tells"));
            }
            if let Some(mac) = mac
                && sheets.fixed.insert(*mac, sheets.files.len()).is_some()
            {
                return Err(Failure::Usage(format!("--eds: two files for node {mac}, leave one out")));
            }
            sheets.files.push(Sheet::new(name, eds));
        }
        Ok(sheets)
    }

    /// Tells a new monitor what the bus does not: sizes of I/O.
    pub(super) fn prepare(&self, monitor: &mut Monitor) {
        for (&mac, &index) in &self.fixed {
            let (Ok(mac), Ok(entry)) = (MacId::try_from(mac), self.files[index].eds.scan_entry()) else {
                continue;
            };
            for connection in &entry.connections {
                let (consumed, produced) = (connection.consumed.size, connection.produced.size);
                // What a bit-strobe command carries is no data of one slave.
                let consumed = Some(consumed).filter(|_| connection.ty != IoType::BitStrobe);
                monitor.set_io_sizes(mac, predefined(connection.ty), consumed, Some(produced));
            }
        }
    }

    /// Learns from a frame, and says what its values are.
    pub(super) fn observe(&mut self, bus: usize, reading: &Reading<'_>) -> Option<Note<'_>> {
        if self.files.is_empty() {
            return None;
        }
        let (kind, fields, value) = match &reading.message {
            Some(message) => (message.kind, &message.fields, message.value()),
            None => (reading.kind, &reading.fields, reading.value()),
        };
        let flow = flow_of(kind, fields)?;
        let is_from_slave = matches!(flow, Flow::Produced | Flow::Answer);
        let mut mac = if is_from_slave { reading.src } else { reading.dst };
        let mut flow = flow;
        // A change-of-state message can be of the master; then it is the destination that has the file.
        if kind == Kind::CosCyclic && mac.is_some_and(|mac| self.sheet_of(bus, mac).is_none()) {
            (mac, flow) = (reading.dst, Flow::Consumed);
        }
        let mac = mac?;
        if kind == Kind::DupMacRequest {
            self.restarted(bus, mac, fields.vendor);
            return None;
        }
        let value = value?;
        let index = self.sheet_of(bus, mac)?;
        let node = self.nodes.entry((bus, mac.number())).or_default();
        let Sheet { name, eds, params, is_used } = &mut self.files[index];
        let values = match flow {
            Flow::Answer | Flow::Order => naming::attribute(eds, params, node, fields, value),
            Flow::Produced | Flow::Consumed => naming::io(eds, node, kind, flow, value),
        };
        *is_used |= !values.is_empty();
        (!values.is_empty()).then_some(Note { file: name, values })
    }

    /// The node whose identity a frame may have told.
    pub(super) fn identified(&self, reading: &Reading<'_>) -> Option<MacId> {
        let fields = reading.message.as_ref().map_or(&reading.fields, |message| &message.fields);
        reading.src.filter(|_| !self.files.is_empty() && fields.explicit.class == Some(ClassId::IDENTITY))
    }

    /// Gives a node the file of its identity.
    pub(super) fn identify(&mut self, bus: usize, record: &NodeRecord) {
        let (Some(vendor), Some(ty), Some(product)) = (record.vendor, record.device_type, record.product)
        else {
            return;
        };
        let is_for = |sheet: &Sheet| {
            let device = sheet.eds.device();
            device.vendor == Some(vendor)
                && device.device_type == Some(ty)
                && device.product_code == Some(product)
        };
        // A file that the command line gives to a node is for that node only.
        let is_free = |index: &usize| !self.fixed.values().any(|fixed| fixed == index);
        let matching = (0..self.files.len()).filter(is_free).find(|&index| is_for(&self.files[index]));
        if let Some(index) = matching {
            self.nodes.entry((bus, record.mac.number())).or_default().sheet = Some(index);
        }
    }

    /// Says which files were for nothing.
    pub(super) fn finish(&self) {
        for (index, Sheet { name, .. }) in self.files.iter().enumerate().filter(|(_, sheet)| !sheet.is_used) {
            match self.fixed.iter().find(|(_, fixed)| **fixed == index) {
                Some((mac, _)) => output::note(format_args!(
                    "{name}: names nothing in the recording, no parameter and no I/O data of node {mac}"
                )),
                None => output::note(format_args!(
                    "{name}: names nothing in the recording, where no device was seen to be of its vendor, device type \
                     and product code; if it is for node 10, say `--eds 10={name}`"
                )),
            }
        }
    }

    fn sheet_of(&self, bus: usize, mac: MacId) -> Option<usize> {
        let found = self.nodes.get(&(bus, mac.number())).and_then(|node| node.sheet);
        self.fixed.get(&mac.number()).copied().or(found)
    }

    /// A node checks its MAC ID: none of its connections exists any more, and one of another vendor is another device.
    fn restarted(&mut self, bus: usize, mac: MacId, vendor: Option<VendorId>) {
        let Some(node) = self.nodes.get_mut(&(bus, mac.number())) else { return };
        node.paths.clear();
        if let Some(index) = node.sheet
            && vendor.is_some()
            && self.files[index].eds.device().vendor != vendor
        {
            *node = Node::default();
        }
    }
}

impl Sheet {
    fn new(name: String, eds: Eds) -> Self {
        let mut params = HashMap::new();
        for param in eds.params() {
            // Every parameter can also be reached as an instance of the Parameter object.
            params.insert((ClassId::PARAMETER, InstanceId(param.number), AttributeId(1)), param.number);
        }
        for param in eds.params() {
            if let Some(target) = param.target()
                && let (Some(class), Some(instance), Some(attribute)) =
                    (target.class, target.instance, target.attribute)
            {
                params.insert((class, instance, attribute), param.number);
            }
        }
        Self { name, eds, is_used: false, params }
    }
}

/// `  [Input filter: 0.8 ms; State: Run (1)]`, without the control characters that a file may have.
impl fmt::Display for Note<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut separator = "  [";
        for Named { name, text, .. } in &self.values {
            write!(f, "{separator}{}: {}", printable(name), printable(text))?;
            separator = "; ";
        }
        f.write_str("]")
    }
}

/// Which way values go in a message, if there can be any.
fn flow_of(kind: Kind, fields: &Fields) -> Option<Flow> {
    match kind {
        Kind::ExplicitRequest if fields.explicit.service == Some(ServiceCode::SET_ATTRIBUTE_SINGLE) => {
            Some(Flow::Order)
        }
        Kind::ExplicitResponse if fields.explicit.service == Some(ServiceCode::GET_ATTRIBUTE_SINGLE) => {
            Some(Flow::Answer)
        }
        Kind::DupMacRequest => Some(Flow::Answer),
        Kind::PollCommand => Some(Flow::Consumed),
        Kind::PollResponse | Kind::BitStrobeResponse | Kind::MulticastPollResponse | Kind::CosCyclic => {
            Some(Flow::Produced)
        }
        _ => None,
    }
}

const fn predefined(ty: IoType) -> Predefined {
    match ty {
        IoType::Poll => Predefined::Poll,
        IoType::BitStrobe => Predefined::BitStrobe,
        IoType::ChangeOfState | IoType::Cyclic => Predefined::CosCyclic,
        IoType::MulticastPoll => Predefined::MulticastPoll,
    }
}
