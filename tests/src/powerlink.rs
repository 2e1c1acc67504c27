//! A POWERLINK network on the simulated Ethernet segment: a managing node, and nodes with digital inputs and outputs.

use std::fmt::Write as _;
use std::time::Duration;

use link_core::codec::Writer;
use link_core::ethernet::{Action, Input, Machine};
use link_core::{Deadline, Instant};
use powerlink_core::dictionary::{Access, Device, Entry, Mappable, ObjectAddress, ObjectSet, ObjectType};
use powerlink_core::managing::{self, ManagingNode, MnEvent, NodePlan};
use powerlink_core::nmt::NmtState;
use powerlink_core::node::{self, NodeEvent};
use powerlink_core::pdo::MappingEntry;
use powerlink_core::wire::{AbortCode, Frame, Identity};
use powerlink_core::{ControlledNode, MacAddress, NodeId};
use transport_mock::ethernet::{Record, Segment, SegmentConfig, StationConfig, StationId};

/// The managing node of the suites.
pub type Mn = ManagingNode<'static, 32>;
/// A node of the suites.
pub type Cn = ControlledNode<Io, 36, 1024>;

/// Eight digital inputs and outputs, after CiA 401, and a text.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub struct Io {
    /// 0x6000/1
    pub inputs: u8,
    /// 0x6200/1
    pub outputs: u8,
    /// 0x2000/1
    pub text: Vec<u8>,
}

impl ObjectSet for Io {
    const ENTRIES: &'static [Entry] = &[
        Entry::new(TEXT.index, TEXT.sub, "text", ObjectType::Bytes(1000), Access::ReadWrite),
        Entry::new(0x6000, 1, "inputs", ObjectType::Unsigned(1), Access::ReadOnly).mapped(Mappable::Transmit),
        Entry::new(0x6200, 1, "outputs", ObjectType::Unsigned(1), Access::ReadWrite)
            .mapped(Mappable::Receive),
    ];

    fn read(&self, at: ObjectAddress, out: &mut Writer<'_>) -> Result<(), AbortCode> {
        let written = match at.index {
            0x6000 => out.u8(self.inputs),
            0x6200 => out.u8(self.outputs),
            _ => out.bytes(&self.text),
        };
        written.map_err(|_| AbortCode::OUT_OF_MEMORY)
    }

    fn write(&mut self, at: ObjectAddress, data: &[u8]) -> Result<(), AbortCode> {
        if at.index == 0x6200 {
            self.outputs = *data.first().ok_or(AbortCode::LENGTH)?;
        } else {
            self.text = data.to_vec();
        }
        Ok(())
    }

    fn restore(&mut self) {
        self.outputs = 0;
    }
}

/// A machine on the segment.
#[derive(Clone, PartialEq, Eq, Hash, Debug)]
pub enum Station {
    /// A managing node.
    Mn(Box<Mn>),
    /// A controlled node.
    Cn(Box<Cn>),
    /// Nothing but an adapter.
    Dead,
}

/// What one of them tells.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Event {
    /// The managing node.
    Mn(MnEvent),
    /// A controlled node.
    Cn(NodeEvent),
}

impl Machine for Station {
    type Event = Event;

    fn input(&mut self, now: Instant, input: Input<'_>) {
        match self {
            Self::Mn(mn) => mn.input(now, input),
            Self::Cn(cn) => cn.input(now, input),
            Self::Dead => {}
        }
    }

    fn poll<'b>(&mut self, now: Instant, buffer: &'b mut [u8]) -> Option<Action<'b, Event>> {
        match self {
            Self::Mn(mn) => Some(mapped(mn.poll(now, buffer)?, Event::Mn)),
            Self::Cn(cn) => Some(mapped(cn.poll(now, buffer)?, Event::Cn)),
            Self::Dead => None,
        }
    }

    fn deadline(&self) -> Option<Deadline> {
        match self {
            Self::Mn(mn) => mn.deadline(),
            Self::Cn(cn) => cn.deadline(),
            Self::Dead => None,
        }
    }
}

