//! Findings in words: the one place of their text.

mod names;

use core::fmt;

use cip_core::code::ClassId;
use cip_core::monitor::text::write_status;
use cip_core::names::additional_code_name;
use cip_core::text::ByteCount;

use super::finding::{Change, ChangeKind, Exchange, Facts, Finding};
use super::rule::Rule;
use crate::id::{Identifier, MacId, Purpose};
use crate::message::DeviceState;
use names::{Asker, Controller, Master, Millis, Node, Seconds};

/// What to check next, as a plant engineer would say it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Advice {
    rule: Rule,
    node: Option<MacId>,
}

impl Rule {
    /// What to check next, of no node in particular.
    #[must_use]
    pub const fn advice(self) -> Advice {
        Advice { rule: self, node: None }
    }
}

impl Finding {
    /// What to check next.
    #[must_use]
    pub const fn advice(&self) -> Advice {
        Advice { rule: self.rule, node: self.node }
    }
}

impl fmt::Display for Advice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, piece) in self.rule.advice_pattern().split("{node}").enumerate() {
            match (index, self.node) {
                (0, _) => {}
                (_, Some(mac)) => write!(f, "node {mac}")?,
                (_, None) => f.write_str("the node")?,
            }
            f.write_str(piece)?;
        }
        Ok(())
    }
}

/// One line: what is wrong, and with whom. Severity, times and frames are fields of the finding.
impl fmt::Display for Finding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.what(f)?;
        // What is told after several times is not counted from the first.
        let is_each_time = matches!(self.facts, Facts::Rejected { .. } | Facts::RejectedSize { .. });
        if self.count > 1 && self.subsides() && !is_each_time {
            write!(f, ", {} times", self.count)?;
        }
        match self.first_cause {
            Some(cause) => write!(f, "; first cause: {}", cause.words()),
            None => Ok(()),
        }
    }
}

/// `begins: duplicate MAC ID 10 ..`
impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.kind, self.finding)
    }
}

impl fmt::Display for ChangeKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Begins => "begins",
            Self::Escalates => "escalates",
            Self::Ends => "ends",
        })
    }
}

