//! Both state machines, row by row, and what can be set.

use super::*;
use crate::code::{AttributeId, GeneralStatus, InstanceId};
use crate::codec::Writer;
use link_core::machine_laws;
use std::cell::RefCell;
use std::collections::HashSet;
use std::string::ToString;
use std::vec::Vec;

std::thread_local! {
    static IO: RefCell<HashSet<IoEdge>> = RefCell::default();
    static EXPLICIT: RefCell<HashSet<ExplicitEdge>> = RefCell::default();
}

pub(super) fn record_io(edge: IoEdge) {
    IO.with_borrow_mut(|edges| edges.insert(edge));
}

pub(super) fn record_explicit(edge: ExplicitEdge) {
    EXPLICIT.with_borrow_mut(|edges| edges.insert(edge));
}

const CAUSES: [IoCause; 9] = [
    IoCause::Served,
    IoCause::PacketRateSet,
    IoCause::Applied,
    IoCause::Reset,
    IoCause::Message,
    IoCause::WatchdogExpired,
    IoCause::Released,
    IoCause::ExplicitGone,
    IoCause::NetworkLost,
];

const EXPLICIT_CAUSES: [ExplicitCause; 9] = [
    ExplicitCause::Opened,
    ExplicitCause::Message,
    ExplicitCause::PacketRateSet,
    ExplicitCause::Reset,
    ExplicitCause::WatchdogExpired { io_established: false },
    ExplicitCause::WatchdogExpired { io_established: true },
    ExplicitCause::IoEnded,
    ExplicitCause::Released,
    ExplicitCause::NetworkLost,
];

fn configuring() -> IoConnection {
    let mut connection = IoConnection::NON_EXISTENT;
    connection.allocate(PredefinedConnection::Poll).unwrap();
    connection
}

fn established(action: WatchdogAction) -> IoConnection {
    let mut connection = configuring();
    connection.set_watchdog_action(action).unwrap();
    let _ = connection.set_packet_rate(75, TimerResolution::DEFAULT).unwrap();
    connection
}

fn timed_out() -> IoConnection {
    let mut connection = established(WatchdogAction::TRANSITION_TO_TIMED_OUT);
    let _ = connection.handle(IoCause::WatchdogExpired).unwrap();
    connection
}

fn io_states() -> [IoConnection; 6] {
    [
        IoConnection::NON_EXISTENT,
        configuring(),
        established(WatchdogAction::TRANSITION_TO_TIMED_OUT),
        established(WatchdogAction::AUTO_DELETE),
        established(WatchdogAction::AUTO_RESET),
        timed_out(),
    ]
}

fn opened() -> ExplicitConnection {
    let mut connection = ExplicitConnection::NON_EXISTENT;
    let waits = connection.handle(ExplicitCause::Opened);
    assert_eq!(waits.map(|watchdog| millis(watchdog, connection.settings())), Ok(Some(10_000)));
    connection
}

fn millis(watchdog: Watchdog, settings: &Settings) -> Option<u32> {
    watchdog.millis(settings.expected_packet_rate(), settings.multiplier())
}

fn deferred() -> ExplicitConnection {
    let mut connection = opened();
    connection.set_watchdog_action(WatchdogAction::DEFERRED_DELETE).unwrap();
    let expired = connection.handle(ExplicitCause::WatchdogExpired { io_established: true });
    assert_eq!(expired, Ok(Watchdog::Stop));
    connection
}

/// Everything in every state: each step is in the table (debug builds check it), and each row of the table is taken.
#[test]
fn every_edge_is_reached_and_no_other() {
    for connection in io_states() {
        for cause in CAUSES {
            let _ = connection.clone().handle(cause);
        }
        let _ = connection.clone().allocate(PredefinedConnection::Poll);
    }
    for connection in [ExplicitConnection::NON_EXISTENT, opened(), deferred()] {
        for cause in EXPLICIT_CAUSES {
            let _ = connection.clone().handle(cause);
        }
    }
    IO.with_borrow(|taken| machine_laws::every_edge_was_taken(IO_EDGES, taken, |edge| *edge));
    EXPLICIT.with_borrow(|taken| machine_laws::every_edge_was_taken(EXPLICIT_EDGES, taken, |edge| *edge));
}

