//! A DeviceNeX plant: what actions do to it, its Assembly objects, and how its trace is told.

use devicenet_cli::simulate::Outcome;

use crate::traced_text;

/// The sensor produces at OA 5, the panel consumes at OA 6, after seven seconds. OA 30 is planned for nobody: what is there on line
/// tells its address at 14, 24 and 34 s.
const PLANT: &str = r#"
[bus]
bit_rate = "250k"
duration = "40s"
[[node]]
name = "ear"
role = "external"
[[node]]
name = "sensor"
protocol = "devicenex"
role = "device"
produce = 2
input = "0102"
identity = { vendor = 0x1234, product = 7, serial = 0x11 }
[[node]]
name = "panel"
protocol = "devicenex"
role = "device"
consume = 2
identity = { vendor = 0x1234, product = 8, serial = 0x22 }
[[node]]
name = "block"
protocol = "devicenex"
role = "device"
oa = 30
produce = 2
input = "0304"
consume = 2
identity = { vendor = 0x1234, product = 9, serial = 0x33 }
[[node]]
name = "manager"
protocol = "devicenex"
role = "manager"
oa = 1
identity = { vendor = 0x1234, product = 1, serial = 0x1 }
[[node.planned]]
oa = 5
device = "sensor"
connections = [{ connection = "multicast_producer", epr = "100ms" }]
[[node.planned]]
oa = 6
device = "panel"
connections = [{ connection = "multicast_consumer", from = 5, epr = "0ms" }]
"#;

#[track_caller]
fn traced(more: &str) -> (String, Outcome) {
    traced_text("plant", &format!("{PLANT}{more}"))
}

/// How many lines of a node have these words.
fn told(trace: &str, node: &str, words: &str) -> usize {
    let is_told =
        |line: &&str| line.split_whitespace().nth(1) == Some(node) && line.split("| ").nth(1) == Some(words);
    trace.lines().filter(is_told).count()
}

fn action(at: &str, node: &str, what: &str) -> String {
    format!("[[action]]\nat = \"{at}\"\nnode = \"{node}\"\n{what}\n")
}

fn expect(when: &str, node: &str, what: &str) -> String {
    format!("[[expect]]\n{when}\nnode = \"{node}\"\n{what}\n")
}

/// The connections are gone at once, the Hellos take two seconds, and nobody objects.
#[test]
fn set_oa_says_hello_with_the_new_address() {
    let more = [
        action("20s", "block", "do = \"set_oa\"\nvalue = 9"),
        expect("from = \"20s\"\nto = \"20.9s\"\nalways = true", "block", "state = \"hello_1\"\noa = 9"),
        expect("from = \"21.1s\"\nto = \"21.9s\"\nalways = true", "block", "state = \"hello_2\"\noa = 9"),
        expect("from = \"22.1s\"\nalways = true", "block", "state = \"online\"\noa = 9"),
    ];
    let (trace, outcome) = traced(&more.concat());
    assert_eq!(outcome.verdict.held, 3);
    assert_eq!(told(&trace, "block", "OA set to 9"), 1);
    assert_eq!(told(&trace, "block", "Online -> Hello1: address set"), 1);
    let unknown = "unknown device at OA 9: vendor 4660, product 9, revision 1, serial 0x00000033";
    assert_eq!(told(&trace, "manager", unknown), 1);
}

/// A planned device that leaves its address is no unknown one. It is missed there, and given its address back.
#[test]
fn a_planned_device_that_takes_another_address_gets_its_own_back() {
    let more = [
        action("20s", "sensor", "do = \"set_oa\"\nvalue = 9"),
        expect(
            "at = \"20s\"",
            "sensor",
            "connection = \"multicast_producer\"\nconnection_state = \"non_existent\"",
        ),
        expect("from = \"20s\"\nto = \"22s\"", "manager", "event = \"lost\"\ndevice = \"sensor\""),
        expect("at = \"25s\"", "sensor", "state = \"online\"\noa = 9"),
        expect("by = \"35s\"", "sensor", "state = \"online\"\noa = 5"),
        expect("at = \"40s\"", "manager", "device = \"sensor\"\ndevice_state = \"running\""),
        expect("at = \"40s\"", "panel", "output = \"0102\"\nmode = \"run\""),
    ];
    let (trace, _) = traced(&more.concat());
    let misplaced = "at OA 9 instead of 5: vendor 4660, product 7, revision 1, serial 0x00000011";
    assert_eq!(told(&trace, "manager", misplaced), 2, "when it comes, and when it can be told: {trace}");
    assert!(!trace.contains("unknown device at OA 9"), "{trace}");
    assert_eq!(told(&trace, "manager", "OA 9 becomes 5"), 1);
}

