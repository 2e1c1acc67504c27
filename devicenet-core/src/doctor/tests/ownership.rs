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
    assert_eq!(
        found.to_string(),
        "node 10 refuses explicit + poll to master 1: 0x02 Resource unavailable, invalid allocation/release choice"
    );
    ward.allocate(10, 1, 3);
    assert!(ward.only(Rule::AllocationRefused).is_over());
}

/// It grants the explicit connection each time, and refuses the I/O: one refusal, and not one that comes and goes.
#[test]
fn a_refusal_lasts_as_long_as_the_master_tries() {
    let mut ward = Ward::new();
    for _ in 0..5 {
        ward.allocate(10, 1, 1);
        ward.group2(10, 4, &[1, 0x4B, 3, 1, 4, 1]).group2(10, 3, &[1, 0x94, 0x02, 0x02]);
        ward.group2(10, 6, &[1, 0x4C, 3, 1, 1]).group2(10, 3, &[1, 0xCC]).wait(3_000);
        assert!(!ward.only(Rule::AllocationRefused).is_over());
    }
    let news: Vec<_> = core::iter::from_fn(|| ward.doctor.poll()).map(|news| news.kind).collect();
    assert_eq!(news, [ChangeKind::Begins]);
    // The scan list is corrected, and nobody asks for it any more.
    ward.allocate(10, 1, 3);
    ward.wait(57_000);
    assert!(ward.only(Rule::AllocationRefused).is_over());
}

/// What a master does with a slave before it lets it go: the product code, or what the poll connection produces.
fn attempt(ward: &mut Ward, class: u8, instance: u8, attribute: u8, value: u8) {
    ward.allocate(10, 1, 1);
    ward.group2(10, 4, &[1, 0x0E, 1, 1, 1]).group2(10, 3, &[1, 0x8E, 0x34, 0x12]);
    ward.group2(10, 4, &[1, 0x0E, class, instance, attribute]).group2(10, 3, &[1, 0x8E, value, 0]);
    ward.group2(10, 6, &[1, 0x4C, 3, 1, 1]).group2(10, 3, &[1, 0xCC]).wait(3_000);
}

#[test]
fn a_master_that_lets_its_slave_go_after_a_look_at_its_identity() {
    let mut ward = Ward::new();
    attempt(&mut ward, 1, 1, 3, 7);
    attempt(&mut ward, 1, 1, 3, 7);
    // Once or twice could be a tool.
    ward.is_healthy();
    attempt(&mut ward, 1, 1, 3, 7);
    let found = ward.only(Rule::KeyMismatch);
    assert_eq!(
        found.to_string(),
        "master 1 lets node 10 go each time that it has read its product code 7: it expects another device"
    );
    assert_eq!((found.severity, found.since), (Severity::Error, Instant::from_millis(8)));
    assert_eq!(found.scanner_status().map(|status| status.0), Some(73));
    assert_eq!(found.evidence.frames(), [8, 24]);
    // The right device is fitted, and taken into service.
    ward.allocate(10, 1, 3);
    ward.group2(10, 4, &[1, 0x10, 5, 2, 9, 100, 0]).group2(10, 3, &[1, 0x90, 100, 0]);
    assert!(ward.only(Rule::KeyMismatch).is_over());
}

/// The rate of the explicit connection, which many masters set first, is not that of I/O: the slave is not in service.
#[test]
fn a_master_that_sets_the_rate_of_its_explicit_connection_before_it_looks() {
    let mut ward = Ward::new();
    for _ in 0..3 {
        ward.allocate(10, 1, 1);
        ward.group2(10, 4, &[1, 0x10, 5, 1, 9, 0x10, 0x27]).group2(10, 3, &[1, 0x90, 0x10, 0x27]);
        for (attribute, value) in [(1, 0x34), (3, 7)] {
            ward.group2(10, 4, &[1, 0x0E, 1, 1, attribute]).group2(10, 3, &[1, 0x8E, value, 0]);
        }
        ward.group2(10, 6, &[1, 0x4C, 3, 1, 1]).group2(10, 3, &[1, 0xCC]).wait(3_000);
    }
    assert_eq!(
        ward.only(Rule::KeyMismatch).to_string(),
        "master 1 lets node 10 go each time that it has read its product code 7: it expects another device"
    );
    // A tool that sets it, and asks for one value, is a tool all the same.
    let mut ward = Ward::new();
    for _ in 0..5 {
        ward.allocate(10, 62, 1);
        ward.group2(10, 4, &[62, 0x10, 5, 1, 9, 0x10, 0x27]).group2(10, 3, &[62, 0x90, 0x10, 0x27]);
        ward.group2(10, 4, &[62, 0x0E, 1, 1, 3]).group2(10, 3, &[62, 0x8E, 7, 0]);
        ward.group2(10, 6, &[62, 0x4C, 3, 1, 1]).group2(10, 3, &[62, 0xCC]).wait(3_000);
    }
    ward.is_healthy();
}

