//! The states of network access, as a scenario names them.

use devicenet_core::access::StateKind;
use devicenex_core::access as nex;

use crate::scenario::StateName;

pub(super) const fn state_name(state: StateKind) -> StateName {
    match state {
        StateKind::NonExistent => StateName::Nonexistent,
        StateKind::SendingDupMac => StateName::SendingDupMac,
        StateKind::WaitingDupMac => StateName::WaitingDupMac,
        StateKind::OnLine => StateName::OnLine,
        StateKind::CommFault => StateName::CommFault,
    }
}

pub(super) const fn nex_state_name(state: nex::StateKind) -> StateName {
    match state {
        nex::StateKind::NonExistent => StateName::Nonexistent,
        nex::StateKind::DetectingBitRate => StateName::DetectingBitRate,
        nex::StateKind::Hello1 => StateName::Hello1,
        nex::StateKind::Hello2 => StateName::Hello2,
        nex::StateKind::Standby => StateName::Standby,
        nex::StateKind::Online => StateName::OnLine,
        nex::StateKind::BusOff => StateName::BusOff,
        nex::StateKind::Faulted => StateName::Faulted,
    }
}
