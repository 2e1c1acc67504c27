//! Keys, allocations and intruders.

use super::*;
use crate::master::ElectronicKey;

fn vendor(vendor: u16) -> ExpectedNode {
    let key = ElectronicKey { vendor: Some(vendor.into()), ..ElectronicKey::default() };
    ExpectedNode { key, ..ExpectedNode::default() }
}

#[test]
fn a_device_that_is_not_the_one_expected() {
    let mut ward = Ward::new();
    ward.doctor.expect(mac(10), vendor(0x1234));
    ward.doctor.expect(mac(11), vendor(0x1235));
    ward.check(10, 0, 1);
    ward.is_healthy();
    ward.check(11, 0, 2);
    let found = ward.only(Rule::KeyMismatch);
    assert_eq!(found.to_string(), "node 11 is not the device expected: vendor 4661 expected, 4660 found");
    assert_eq!(found.scanner_status().map(|status| status.0), Some(73));
}

#[test]
fn another_product_under_the_same_mac_id() {
    let mut ward = Ward::new();
    ward.allocate(10, 1, 1);
    let mut product = |code| {
        ward.group2(10, 4, &[1, 0x0E, 1, 1, 3]);
        ward.group2(10, 3, &[1, 0x8E, code, 0]);
        ward.rules()
    };
    assert_eq!(product(7), []);
    assert_eq!(product(7), []);
    assert_eq!(product(8), [Rule::IdentityChanged]);
    assert_eq!(ward.only(Rule::IdentityChanged).severity, Severity::Warning);
}

/// One device after the other is taken out of the box and given its MAC ID.
#[test]
fn devices_out_of_the_box_come_and_go() {
    let mut ward = Ward::new();
    ward.check(63, 0, 1).wait(1_000).check(63, 0, 1).wait(3_000);
    ward.check(63, 0, 2).wait(1_000).check(63, 0, 2).wait(3_000);
    assert_eq!(ward.only(Rule::IdentityChanged).severity, Severity::Info);
}

#[test]
fn a_slave_that_refuses_its_master() {
    let mut ward = Ward::new();
    ward.group2(10, 6, &[1, 0x4B, 3, 1, 3, 1]).group2(10, 3, &[1, 0x94, 0x02, 0x02]);
    let found = ward.only(Rule::AllocationRefused);
    assert_eq!(found.scanner_status().map(|status| status.0), Some(83));
    assert!(found.to_string().starts_with("node 10 refuses to be allocated by master 1: "), "{found}");
    ward.allocate(10, 1, 1);
    assert!(ward.only(Rule::AllocationRefused).is_over());
}

/// A master after its restart: "already allocated", Release, Allocate. If it stays so, it is a refusal.
#[test]
fn an_orderly_start_is_no_refusal() {
    let mut ward = Ward::new();
    ward.group2(10, 6, &[1, 0x4B, 3, 1, 3, 1]).group2(10, 3, &[1, 0x94, 0x0B, 0x02]);
    ward.group2(10, 6, &[1, 0x4C, 3, 1, 3]).group2(10, 3, &[1, 0xCC]);
    ward.allocate(10, 1, 3);
    ward.wait(9_000);
    ward.is_healthy();
    ward.group2(10, 6, &[1, 0x4B, 3, 1, 3, 1]).group2(10, 3, &[1, 0x94, 0x0B, 0x02]).wait(5_020);
    ward.only(Rule::AllocationRefused);
}

#[test]
fn a_slave_that_belongs_to_another_master() {
    let mut ward = Ward::with_slave();
    ward.group2(10, 6, &[2, 0x4B, 3, 1, 3, 2]).group2(10, 3, &[2, 0x94, 0x0C, 0x01]);
    let found = ward.only(Rule::TwoMasters);
    assert_eq!(found.severity, Severity::Warning);
    assert_eq!(found.to_string(), "two masters want node 10: it belongs to 1, 2 wants it");
    // It gives up.
    ward.wait(60_020);
    assert!(ward.doctor.findings().next().is_some_and(Finding::is_over));
}

/// Two masters with slaves of their own are what many networks have.
#[test]
fn two_masters_with_their_own_slaves_are_healthy() {
    let mut ward = Ward::new();
    ward.allocate(10, 1, 1);
    ward.allocate(11, 2, 1);
    ward.is_healthy();
}

#[test]
fn nodes_that_do_not_belong_here() {
    let intrusion = |intrusion| DoctorConfig { intrusion, ..DoctorConfig::default() };
    let mut ward = Ward::with(intrusion(Intrusion::Expected));
    ward.doctor.expect(mac(10), ExpectedNode::default());
    ward.check(10, 0, 1);
    ward.is_healthy();
    ward.check(11, 0, 2);
    assert_eq!(ward.only(Rule::ForeignMacId).to_string(), "node 11 does not belong to this network");

    let mut ward = Ward::with(intrusion(Intrusion::Learned(Duration::from_secs(60))));
    ward.check(10, 0, 1).wait(30_000).check(11, 0, 2).wait(40_000).check(10, 0, 1).check(11, 0, 2);
    assert_eq!(ward.of(Rule::ForeignMacId), []);
    ward.check(12, 0, 3);
    assert_eq!(ward.of(Rule::ForeignMacId).len(), 1);
}

#[test]
fn allocations_by_another_master_than_before() {
    let config =
        DoctorConfig { intrusion: Intrusion::Learned(Duration::from_secs(1)), ..DoctorConfig::default() };
    for (master, expected) in [(1, &[][..]), (2, &[Rule::ForeignMacId, Rule::UnexpectedAllocation])] {
        let mut ward = Ward::with_slave_of(config, 0x01);
        ward.wait(12_000);
        ward.allocate(10, master, 3);
        assert_eq!(ward.rules(), expected, "master {master}");
    }
    // The intruder is not what was learned: the own master comes back.
    let mut ward = Ward::with_slave_of(config, 0x01);
    ward.wait(12_000);
    ward.allocate(10, 2, 3);
    ward.group2(10, 4, &[2, 0x10, 5, 2, 9, 100, 0]).group2(10, 3, &[2, 0x90, 100, 0]).poll().answer();
    ward.group2(10, 4, &[2, 0x4C, 3, 1, 3]).group2(10, 3, &[2, 0xCC]);
    ward.allocate(10, 1, 3);
    let found = ward.of(Rule::UnexpectedAllocation);
    assert_eq!(found[0].2, "node 10 was allocated by master 2 instead of master 1");
    let config = DoctorConfig { intrusion: Intrusion::Expected, ..DoctorConfig::default() };
    for (master, expected) in [(1, 0), (2, 1)] {
        let mut ward = Ward::with(config);
        for (node, owner) in [(1, None), (2, None), (10, Some(mac(1)))] {
            ward.doctor.expect(mac(node), ExpectedNode { master: owner, ..ExpectedNode::default() });
        }
        ward.allocate(10, master, 3);
        assert_eq!(ward.of(Rule::UnexpectedAllocation).len(), expected, "master {master}");
    }
}