#[test]
fn a_master_that_lets_its_slave_go_after_a_look_at_its_sizes() {
    let mut ward = Ward::new();
    (0..3).for_each(|_| attempt(&mut ward, 5, 2, 7, 1));
    let found = ward.only(Rule::SizeMismatch);
    assert_eq!(
        found.to_string(),
        "master 1 lets node 10 go each time that it has read that its poll connection produces 1 byte: it expects another size"
    );
    assert_eq!(found.scanner_status().map(|status| status.0), Some(77));
    ward.wait(60_000);
    assert!(ward.only(Rule::SizeMismatch).is_over());

    let mut ward = Ward::new();
    (0..3).for_each(|_| attempt(&mut ward, 5, 4, 8, 2));
    assert_eq!(
        ward.only(Rule::SizeMismatch).to_string(),
        "master 1 lets node 10 go each time that it has read that its COS/cyclic connection consumes 2 bytes: it expects another size"
    );
}

/// A tool that asks for the product code again and again, one that reads all of the identity, and a key that is known.
#[test]
fn whoever_only_asks_expects_nothing() {
    let mut ward = Ward::new();
    for _ in 0..5 {
        ward.allocate(10, 62, 1);
        ward.group2(10, 4, &[62, 0x0E, 1, 1, 3]).group2(10, 3, &[62, 0x8E, 7, 0]);
        ward.group2(10, 6, &[62, 0x4C, 3, 1, 1]).group2(10, 3, &[62, 0xCC]).wait(3_000);
    }
    ward.is_healthy();
    (0..5).for_each(|_| attempt(&mut ward, 1, 1, 7, 0));
    ward.is_healthy();
    // A device out of the box could take the place of a missing one, but it is not of its kind.
    for _ in 0..5 {
        ward.allocate(63, 1, 1);
        for attribute in [1, 2, 3] {
            ward.group2(63, 4, &[1, 0x0E, 1, 1, attribute]).group2(63, 3, &[1, 0x8E, 7, 0]);
        }
        ward.group2(63, 6, &[1, 0x4C, 3, 1, 1]).group2(63, 3, &[1, 0xCC]).wait(3_000);
    }
    ward.is_healthy();
    let mut ward = Ward::new();
    let key = ElectronicKey { product_code: Some(8), ..ElectronicKey::default() };
    ward.doctor.expect(mac(10), ExpectedNode { key, ..ExpectedNode::default() });
    (0..5).for_each(|_| attempt(&mut ward, 1, 1, 3, 7));
    let found = ward.only(Rule::KeyMismatch);
    assert_eq!(found.to_string(), "node 10 is not the device expected: product code 8 expected, 7 found");
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

/// Who refuses belongs to somebody; who has let it go, or has lost it with its power, is not the one.
#[test]
fn a_master_that_has_let_a_slave_go_is_not_its_owner() {
    let leave: [(&str, Deed); 2] = [
        ("release", |ward| {
            ward.group2(10, 6, &[1, 0x4C, 3, 1, 3]).group2(10, 3, &[1, 0xCC]);
        }),
        ("restart", |ward| {
            ward.check(10, 0, 1).wait(1_000).check(10, 0, 1).wait(1_000);
        }),
    ];
    for (how, leave) in leave {
        let mut ward = Ward::with_slave();
        ward.poll().answer();
        leave(&mut ward);
        ward.group2(10, 6, &[2, 0x4B, 3, 1, 3, 2]).group2(10, 3, &[2, 0x94, 0x0C, 0x01]);
        assert_eq!(
            ward.of(Rule::TwoMasters)[0].2,
            "two masters want node 10: 2 is refused, because another has it",
            "{how}"
        );
    }
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