/// 127 is none: the device stands by, and its manager gives it the planned one.
#[test]
fn set_oa_gives_the_address_up() {
    let more = [
        action("20s", "sensor", "do = \"set_oa\"\nvalue = 127"),
        action("20s", "block", "do = \"set_oa\"\nvalue = 127"),
        expect("at = \"20s\"", "sensor", "state = \"hello_1\"\noa = 127"),
        expect("by = \"25s\"", "sensor", "state = \"online\"\noa = 5"),
        expect("by = \"25s\"", "manager", "device = \"sensor\"\ndevice_state = \"running\""),
        expect("from = \"22.1s\"\nalways = true", "block", "state = \"standby\"\noa = 127"),
    ];
    let (trace, _) = traced(&more.concat());
    assert_eq!(told(&trace, "sensor", "gives up its OA"), 1);
}

/// Whoever has the address keeps it, and its data do not stop.
#[test]
fn set_oa_to_an_address_that_is_taken() {
    let more = [
        action("20s", "block", "do = \"set_oa\"\nvalue = 5"),
        expect("from = \"20s\"\nto = \"20.1s\"", "sensor", "event = \"defended\""),
        expect("from = \"20s\"\nto = \"20.1s\"", "block", "event = \"address_taken\""),
        expect("from = \"22.1s\"\nalways = true", "block", "state = \"standby\"\noa = 127"),
        expect(
            "from = \"10s\"\nalways = true",
            "sensor",
            "oa = 5\nstate = \"online\"\nconnection = \"multicast_producer\"\nconnection_state = \"established\"",
        ),
    ];
    traced(&more.concat());
}

/// It needs power, and what it has set is not kept without.
#[test]
fn set_oa_and_power() {
    let more = [
        action("20s", "block", "do = \"power_off\""),
        action("21s", "block", "do = \"set_oa\"\nvalue = 9"),
        action("22s", "block", "do = \"power_on\""),
        action("30s", "block", "do = \"set_oa\"\nvalue = 9"),
        action("31s", "block", "do = \"power_cycle\""),
        expect("at = \"29s\"", "block", "oa = 30"),
        expect("at = \"30s\"", "block", "oa = 9"),
        expect("at = \"31s\"", "block", "oa = 30"),
    ];
    let (trace, _) = traced(&more.concat());
    assert_eq!(told(&trace, "block", "the action set_oa has no effect: no power"), 1);
}

/// Over an explicit connection: asked for, Set_Attribute_Single of the link object, and the response before the Hello.
#[test]
fn readdress_gives_a_node_another_address() {
    let more = [
        action("20s", "manager", "do = \"readdress\"\nvalue = { device = 30, oa = 12 }"),
        expect("at = \"20.01s\"", "block", "state = \"hello_1\"\noa = 12"),
        expect("from = \"22.1s\"\nalways = true", "block", "state = \"online\"\noa = 12"),
    ];
    let (trace, _) = traced(&more.concat());
    // Profile, section 6: class 0x03, instance 1, attribute 1. OA 30 is 0x3C, OA 1 0x02 in bits 23-17 and 15-9.
    let frames = [
        ("manager", "1D3C0200  4B D6 01 00 C4 09 01"),
        ("block", "1D033C00  4B D6 00 C4 09"),
        ("manager", "163C0201  10 03 01 01 0C"),
        ("block", "16033C01  90"),
        ("block", "1F183300  00 00 34 12 09 00 01 00"),
    ];
    let mut lines = trace.lines().skip_while(|line| !line.contains("| readdress OA 30 as 12"));
    for (node, frame) in frames {
        let found = lines.any(|line| line.contains(&format!("{node}  {frame}")));
        assert!(found, "{node} {frame}: {trace}");
    }
    assert_eq!(told(&trace, "manager", "OA 30 becomes 12"), 1);
}

