//! What a frame is.

use core::fmt;

use crate::MacAddress;
use crate::ethernet::group;
use crate::wire::{Body, MessageType, ServiceId};

/// The kind of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Kind {
    /// Start of cycle.
    Soc,
    /// Poll request.
    Preq,
    /// Poll response.
    Pres,
    /// Start of the asynchronous phase.
    Soa,
    /// Who a node is.
    AsndIdentResponse,
    /// What went wrong.
    AsndStatusResponse,
    /// A node asks for an NMT command.
    AsndNmtRequest,
    /// An NMT command.
    AsndNmtCommand,
    /// SDO.
    AsndSdo,
    /// An ASnd of another service: SyncResponse, manufacturer specific, or reserved.
    AsndOther,
    /// Of a redundant managing node.
    Amni,
    /// Asynchronous invite, EPSG DS 302-B.
    Ainv,
    /// A message type without a use.
    Reserved,
    /// Not POWERLINK: another EtherType, as nodes may send in the asynchronous phase.
    Foreign,
    /// A frame that cannot be read.
    Invalid,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Self; 15] = [
        Self::Soc,
        Self::Preq,
        Self::Pres,
        Self::Soa,
        Self::AsndIdentResponse,
        Self::AsndStatusResponse,
        Self::AsndNmtRequest,
        Self::AsndNmtCommand,
        Self::AsndSdo,
        Self::AsndOther,
        Self::Amni,
        Self::Ainv,
        Self::Reserved,
        Self::Foreign,
        Self::Invalid,
    ];

    /// The machine-readable name: lower case with underscores.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Soc => "soc",
            Self::Preq => "preq",
            Self::Pres => "pres",
            Self::Soa => "soa",
            Self::AsndIdentResponse => "asnd_ident_response",
            Self::AsndStatusResponse => "asnd_status_response",
            Self::AsndNmtRequest => "asnd_nmt_request",
            Self::AsndNmtCommand => "asnd_nmt_command",
            Self::AsndSdo => "asnd_sdo",
            Self::AsndOther => "asnd_other",
            Self::Amni => "amni",
            Self::Ainv => "ainv",
            Self::Reserved => "reserved",
            Self::Foreign => "foreign",
            Self::Invalid => "invalid",
        }
    }

    /// The message as the specification abbreviates it.
    #[must_use]
    pub const fn message(self) -> &'static str {
        match self {
            Self::Soc => "SoC",
            Self::Preq => "PReq",
            Self::Pres => "PRes",
            Self::Soa => "SoA",
            Self::AsndIdentResponse
            | Self::AsndStatusResponse
            | Self::AsndNmtRequest
            | Self::AsndNmtCommand
            | Self::AsndSdo
            | Self::AsndOther => "ASnd",
            Self::Amni => "AMNI",
            Self::Ainv => "AInv",
            Self::Reserved => "reserved",
            Self::Foreign => "other",
            Self::Invalid => "invalid",
        }
    }

    /// Whether only the managing node sends it.
    pub(super) const fn is_of_managing_node(self) -> bool {
        matches!(self, Self::Soc | Self::Preq | Self::Soa)
    }

    /// Whether it needs an invitation by a SoA.
    pub(super) const fn is_asynchronous(self) -> bool {
        matches!(
            self,
            Self::AsndIdentResponse
                | Self::AsndStatusResponse
                | Self::AsndNmtRequest
                | Self::AsndNmtCommand
                | Self::AsndSdo
                | Self::AsndOther
        )
    }

    /// The group that it goes to; `None` for one that may go to anybody.
    pub(super) const fn group(self) -> Option<MacAddress> {
        match self {
            Self::Soc => Some(group::SOC),
            Self::Pres => Some(group::PRES),
            Self::Soa => Some(group::SOA),
            _ => None,
        }
    }

    /// What the headers say, without the content; `None` for an ASnd that ends before its service.
    pub(crate) const fn told(message_type: MessageType, service: Option<ServiceId>) -> Option<Self> {
        Some(match message_type {
            MessageType::SOC => Self::Soc,
            MessageType::PREQ => Self::Preq,
            MessageType::PRES => Self::Pres,
            MessageType::SOA => Self::Soa,
            MessageType::ASND => match service {
                None => return None,
                Some(ServiceId::IDENT_RESPONSE) => Self::AsndIdentResponse,
                Some(ServiceId::STATUS_RESPONSE) => Self::AsndStatusResponse,
                Some(ServiceId::NMT_REQUEST) => Self::AsndNmtRequest,
                Some(ServiceId::NMT_COMMAND) => Self::AsndNmtCommand,
                Some(ServiceId::SDO) => Self::AsndSdo,
                Some(_) => Self::AsndOther,
            },
            MessageType::AMNI => Self::Amni,
            MessageType::AINV => Self::Ainv,
            _ => Self::Reserved,
        })
    }

    pub(super) const fn of(body: &Body<'_>) -> Self {
        match body {
            Body::Soc(_) => Self::Soc,
            Body::Preq(_) => Self::Preq,
            Body::Pres(_) => Self::Pres,
            Body::Soa(_) => Self::Soa,
            Body::IdentResponse(_) => Self::AsndIdentResponse,
            Body::StatusResponse(_) => Self::AsndStatusResponse,
            Body::NmtRequest(_) => Self::AsndNmtRequest,
            Body::NmtCommand(_) => Self::AsndNmtCommand,
            Body::Sdo(_) => Self::AsndSdo,
            Body::OtherAsnd(..) => Self::AsndOther,
            Body::Other(MessageType::AMNI, _) => Self::Amni,
            Body::Other(MessageType::AINV, _) => Self::Ainv,
            Body::Other(..) => Self::Reserved,
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(feature = "serde")]
impl serde::Serialize for Kind {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}