impl Finding {
    fn what(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let node = Node(self.node);
        match (self.rule, self.facts) {
            (Rule::NotAnswering, Facts::Silence { exchange: Exchange::ChangeOfState, patience }) => {
                write!(f, "{node} has sent no COS/cyclic message for more than {}", Millis(patience))
            }
            (Rule::NotAnswering, Facts::Silence { exchange, patience }) => {
                write!(f, "{node} has not answered its {exchange} for more than {}", Millis(patience))
            }
            (Rule::NotAnswering | Rule::NotFound, Facts::Requests { by, count }) => {
                let asker = Asker(by);
                match self.rule {
                    Rule::NotFound => {
                        write!(f, "{node} was never heard, and answers none of {count} requests{asker}")
                    }
                    _ => write!(f, "{node} answers none of {count} requests{asker}"),
                }
            }
            (Rule::SlowAnswers, Facts::Wait { longest, patience }) => {
                let (longest, patience) = (Millis(longest), Millis(patience));
                write!(
                    f,
                    "{node} answers slowly: up to {longest} of the {patience} after which its peer gives up"
                )
            }
            (Rule::MasterSilent, Facts::Abandoned { slave, slaves }) => {
                match self.node {
                    Some(mac) => write!(f, "master {mac} no longer serves slave {slave}")?,
                    None => write!(f, "nobody serves slave {slave} any longer")?,
                }
                match slaves.saturating_sub(1) {
                    0 => Ok(()),
                    more => write!(f, " and {more} more"),
                }
            }
            (Rule::DuplicateMacId, Facts::Rivals { holder, rival }) => {
                f.write_str("duplicate MAC ID")?;
                if let Some(mac) = self.node {
                    write!(f, " {mac}")?;
                }
                let mut separator = ": ";
                for (device, words) in [(holder, "has it"), (rival, "wants it")] {
                    if let Some(device) = device {
                        write!(f, "{separator}{device} {words}")?;
                        separator = ", ";
                    }
                }
                Ok(())
            }
            (Rule::DuplicateMacId, Facts::Contenders { first, second }) => {
                f.write_str("duplicate MAC ID")?;
                if let Some(mac) = self.node {
                    write!(f, " {mac}")?;
                }
                write!(f, ": {first} and {second} both want it, and none has it yet")
            }
            (Rule::WaitingForRecovery, Facts::Device(device)) => {
                write!(f, "{device} has a communication fault and waits for recovery")?;
                self.node.map_or(Ok(()), |mac| write!(f, ", last heard as node {mac}"))
            }
            (Rule::Fault, Facts::Heartbeat { state, flags }) => {
                let state = DeviceState(state);
                write!(f, "{node} reports a fault in its heartbeat: {state}, fault flags 0x{flags:02X}")
            }
            (Rule::Fault, Facts::Status(status)) => {
                write!(f, "{node} reports a fault in its status: 0x{status:04X}")
            }
            (Rule::KeyMismatch, Facts::Identity { field, expected, found }) => {
                let (expected, found) = (field.value(expected), field.value(found));
                write!(f, "{node} is not the device expected: {field} {expected} expected, {found} found")
            }
            (Rule::KeyMismatch, Facts::Rejected { master, field, found }) => {
                let found = field.value(found);
                write!(
                    f,
                    "{} lets {node} go each time that it has read its {field} {found}: it expects another device",
                    Master(master)
                )
            }
            (Rule::SizeMismatch, Facts::RejectedSize { master, exchange, is_produced, found }) => {
                let verb = if is_produced { "produces" } else { "consumes" };
                write!(
                    f,
                    "{} lets {node} go each time that it has read that its {} {verb} {}: it expects another size",
                    Master(master),
                    exchange.connection(),
                    ByteCount(found.into())
                )
            }
            (Rule::IdentityChanged, Facts::Identity { field, expected, found }) => {
                let (before, found) = (field.value(expected), field.value(found));
                write!(f, "{node} is another device than before: {field} was {before}, is {found}")
            }
            (Rule::AllocationRefused, Facts::Refusal { master, choice, status, additional }) => {
                match choice {
                    Some(choice) => write!(f, "{node} refuses {choice} to {}: ", Master(master))?,
                    None => write!(f, "{node} refuses to be allocated by {}: ", Master(master))?,
                }
                write_status(f, status, additional, additional_code_name(ClassId::DEVICENET, additional))
            }
            (Rule::TwoMasters, Facts::Masters { owner, other }) => {
                write!(f, "two masters want {node}: ")?;
                match (owner, other) {
                    (Some(owner), Some(other)) => write!(f, "it belongs to {owner}, {other} wants it"),
                    (None, Some(other)) => write!(f, "{other} is refused, because another has it"),
                    (Some(owner), None) => write!(f, "it belongs to {owner}, another wants it"),
                    (None, None) => f.write_str("one is refused"),
                }
            }
            (Rule::ForeignMacId, _) => write!(f, "{node} does not belong to this network"),
            (Rule::UnexpectedAllocation, Facts::Masters { owner, other }) => {
                write!(f, "{node} was allocated by ")?;
                match other {
                    Some(other) => write!(f, "master {other}")?,
                    None => f.write_str("an unknown master")?,
                }
                owner.map_or(Ok(()), |owner| write!(f, " instead of master {owner}"))
            }
            (Rule::IdentifierCollision, Facts::Identifier(identifier)) => {
                let purpose = Identifier::new(identifier).map(Identifier::purpose);
                let what = match purpose {
                    Some(Purpose::ChangeOfState) => "messages in a rhythm that a single sender does not have",
                    Some(Purpose::ChangeOfStateAcknowledge) => "acknowledges that nothing was sent for",
                    _ => "answers that nobody has asked for",
                };
                write!(f, "identifier 0x{identifier:03X} of {node} carries {what}: a second sender")
            }
            (Rule::BusOff, Facts::BusOffCount(1)) => write!(f, "{node} tells that it was bus-off once"),
            (Rule::BusOff, Facts::BusOffCount(count)) => {
                write!(f, "{node} tells that it was bus-off {count} times")
            }
            (Rule::BusOff, _) => write!(f, "{} is bus-off", Controller(self.node)),
            (Rule::ErrorPassive, _) => write!(f, "{} is error-passive", Controller(self.node)),
            (Rule::ErrorFrames, Facts::Errors { kinds, window }) => {
                let window = Seconds(window);
                match kinds.iter().count() {
                    0 | 1 => write!(f, "frames are destroyed: up to {kinds} in {window}"),
                    _ => {
                        let total = kinds.total();
                        write!(f, "frames are destroyed: up to {total} errors in {window}: {kinds}")
                    }
                }
            }
            (Rule::NotAcknowledged, Facts::Attempts(count)) => {
                write!(f, "nobody acknowledges: {count} attempts in a row")
            }
            (Rule::ForeignTraffic, Facts::Foreign(foreign)) => {
                write!(f, "frames that are not DeviceNet's, the last with {foreign}")
            }
            (Rule::BusLoad, Facts::Load { peak_permille }) => {
                write!(f, "bus load up to {}.{} %", peak_permille / 10, peak_permille % 10)
            }
            (Rule::Overrun, Facts::Lost(0)) => f.write_str("frames were lost before they were seen"),
            (Rule::Overrun, Facts::Lost(1)) => f.write_str("1 frame was lost before it was seen"),
            (Rule::Overrun, Facts::Lost(lost)) => write!(f, "{lost} frames were lost before they were seen"),
            (Rule::WrongLength, Facts::Length { expected, found }) => {
                write!(f, "{node} sends {found} bytes of I/O data where the connection has {expected}")
            }
            (Rule::FragmentSequence, Facts::Fragments { after, found }) => {
                write!(f, "{node} sends fragment {found} of its I/O data after fragment {after}")
            }
            (Rule::Restarted, _) => write!(f, "{node} has restarted"),
            (Rule::Left, Facts::ShutdownCode(code)) => {
                write!(f, "{node} has left the network on purpose, code 0x{code:04X}")
            }
            // A rule whose facts are not its own: nothing is lost but the details.
            (rule, _) => write!(f, "{}: {node}", rule.words()),
        }
    }
}