/// A planned device is named by its node; what the plan says is made so again.
#[test]
fn a_planned_device_that_is_readdressed_gets_its_own_address_back() {
    let more = [
        action("20s", "manager", "do = \"readdress\"\nvalue = { device = \"sensor\", oa = 12 }"),
        expect("at = \"25s\"", "sensor", "state = \"online\"\noa = 12"),
        expect("at = \"40s\"", "sensor", "state = \"online\"\noa = 5"),
        expect("at = \"40s\"", "manager", "device = \"sensor\"\ndevice_state = \"running\""),
    ];
    let (trace, _) = traced(&more.concat());
    assert_eq!(told(&trace, "manager", "OA 5 becomes 12"), 1);
    assert_eq!(told(&trace, "manager", "OA 12 becomes 5"), 1);
}

/// The node obeys, and its Hello is answered.
#[test]
fn readdress_to_an_address_that_is_taken() {
    let more = [
        action("20s", "manager", "do = \"readdress\"\nvalue = { device = 30, oa = 6 }"),
        expect("from = \"20s\"\nto = \"20.1s\"", "panel", "event = \"defended\""),
        expect("from = \"22.1s\"\nalways = true", "block", "state = \"standby\"\noa = 127"),
        expect("from = \"10s\"\nalways = true", "panel", "oa = 6\nmode = \"run\"\nstate = \"online\""),
    ];
    traced(&more.concat());
}

/// Nobody there; another request under way; no power; not on line yet.
#[test]
fn readdress_that_comes_to_nothing() {
    let more = [
        action("1s", "manager", "do = \"readdress\"\nvalue = { device = 30, oa = 12 }"),
        action("20s", "manager", "do = \"readdress\"\nvalue = { device = 77, oa = 12 }"),
        action("20.1s", "manager", "do = \"readdress\"\nvalue = { device = 30, oa = 12 }"),
        action("25s", "manager", "do = \"power_off\""),
        action("26s", "manager", "do = \"readdress\"\nvalue = { device = 30, oa = 12 }"),
        expect("from = \"14s\"\nalways = true", "block", "state = \"online\"\noa = 30"),
    ];
    let (trace, _) = traced(&more.concat());
    for why in [
        "the manager is not on line: wait for its access event",
        "another request is under way: wait for its response",
        "no power",
    ] {
        assert_eq!(
            told(&trace, "manager", &format!("the action readdress has no effect: {why}")),
            1,
            "{why}"
        );
    }
    assert_eq!(
        told(
            &trace,
            "manager",
            "OA 77 does not become 12: no response: the node is absent, or its connection is gone"
        ),
        1,
        "{trace}"
    );
}

/// Requests of OA 100 to OA 30 over the explicit connection of the predefined set, and the responses.
///
/// Profile, section 3.2: 0x163CC800 and the transaction ID is a request on Message ID 6, 0x16C93C00 its response. Body format
/// 8/8: service, class 0x04, instance, attribute. CIP Vol. 1, general status: 0x0C object state conflict, 0x0E attribute not
/// settable, 0x13 not enough data, 0x14 attribute not supported, 0x15 too much data, 0x16 object does not exist; 0x08 service not
/// supported.
const ASSEMBLY: &[(&str, &str, &str, &str)] = &[
    // No I/O connection is there.
    ("10.0", "1D3CC800#4BD60100C40901", "1DC93C00", "4B D6 00 C4 09"),
    // The input data are read, and cannot be written.
    ("10.1", "163CC801#0E046403", "16C93C01", "8E 03 04"),
    ("10.2", "163CC802#0E046404", "16C93C02", "8E 02 00"),
    ("10.3", "163CC803#10046403AABB", "16C93C03", "94 0E FF"),
    // The outputs of connection 13.
    ("10.4", "163CC804#1004A303AABB", "16C93C04", "90"),
    ("10.5", "163CC805#0E04A303", "16C93C05", "8E AA BB"),
    ("10.6", "163CC806#0E04A304", "16C93C06", "8E 02 00"),
    // Sizes that are wrong change nothing.
    ("10.7", "163CC807#1004A303CC", "16C93C07", "94 13 FF"),
    ("10.8", "163CC808#1004A303", "16C93C08", "94 13 FF"),
    ("10.9", "163CC809#1004A303CCCCCC", "16C93C09", "94 15 FF"),
    ("11.0", "163CC80A#0E04A303", "16C93C0A", "8E AA BB"),
    // The size is no setting; there is no other attribute; there is no other instance.
    ("11.1", "163CC80B#1004A3040200", "16C93C0B", "94 0E FF"),
    ("11.2", "163CC80C#0E04A309", "16C93C0C", "94 14 FF"),
    ("11.3", "163CC80D#0E046503", "16C93C0D", "94 16 FF"),
    // Connection 13 is established, and receives: its outputs are its own.
    ("12.0", "1D3CC80E#4BC00D00640000", "1DC93C0E", "4B C0 00 64 00"),
    ("12.1", "163CC80F#1004A303CCDD", "16C93C0F", "94 0C FF"),
    ("12.15", "00C80007#1122", "", ""),
    ("12.2", "163CC810#0E04A303", "16C93C10", "8E 11 22"),
    ("12.25", "163CC811#1004A303CCDD", "16C93C11", "94 0C FF"),
    ("12.3", "163CC812#1004A303CC", "16C93C12", "94 13 FF"),
    // Those of another connection are nobody's.
    ("12.35", "163CC813#10049903CCDD", "16C93C13", "90"),
    // Without a connection they can be read only.
    ("12.4", "1C3CC814#1004A303CCDD", "1CC93C14", "94 08 FF"),
    ("12.45", "1C3CC815#0E04A303", "1CC93C15", "8E 11 22"),
    // It has timed out: the outputs are at rest, and can be set again.
    ("13.0", "163CC816#0E04A303", "16C93C16", "8E 00 00"),
    ("13.1", "163CC817#1004A303CCDD", "16C93C17", "90"),
    ("13.2", "163CC818#0E04A303", "16C93C18", "8E CC DD"),
];