fn mapped<E>(action: Action<'_, E>, event: impl Fn(E) -> Event) -> Action<'_, Event> {
    match action {
        Action::Transmit(bytes) => Action::Transmit(bytes),
        Action::Event(inner) => Action::Event(event(inner)),
    }
}

/// A network.
#[derive(Debug)]
pub struct Net {
    /// The segment.
    pub segment: Segment<Station>,
    /// The managing node.
    pub mn: StationId,
    /// The controlled nodes: 1, 2, and so on.
    pub cns: Vec<StationId>,
    /// How the managing node is made anew.
    config: managing::Config,
    plans: Vec<NodePlan<'static>>,
}

impl Net {
    /// A managing node that has begun, and as many nodes with power, with a mapping by the plans of [`plan`].
    #[must_use]
    pub fn new(cns: u8) -> Self {
        Self::with(config(), &(1..=cns).map(plan).collect::<Vec<_>>(), SegmentConfig::default())
    }

    /// The same with plans of one's own; the nodes are those of the plans.
    ///
    /// # Panics
    /// If they do not fit.
    #[must_use]
    pub fn with(config: managing::Config, plans: &[NodePlan<'static>], segment: SegmentConfig) -> Self {
        let mut segment = Segment::new(segment);
        let mn = segment.add(StationConfig::named("MN"), Station::Dead);
        let cns = plans.iter().map(|plan| {
            let reaction = Duration::from_micros(5);
            let config = StationConfig { reaction, ..StationConfig::named(plan.node.to_string()) };
            segment.add(config, Station::Cn(Box::new(node(plan.node.0))))
        });
        let cns = cns.collect();
        let mut net = Self { segment, mn, cns, config, plans: plans.to_vec() };
        net.restart_mn();
        (1..=net.cns.len()).for_each(|number| net.cn(number as u8, |cn, now| cn.power_on(now)));
        net
    }

    /// Lets time pass.
    pub fn run(&mut self, millis: u64) {
        self.segment.run_for(Duration::from_millis(millis));
    }

    /// Lets time pass until every node is where it is to be. Returns whether that was within the limit.
    pub fn run_until_complete(&mut self, millis: u64) -> bool {
        let mn = self.mn;
        self.segment.run_while(Duration::from_millis(millis), |segment| match segment.machine(mn) {
            Station::Mn(mn) => !mn.is_complete(),
            Station::Cn(_) | Station::Dead => true,
        })
    }

    /// Power of the managing node fails.
    pub fn kill_mn(&mut self) {
        self.segment.replace(self.mn, Station::Dead);
    }

    /// The managing node begins anew.
    ///
    /// # Panics
    /// If the plans do not fit.
    pub fn restart_mn(&mut self) {
        let mn = ManagingNode::new(self.config, &self.plans).expect("the plans fit");
        self.segment.replace(self.mn, Station::Mn(Box::new(mn)));
        self.mn(|mn, now| mn.start(now));
    }

    /// A power cycle of a node.
    pub fn restart_cn(&mut self, number: u8) {
        self.segment.replace(self.id(number), Station::Cn(Box::new(node(number))));
        self.cn(number, |cn, now| cn.power_on(now));
    }

    /// Does something with the managing node.
    ///
    /// # Panics
    /// If it is dead.
    pub fn mn<R>(&mut self, action: impl FnOnce(&mut Mn, Instant) -> R) -> R {
        self.segment.with(self.mn, |station, now| match station {
            Station::Mn(mn) => action(mn, now),
            Station::Cn(_) | Station::Dead => panic!("there is no managing node"),
        })
    }

    /// Does something with a node.
    ///
    /// # Panics
    /// If it is dead.
    pub fn cn<R>(&mut self, number: u8, action: impl FnOnce(&mut Cn, Instant) -> R) -> R {
        let id = self.id(number);
        self.segment.with(id, |station, now| match station {
            Station::Cn(cn) => action(cn, now),
            Station::Mn(_) | Station::Dead => panic!("node {number} is dead"),
        })
    }

    /// The station of a node.
    #[must_use]
    pub fn id(&self, number: u8) -> StationId {
        self.cns[usize::from(number) - 1]
    }

    /// The states of all nodes.
    #[must_use]
    pub fn states(&self) -> Vec<NmtState> {
        let state = |id: &StationId| match self.segment.machine(*id) {
            Station::Cn(cn) => cn.state(),
            Station::Mn(_) | Station::Dead => NmtState::Off,
        };
        self.cns.iter().map(state).collect()
    }

    /// What happened, a line each: the time, who, and the words of the frame or event. Lines that say the same again are
    /// counted, and the words of process data that are alike in each cycle are left out.
    #[must_use]
    pub fn trace(&self) -> String {
        let mut text = String::new();
        let (mut last, mut again) = (String::new(), 0);
        for record in self.segment.records() {
            let (at, words) = match record {
                Record::Frame(frame) => (
                    frame.end,
                    Frame::parse(&frame.bytes)
                        .map_or_else(|error| error.to_string(), |frame| frame.to_string()),
                ),
                Record::Event {
                    event: Event::Cn(NodeEvent::StatusLed(_) | NodeEvent::ProcessData { .. }),
                    ..
                }
                | Record::Event { event: Event::Mn(MnEvent::Inputs { .. }), .. } => continue,
                Record::Event { at, station, event } => {
                    let words = match event {
                        Event::Mn(event) => event.to_string(),
                        Event::Cn(event) => event.to_string(),
                    };
                    (*at, format!("  [{}] {words}", self.segment.name(*station)))
                }
                Record::Link { at, station, event } => {
                    (*at, format!("  [{}] {event:?}", self.segment.name(*station)))
                }
            };
            if words == last {
                again += 1;
                continue;
            }
            if again > 0 {
                writeln!(text, "{:>22}", format!("({again} more)")).unwrap();
            }
            writeln!(text, "{:>12}  {words}", format!("{at:.6}")).unwrap();
            (last, again) = (words, 0);
        }
        text
    }
}

/// A managing node with a cycle of 5 ms and short waits, so that a boot is short.
#[must_use]
pub fn config() -> managing::Config {
    managing::Config {
        cycle: Duration::from_millis(5),
        wait_not_active: Duration::from_millis(50),
        wait_after_reset: Duration::from_millis(10),
        wait_pre_operational_1: Duration::from_millis(20),
        command_repeat: Duration::from_millis(25),
        async_slot: Duration::from_millis(1),
        retry_after: Duration::from_millis(500),
        sdo_timeout: Duration::from_millis(200),
        ..managing::Config::new(MN_MAC)
    }
}

/// The plan of a node of the suites: its inputs and outputs are mapped by the managing node.
#[must_use]
pub fn plan(number: u8) -> NodePlan<'static> {
    NodePlan {
        vendor_id: Some(VENDOR),
        serial_number: Some(number.into()),
        outputs: const { &[byte(0x6200)] },
        inputs: const { &[byte(0x6000)] },
        ..NodePlan::new(NodeId(number))
    }
}

/// A node without power.
///
/// # Panics
/// If the number is none of a node.
#[must_use]
pub fn node(number: u8) -> Cn {
    node_at(MacAddress([2, 0, 0, 0, 0, number]), number)
}

/// The same at another MAC address.
///
/// # Panics
/// If the number is none of a node.
#[must_use]
pub fn node_at(mac: MacAddress, number: u8) -> Cn {
    let identity =
        Identity { vendor_id: VENDOR, product_code: 7, revision: 0x0001_0000, serial_number: number.into() };
    let config = node::Config::new(NodeId(number), mac, Device::new(identity)).expect("a controlled node");
    ControlledNode::new(config, Io::default()).expect("nothing is mapped")
}

const fn byte(index: u16) -> MappingEntry {
    MappingEntry { object: ObjectAddress::new(index, 1), offset: 0, length: 8 }
}

/// A vendor that does not exist.
pub const VENDOR: u32 = 0x0123;
/// Of the managing node.
pub const MN_MAC: MacAddress = MacAddress([2, 0, 0, 0, 0, 0xF0]);
/// An object of up to 1000 bytes.
pub const TEXT: ObjectAddress = ObjectAddress::new(0x2000, 1);