/// The tables in the documentation are the tables in the code.
#[test]
fn the_documentation_shows_the_tables() {
    let documented = |source: &str, rendered: &[std::string::String]| {
        let rows: Vec<_> = source
            .lines()
            .filter_map(|line| line.strip_prefix("/// | "))
            .filter(|row| !row.starts_with("From |"))
            .collect();
        assert_eq!(rows.len(), rendered.len());
        for (row, edge) in rows.iter().zip(rendered) {
            assert!(std::format!("| {row}").starts_with(edge.as_str()), "{row} is not {edge}");
        }
    };
    let io: Vec<_> = IO_EDGES.iter().map(ToString::to_string).collect();
    documented(include_str!("io_state.rs"), &io);
    let explicit: Vec<_> = EXPLICIT_EDGES.iter().map(ToString::to_string).collect();
    documented(include_str!("explicit_state.rs"), &explicit);
}

#[test]
fn services_are_refused_by_state() {
    let refusals = |connection: &IoConnection| {
        [IoCause::Reset, IoCause::Applied, IoCause::Released]
            .map(|cause| connection.clone().handle(cause).err())
    };
    let (gone, conflict) =
        (Some(GeneralStatus::OBJECT_DOES_NOT_EXIST), Some(GeneralStatus::OBJECT_STATE_CONFLICT));
    assert_eq!(refusals(&IoConnection::NON_EXISTENT), [gone; 3]);
    assert_eq!(refusals(&configuring()), [conflict, None, None]);
    assert_eq!(refusals(&established(WatchdogAction::AUTO_DELETE)), [None, conflict, None]);
    assert_eq!(refusals(&timed_out()), [None, conflict, None]);
    let again = established(WatchdogAction::AUTO_DELETE).allocate(PredefinedConnection::Poll);
    assert_eq!(again, Err(GeneralStatus::ALREADY_IN_REQUESTED_STATE));
}

#[test]
fn the_first_message_has_ten_seconds_and_the_following_four_rates() {
    let mut connection = configuring();
    assert_eq!(connection.handle(IoCause::Message), Ok(Watchdog::Keep));
    let mut set = |millis_asked: u16| {
        let (used, watchdog) = connection.set_packet_rate(millis_asked, TimerResolution::DEFAULT).unwrap();
        let first = millis(watchdog, connection.settings());
        let then = [IoCause::Message, IoCause::PacketRateSet, IoCause::Reset]
            .map(|cause| millis(connection.handle(cause).unwrap(), connection.settings()));
        (used, first, then)
    };
    assert_eq!(set(75), (80, Some(10_000), [Some(320); 3]));
    assert_eq!(set(3594), (3600, Some(14_400), [Some(14_400); 3]));
    assert_eq!(set(0), (0, None, [None; 3]));
    let mut applied = configuring();
    let watchdog = applied.handle(IoCause::Applied).unwrap();
    assert_eq!(millis(watchdog, applied.settings()), None, "the rate is 0 until it is set");
    assert_eq!(applied.state(), IoState::Established);
}

#[test]
fn without_acknowledges_nothing_is_missed() {
    for kind in [
        PredefinedConnection::ChangeOfState { acknowledged: false },
        PredefinedConnection::Cyclic { acknowledged: false },
    ] {
        let mut connection = IoConnection::NON_EXISTENT;
        connection.allocate(kind).unwrap();
        assert_eq!(connection.set_packet_rate(100, TimerResolution::DEFAULT), Ok((100, Watchdog::Stop)));
        assert_eq!(connection.handle(IoCause::Reset), Ok(Watchdog::Stop));
    }
}