#[test]
fn the_assemblies_of_a_device_over_an_explicit_connection() {
    let log: String = ASSEMBLY.iter().map(|(at, request, ..)| format!("({at}) can0 {request}\n")).collect();
    let client =
        format!("[[node]]\nname = \"client\"\nrole = \"replay\"\npower_up = \"10s\"\nlog = '''\n{log}'''\n");
    let more = [
        client,
        expect("at = \"11.95s\"", "block", "connection = \"multicast_consumer\"\noutput = \"aabb\""),
        expect(
            "at = \"12.3s\"",
            "block",
            "connection = \"multicast_consumer\"\noutput = \"1122\"\nmode = \"run\"",
        ),
        expect(
            "at = \"12.9s\"",
            "block",
            "connection = \"multicast_consumer\"\noutput = \"0000\"\nmode = \"fault\"",
        ),
        expect("at = \"14s\"", "block", "connection = \"multicast_consumer\"\noutput = \"ccdd\""),
    ];
    let (trace, _) = traced(&more.concat());
    for (_, request, id, data) in ASSEMBLY.iter().filter(|(_, _, id, _)| !id.is_empty()) {
        let found = trace.lines().any(|line| {
            let mut columns = line.split("  ").map(str::trim).filter(|column| !column.is_empty());
            columns.any(|column| column == *id) && columns.next() == Some(data)
        });
        assert!(found, "{request}: expected {id} {data}\n{trace}");
    }
}

/// What the manager asks each second is told once; what is not answered is told, when it was asked.
#[test]
fn questions_that_are_answered_as_before_are_counted() {
    let state = "1 -> 6  connectionless Get_Attribute_Single Connection 13 state";
    let (trace, _) = traced("");
    assert_eq!(told(&trace, "manager", state), 1, "{trace}");
    let last = trace.lines().last().unwrap();
    assert!(last.ends_with("more connectionless requests with the same answer as before"), "{last}");

    let (trace, _) = traced(&[action("20s", "panel", "do = \"cut\"")].concat());
    let lines: Vec<&str> = trace.lines().skip_while(|line| !line.contains("cable unplugged")).collect();
    let place = |words: &str| lines.iter().position(|line| line.ends_with(words)).expect("told");
    assert!(place(state) < place("OA 6: Running -> Retrying: timed out"), "{trace}");
    let seconds: Vec<f64> =
        (trace.lines()).filter_map(|line| line.split_whitespace().next()?.parse().ok()).collect();
    assert!(seconds.is_sorted(), "in the order of time");

    // A manager that begins anew asks anew.
    let (trace, _) = traced(&action("20s", "manager", "do = \"power_cycle\""));
    assert_eq!(told(&trace, "manager", state), 3, "looked at, and polled: {trace}");
}
