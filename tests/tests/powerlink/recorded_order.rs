//! Our managing node in the place of theirs: what it asks for, and what follows, comes in the order of the recording.

use std::time::Duration;

use devicenet_tests::powerlink::{Net, config, plan};
use powerlink_core::NodeId;
use powerlink_core::dictionary::ObjectAddress;
use powerlink_core::managing::{Config, NodePlan, ObjectWrite};
use powerlink_core::wire::{Body, Flags, Frame, NmtStateCode, RequestedService, SdoCommandId};
use transport_mock::ethernet::SegmentConfig;

use crate::recording::frames;

/// What a frame says of the boot, if it says anything: that which both managing nodes do alike.
fn landmark(frame: &Frame<'_>) -> Option<String> {
    Some(match &frame.body {
        Body::Soc(_) => "SoC".into(),
        Body::Preq(_) => "PReq".into(),
        Body::Pres(pres) => {
            format!("PRes {} RD={}", pres.state, u8::from(pres.flags.contains(Flags::DATA_VALID)))
        }
        Body::Soa(soa) if soa.service == RequestedService::NMT_REQUEST_INVITE => {
            format!("SoA {} for a command", soa.state)
        }
        Body::IdentResponse(ident) => format!("IdentResponse {}", ident.state),
        Body::NmtCommand(command) => format!("{} to {}", command.command, frame.to),
        _ => return None,
    })
}

/// EC and ER. Theirs begins with SDO before the handshake is over, ours does not.
fn signalling(frame: &Frame<'_>) -> Option<String> {
    Some(match &frame.body {
        Body::Soa(soa) if soa.service == RequestedService::STATUS_REQUEST => {
            format!("ER={}", u8::from(soa.flags.contains(Flags::EXCEPTION_RESET)))
        }
        Body::StatusResponse(status) => {
            format!("EC={}", u8::from(status.flags.contains(Flags::EXCEPTION_CLEAR)))
        }
        _ => return None,
    })
}

/// The commands of SDO, in both directions, without transactions.
fn sdo(frame: &Frame<'_>) -> Option<String> {
    let Body::Sdo(sdo) = &frame.body else { return None };
    let command = sdo.command?;
    if let Some(code) = command.abort() {
        return Some(format!("abort {code}"));
    }
    let direction = if command.is_response { "response" } else { "request" };
    Some(format!("{direction} {} {:02X?}", command.command, command.data))
}

/// What the frames say, each thing the first time.
fn first_of_each(frames: &[Vec<u8>], say: fn(&Frame<'_>) -> Option<String>) -> Vec<String> {
    let mut seen = Vec::new();
    for words in frames.iter().filter_map(|bytes| say(&Frame::parse(bytes).unwrap())) {
        if !seen.contains(&words) {
            seen.push(words);
        }
    }
    seen
}

/// The objects that their managing node writes, and whether theirs refused it. The last write is that of every boot, 0x1006.
fn writes(recorded: &[Vec<u8>]) -> Vec<ObjectWrite<'static>> {
    let mut writes: Vec<ObjectWrite<'static>> = Vec::new();
    for bytes in recorded {
        let Body::Sdo(sdo) = Frame::parse(bytes).unwrap().body else { continue };
        let Some(command) = sdo.command.filter(|command| command.command == SdoCommandId::WRITE_BY_INDEX)
        else {
            continue;
        };
        if command.is_abort {
            writes.last_mut().unwrap().may_fail = true;
        } else if let (Some([low, high, sub, _]), false) = (command.data.first_chunk(), command.is_response) {
            let at = ObjectAddress::new(u16::from_le_bytes([*low, *high]), *sub);
            writes.push(ObjectWrite::new(at, command.data[4..].to_vec().leak()));
        }
    }
    writes.pop();
    writes
}

#[test]
fn our_managing_node_boots_a_node_in_the_order_of_theirs() {
    let theirs: Vec<_> = frames("boot.pcap").into_iter().map(|(_, bytes)| bytes).collect();
    let writes = writes(&theirs);
    assert_eq!(writes.len(), 16);
    let config = Config {
        cycle: Duration::from_millis(20),
        async_slot: Duration::from_millis(5),
        asks_diagnostic_device: true,
        ..config()
    };
    let (outputs, inputs) = (&[][..], &[][..]);
    let vendor_id = None;
    let plan = NodePlan { outputs, inputs, vendor_id, writes: writes.leak(), ..plan(1) };
    let mut net = Net::with(config, &[plan], SegmentConfig::default());
    assert!(net.run_until_complete(5_000), "{}", net.trace());
    let ours: Vec<_> = net.segment.frames().map(|frame| frame.bytes.clone()).collect();
    assert_eq!(first_of_each(&ours, landmark), first_of_each(&theirs, landmark));
    assert_eq!(first_of_each(&ours, signalling), first_of_each(&theirs, signalling));
    assert_eq!(first_of_each(&ours, sdo), first_of_each(&theirs, sdo));
    // Both begin with ten SoAs that ask for nothing, then reset all.
    for frames in [&ours, &theirs] {
        let begin: Vec<_> = frames[..12].iter().map(|bytes| Frame::parse(bytes).unwrap()).collect();
        for frame in &begin[..10] {
            let Body::Soa(soa) = frame.body else { panic!("{frame}") };
            assert_eq!((soa.service, soa.target), (RequestedService::NO_SERVICE, NodeId::NONE));
            assert_eq!(soa.state, NmtStateCode::PRE_OPERATIONAL_1);
        }
        assert_eq!(begin[11].to_string(), "MN -> all: NMTResetNode");
    }
}