#[test]
fn a_connection_that_timed_out_keeps_a_new_rate_for_its_reset() {
    let mut connection = timed_out();
    let set = connection.set_packet_rate(20, TimerResolution::DEFAULT);
    assert_eq!((set, connection.state()), (Ok((20, Watchdog::Keep)), IoState::TimedOut));
    let reset = connection.handle(IoCause::Reset);
    assert_eq!(reset.map(|watchdog| millis(watchdog, connection.settings())), Ok(Some(80)));
    let mut connection = timed_out();
    connection.allocate(PredefinedConnection::BitStrobe).unwrap();
    assert_eq!((connection.state(), connection.settings().expected_packet_rate()), (IoState::Configuring, 0));
}

#[test]
fn the_action_decides_about_a_time_out() {
    for (action, state, watchdog) in [
        (WatchdogAction::TRANSITION_TO_TIMED_OUT, IoState::TimedOut, Watchdog::Stop),
        (WatchdogAction::AUTO_DELETE, IoState::NonExistent, Watchdog::Stop),
        (WatchdogAction::AUTO_RESET, IoState::Established, Watchdog::Start),
    ] {
        let mut connection = established(action);
        assert_eq!(connection.handle(IoCause::WatchdogExpired), Ok(watchdog));
        assert_eq!(connection.state(), state);
    }
}

#[test]
fn actions_and_inhibit_times_out_of_range_are_refused() {
    let refused = Err(GeneralStatus::INVALID_ATTRIBUTE_VALUE);
    let mut io = configuring();
    assert_eq!(io.set_watchdog_action(WatchdogAction::DEFERRED_DELETE), refused);
    let mut explicit = opened();
    for action in [WatchdogAction::TRANSITION_TO_TIMED_OUT, WatchdogAction::AUTO_RESET, WatchdogAction(4)] {
        assert_eq!(explicit.set_watchdog_action(action), refused);
    }
    assert_eq!(io.settings_mut().set_production_inhibit_time(100), Ok(()), "any time while the rate is 0");
    assert_eq!(io.set_packet_rate(90, TimerResolution::DEFAULT).map(|_| ()), refused);
    assert_eq!(io.state(), IoState::Configuring);
    assert_eq!(io.set_packet_rate(91, TimerResolution::DEFAULT).map(|(used, _)| used), Ok(100));
    assert_eq!(io.settings_mut().set_production_inhibit_time(101), refused);
    assert_eq!(io.settings_mut().set_multiplier(TimeoutMultiplier(8)), refused);
    assert_eq!(io.set_packet_rate(65_531, TimerResolution::DEFAULT).map(|_| ()), refused);
    assert_eq!(io.settings().expected_packet_rate(), 100);
}

#[test]
fn an_explicit_connection_waits_ten_seconds_and_defers_its_end_if_it_is_told_to() {
    let mut connection = opened();
    assert_eq!(connection.handle(ExplicitCause::Message), Ok(Watchdog::Start));
    assert_eq!(connection.handle(ExplicitCause::Opened), Err(GeneralStatus::ALREADY_IN_REQUESTED_STATE));
    let mut expired = connection.clone();
    let _ = expired.handle(ExplicitCause::WatchdogExpired { io_established: true });
    assert_eq!(expired.state(), ExplicitState::NonExistent, "action 1");

    let mut deferred = deferred();
    assert_eq!(deferred.state(), ExplicitState::DeferredDelete);
    let mut revived = deferred.clone();
    assert_eq!(revived.handle(ExplicitCause::Message), Ok(Watchdog::Start));
    assert_eq!(revived.state(), ExplicitState::Established);
    let _ = revived.handle(ExplicitCause::WatchdogExpired { io_established: false });
    assert_eq!(revived.state(), ExplicitState::NonExistent, "action 3 without I/O");
    let _ = deferred.handle(ExplicitCause::IoEnded);
    assert_eq!(deferred.state(), ExplicitState::NonExistent);
    assert_eq!(deferred.handle(ExplicitCause::Opened), Ok(Watchdog::Start));
    assert_eq!(deferred.settings().watchdog_action(), WatchdogAction::AUTO_DELETE, "defaults again");

    let mut patient = opened();
    let set = patient.set_packet_rate(0, TimerResolution::DEFAULT);
    let waits = set.map(|(used, watchdog)| (used, millis(watchdog, patient.settings())));
    assert_eq!(waits, Ok((0, None)));
}

