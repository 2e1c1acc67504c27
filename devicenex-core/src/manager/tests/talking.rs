//! Requests of the application, attributes that are read, new addresses; and the manager as a node.

use cip_core::code::{AttributeId, ClassId, InstanceId, ServiceCode};
use cip_core::message::Request;

use super::bus::*;
use crate::id::{Direction, OperationalAddress};
use crate::manager::{
    Attribute, DatabaseError, DeviceState, IdentityPattern, ManagerEvent, PlannedConnection, PlannedDevice,
    RequestError, RequestFailure,
};

const NAME: Attribute =
    Attribute { class: ClassId::IDENTITY, instance: InstanceId(1), attribute: AttributeId(7) };

#[test]
fn an_attribute_is_read_without_a_connection() {
    let mut bus = Bus::on_line(config(), []);
    assert_eq!(bus.manager.get(oa(1), NAME), Err(RequestError::NotANode(oa(1))));
    bus.manager.get(oa(40), NAME).unwrap();
    assert_eq!(bus.manager.get(oa(41), NAME), Err(RequestError::Busy));
    bus.input(link_core::Input::Tick);
    assert_eq!(bus.acknowledges().last().unwrap(), "1C500200 [4] 0E 01 01 07");
    bus.hears("1C035200: 8E 02 41 42");
    assert_eq!(bus.manager.response(), None, "of another node");
    assert_eq!(bus.manager.counters().ignored, 1);
    bus.hears("1C035000: 8E 02 41 42");
    assert_eq!(bus.manager.response().unwrap().to_string(), "Get_Attribute_Single ok, data 02 41 42");
}

#[test]
fn a_response_in_fragments() {
    let mut bus = Bus::on_line(config(), []);
    bus.manager.get(oa(40), NAME).unwrap();
    bus.input(link_core::Input::Tick);
    bus.acknowledges();
    // 40 is 0x28: source 0x50.
    bus.hears("1C035100: 00 8E 08 41 42 43 44 45");
    bus.sends(&["1C5003C0 [1] 00"]);
    bus.hears("1C035181: 46 47 48");
    bus.sends(&["1C5003C1 [1] 00"]);
    assert!(bus.events.contains(&ManagerEvent::Response(oa(40))));
    assert_eq!(
        bus.manager.response().unwrap().to_string(),
        "Get_Attribute_Single ok, data 08 41 42 43 44 45 46 47 48"
    );
}

#[test]
fn a_device_is_given_another_address() {
    let mut bus = Bus::on_line(config(), []);
    assert_eq!(bus.manager.readdress(oa(40), oa(1)), Err(RequestError::NotANode(oa(1))));
    bus.manager.readdress(oa(40), oa(67)).unwrap();
    bus.input(link_core::Input::Tick);
    assert_eq!(bus.acknowledges().last().unwrap(), "1D500200 [7] 4B D6 01 00 C4 09 01");
    bus.hears("1D035000: 4B D6 00 C4 09");
    // The link object, attribute 1.
    bus.sends(&["16500201 [5] 10 03 01 01 43"]);
    bus.hears("16035001: 90");
    let readdressed = ManagerEvent::Readdressed { from: oa(40), to: oa(67), result: Ok(()) };
    assert_eq!(bus.events.last(), Some(&readdressed));
}

/// Else it would be sent away from its own address.
#[test]
fn a_device_that_has_its_address_is_not_taken_for_the_one_that_had_it() {
    let mut bus = Bus::on_line(config(), [producer(), consumer(0)]);
    bus.wait_on_the_bus(800);
    bus.hello(67, Direction::Response, CONSUMER);
    bus.is(67, DeviceState::Conflict);
    bus.input(link_core::Input::Tick);
    assert_eq!(bus.acknowledges().last().unwrap(), "1D860200 [7] 4B D6 01 00 C4 09 01");
    bus.hello(67, Direction::Response, PLANNED);
    bus.is(67, DeviceState::Connecting);
    bus.hears("1D038600: 4B D6 00 C4 09");
    let set = "10 03 01 01 05";
    assert!(bus.acknowledges().iter().all(|frame| !frame.ends_with(set)));
    let result = Err(RequestFailure::Failed(cip_core::client::Failure::NoResponse));
    assert!(bus.events.contains(&ManagerEvent::Readdressed { from: oa(67), to: oa(5), result }));
}