impl Rule {
    /// The rule in a few words.
    #[must_use]
    pub const fn words(self) -> &'static str {
        match self {
            Self::NotAnswering => "stopped answering",
            Self::NotFound => "not found",
            Self::SlowAnswers => "slow answers",
            Self::MasterSilent => "master silent",
            Self::DuplicateMacId => "duplicate MAC ID",
            Self::WaitingForRecovery => "waiting for recovery",
            Self::Fault => "device fault",
            Self::KeyMismatch => "wrong device",
            Self::SizeMismatch => "wrong I/O size",
            Self::IdentityChanged => "another device",
            Self::AllocationRefused => "allocation refused",
            Self::TwoMasters => "two masters",
            Self::ForeignMacId => "foreign MAC ID",
            Self::UnexpectedAllocation => "unexpected allocation",
            Self::IdentifierCollision => "identifier collision",
            Self::BusOff => "bus-off",
            Self::ErrorPassive => "error-passive",
            Self::ErrorFrames => "error frames",
            Self::NotAcknowledged => "nobody acknowledges",
            Self::ForeignTraffic => "foreign traffic",
            Self::BusLoad => "bus load",
            Self::Overrun => "frames lost",
            Self::WrongLength => "wrong I/O length",
            Self::FragmentSequence => "I/O fragments missing",
            Self::Restarted => "restart",
            Self::Left => "left the network",
        }
    }
}