/// Konvolucio and ICP DAS print paths of assemblies in this form; the Acknowledge Handler as Omron E5AR prints it.
#[test]
fn attributes_are_read() {
    let view = established(WatchdogAction::AUTO_DELETE);
    let expected: [(u16, &[u8]); 16] = [
        (1, &[3]),
        (2, &[1]),
        (3, &[0x82]),
        (4, &[0xFF, 0x03]),
        (5, &[0xFD, 0x05]),
        (6, &[0x01]),
        (7, &[2, 0]),
        (8, &[1, 0]),
        (9, &[80, 0]),
        (12, &[1]),
        (13, &[6, 0]),
        (14, &[0x20, 0x04, 0x24, 0x65, 0x30, 0x03]),
        (15, &[4, 0]),
        (16, &[0x20, 0x2B, 0x24, 0x01]),
        (17, &[0, 0]),
        (18, &[0]),
    ];
    for (attribute, bytes) in expected {
        let mut buffer = [0xA5; 8];
        let mut out = Writer::new(&mut buffer);
        assert_eq!(view.get(AttributeId(attribute), &mut out), Ok(()), "attribute {attribute}");
        assert_eq!(out.written(), bytes, "attribute {attribute}");
    }
    for attribute in [0, 10, 11, 19, 100] {
        let read = view.get(AttributeId(attribute), &mut Writer::new(&mut [0; 8]));
        assert_eq!(read, Err(GeneralStatus::ATTRIBUTE_NOT_SUPPORTED), "attribute {attribute}");
    }
    let short = view.get(AttributeId(14), &mut Writer::new(&mut [0; 5]));
    assert_eq!(short, Err(GeneralStatus::REPLY_DATA_TOO_LARGE));
    assert_eq!((ConnectionPath::Empty.len(), ConnectionPath::Empty.is_empty()), (0, true));
}

/// Of a node 63 that produces two bytes of assembly 101.
impl ConnectionView for IoConnection {
    type Id = u16;

    fn instance_type(&self) -> InstanceType {
        self.kind().instance_type()
    }
    fn transport_class_trigger(&self) -> TransportClassTrigger {
        self.kind().transport_class_trigger()
    }
    fn comm_characteristics(&self) -> CommCharacteristics {
        self.kind().comm_characteristics()
    }
    fn state(&self) -> ConnectionState {
        self.state().into()
    }
    fn produced_id(&self) -> u16 {
        0x3FF
    }
    fn consumed_id(&self) -> u16 {
        0x5FD
    }
    fn produced_size(&self) -> u16 {
        2
    }
    fn consumed_size(&self) -> u16 {
        1
    }
    fn settings(&self) -> &Settings {
        self.settings()
    }
    fn produced_path(&self) -> ConnectionPath {
        ConnectionPath::Assembly(InstanceId(101))
    }
    fn consumed_path(&self) -> ConnectionPath {
        ConnectionPath::AcknowledgeHandler
    }
}

/// The constant layouts are what the general encoder of paths writes.
#[test]
fn paths_are_those_of_the_encoder() {
    use crate::code::{ClassId, InstanceId};
    use crate::epath::{LogicalPath, PathForm};
    let handler = LogicalPath::object(ClassId::ACKNOWLEDGE_HANDLER, InstanceId(1));
    let mut cases = std::vec![(ConnectionPath::AcknowledgeHandler, handler)];
    for instance in [1, 0xFF, 0x100, 0xFFFF].map(InstanceId) {
        let path = LogicalPath::object(ClassId::ASSEMBLY, instance).with_attribute(AttributeId(3));
        cases.push((ConnectionPath::Assembly(instance), path));
    }
    for (path, logical) in cases {
        let (mut written, mut expected) = ([0; 8], [0; 8]);
        let (mut out, mut reference) = (Writer::new(&mut written), Writer::new(&mut expected));
        path.emit(&mut out).unwrap();
        logical.emit(PathForm::Packed, &mut reference).unwrap();
        assert_eq!(out.written(), reference.written());
        assert_eq!(usize::from(path.len()), reference.written().len());
    }
}