#[test]
fn a_request_that_nobody_answers() {
    let mut bus = Bus::on_line(config(), []);
    let request = Request::new(ServiceCode::RESET, ClassId::IDENTITY, InstanceId(1), &[]);
    bus.manager.request(oa(40), &request, 1).unwrap();
    bus.wait_on_the_bus(1100);
    let failed = RequestFailure::Failed(cip_core::client::Failure::NoResponse);
    assert!(bus.events.contains(&ManagerEvent::RequestFailed(oa(40), failed)));
    bus.input(link_core::Input::Link(link_core::LinkEvent::Down));
    assert_eq!(bus.manager.request(oa(40), &request, 1), Err(RequestError::NotOnline));
}

/// Attributes are read when the connections are made, one after the other.
#[test]
fn planned_attributes_are_read() {
    let mut plan = producer();
    plan.connections.clear();
    plan.reads.push(NAME).unwrap();
    plan.reads.push(Attribute { attribute: AttributeId(6), ..NAME }).unwrap();
    let mut bus = Bus::on_line(config(), [plan]);
    bus.identifies(PLANNED);
    bus.tells();
    bus.answers_get(&[2, 0x41, 0x42]);
    let sent = bus.acknowledges();
    assert!(sent.last().unwrap().ends_with("0E 01 01 06"), "{sent:?}");
    bus.hears(&std::format!("1C0386{}: 94 14 FF", &sent.last().unwrap()[6..8]));
    assert_eq!(
        bus.tells(),
        [
            "OA 67: Identity instance 1, attribute 7: [02, 41, 42]",
            "OA 67: Identity instance 1, attribute 6: refused: Attribute not supported",
        ]
    );
}

/// The manager answers about itself: its serial number, and over an explicit connection its address.
#[test]
fn the_manager_is_a_node() {
    let mut bus = Bus::on_line(config(), []);
    bus.acknowledges();
    // From OA 9 to OA 1.
    bus.hears("1C021205: 0E 01 01 06");
    assert!(bus.acknowledges().contains(&"1C130205 [5] 8E 00 01 00 00".to_owned()));
    bus.hears("1D021206: 4B D3 01 00 C4 09 01");
    assert!(bus.acknowledges().contains(&"1D130206 [5] 4B D3 00 C4 09".to_owned()));
}

#[test]
fn what_cannot_be_planned() {
    let mut bus = Bus::on_line(config(), [producer()]);
    let now = bus.now;
    assert_eq!(bus.manager.add_device(now, producer()), Err(DatabaseError::Planned(oa(67))));
    let at = |address: OperationalAddress| {
        let identity = IdentityPattern { serial: Some(address.number().into()), ..producer().identity };
        PlannedDevice { address, identity, ..producer() }
    };
    let elsewhere = PlannedDevice { address: oa(9), ..producer() };
    assert_eq!(bus.manager.add_device(now, elsewhere), Err(DatabaseError::Identity(oa(67))));
    assert_eq!(bus.manager.add_device(now, at(oa(127))), Err(DatabaseError::NoAddress));
    assert_eq!(bus.manager.add_device(now, at(oa(1))), Err(DatabaseError::OwnAddress(oa(1))));
    let mut twice = at(oa(9));
    twice.connections.push(PlannedConnection::producer(7)).unwrap();
    assert_eq!(bus.manager.add_device(now, twice), Err(DatabaseError::Twice(1)));
    let mut hungry = consumer(0);
    hungry.connections[0].consumes = None;
    assert_eq!(bus.manager.add_device(now, hungry), Err(DatabaseError::NothingToConsume(0)));
    let mut explicit = at(oa(9));
    explicit.connections[0].instance = Some(crate::message::Predefined::Explicit);
    assert_eq!(bus.manager.add_device(now, explicit), Err(DatabaseError::Explicit(0)));
    for address in 10..13 {
        bus.manager.add_device(now, at(oa(address))).unwrap();
    }
    assert_eq!(bus.manager.add_device(now, at(oa(13))), Err(DatabaseError::Full(4)));
    // One in the middle is taken out; the others are found where they are.
    assert_eq!(bus.manager.remove_device(oa(10)).unwrap().address, oa(10));
    assert_eq!(bus.manager.remove_device(oa(10)), Err(DatabaseError::NotPlanned(oa(10))));
    assert_eq!(bus.manager.device(oa(12)).unwrap().plan.address, oa(12));
    bus.wait_on_the_bus(3000);
}

use std::borrow::ToOwned;
use std::string::ToString;
