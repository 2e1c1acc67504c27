//! `get` and `set`.

use crate::devicenet;

/// Both slaves are on line after two seconds.
const LISTEN: [&str; 2] = ["--listen", "3s"];

fn get(node: &str, attribute: &str, more: &[&str]) -> crate::Run {
    devicenet(&[&["get", "sim:two.toml", node, attribute], &LISTEN[..], more].concat())
}

#[test]
fn an_attribute_is_read_in_words_and_as_json() {
    let run = get("10", "1/1/7", &[]);
    assert_eq!((run.out().as_str(), run.code()), ("node 10  Identity 1 Product name: \"valve\"\n", 0));
    assert_eq!(
        run.err(),
        "note: sends on sim:two.toml as MAC ID 62: duplicate MAC ID checks, then to node 10 Allocate, Get_Attribute_Single \
         Identity 1 Product name, Release\n"
    );
    let [object] = &get("0x0A", "0x01/1/7", &["--json"]).json()[..] else { panic!() };
    assert_eq!(object["value"], "0576616c7665");
    assert_eq!(object["value_text"], "\"valve\"");
    assert_eq!(object["mac"], 10);
}

#[test]
fn an_attribute_is_written_and_the_node_says_what_it_took() {
    let run = devicenet(&["set", "sim:two.toml", "11", "3/1/3", "1", LISTEN[0], LISTEN[1]]);
    assert_eq!((run.out().as_str(), run.code()), ("node 11  DeviceNet 1 Bus-off interrupt: done\n", 0));
    let announced =
        "to node 11 Allocate, Set_Attribute_Single DeviceNet 1 Bus-off interrupt = true, Release\n";
    assert!(run.err().ends_with(announced), "{}", run.err());
    let run = devicenet(&["set", "sim:two.toml", "11", "3/1/3", "hex:02", LISTEN[0], LISTEN[1]]);
    assert_eq!(run.code(), 1, "what the node cannot have is sent as bytes, and refused by the node");
    assert_eq!(
        run.error(),
        "node 11 refuses DeviceNet 1 Bus-off interrupt: error 0x09 Invalid attribute value"
    );
}

#[test]
fn what_a_node_refuses_is_a_finding() {
    let run = get("10", "0x64/1/3", &[]);
    assert_eq!((run.out().as_str(), run.code()), ("", 1));
    assert_eq!(run.error(), "node 10 refuses class 0x64 1 attribute 3: error 0x16 Object does not exist");
    let [object] = &get("10", "0x64/1/3", &["--json"]).json()[..] else { panic!() };
    assert_eq!(object["status"], 0x16);
}

#[test]
fn a_node_that_is_not_there_is_a_finding() {
    let run = get("13", "1/1/1", &[]);
    assert_eq!((run.out().as_str(), run.code()), ("", 1));
    assert!(run.error().starts_with("node 13: no answer: it is absent"), "{}", run.err());
}

#[test]
fn a_node_of_another_master_is_left_alone() {
    let run = devicenet(&["get", "sim:owned.toml", "10", "1/1/1", "--listen", "6s"]);
    assert_eq!((run.out().as_str(), run.code(), run.error().as_str()), ("", 4, OWNED));
    assert!(run.err().contains("note: node 10 has its master at MAC ID 1\n"), "{}", run.err());
}

/// When the command has listened, that master is not on line yet; when it asks, it is. The command is refused, and the I/O of the master goes on.
#[test]
fn a_node_that_says_whose_it_is_is_left_alone_too() {
    let run = devicenet(&["get", "sim:owned.toml", "10", "1/1/1", "--listen", "500ms"]);
    assert_eq!((run.out().as_str(), run.code(), run.error().as_str()), ("", 4, OWNED));
    for listen in ["6s", "500ms"] {
        let run = devicenet(&["get", "sim:owned.toml", "10", "1/1/1", "--listen", listen, "--json"]);
        assert_eq!((run.code(), run.json().len()), (4, 1), "{}", run.err());
        assert_eq!(run.json()[0]["owned"], true);
    }
}

const OWNED: &str = "node 10 belongs to another master, and is left alone: ask it through that master, or take it off its scan \
                     list first";

/// No cable is open, and no node is absent: there was no more time.
#[test]
fn a_scenario_that_ends_too_early_is_told_as_what_it_is() {
    for (listen, before) in
        [("10s", "anything was sent"), ("4s", "node 10 had answered"), ("4900ms", "node 10 had answered")]
    {
        let run = devicenet(&["get", "sim:short.toml", "10", "1/1/1", "--listen", listen]);
        assert_eq!((run.out().as_str(), run.code()), ("", 2), "{}", run.err());
        let ended = "sim:short.toml: the scenario ended at 5s, before";
        let remedy = "make its duration longer, or --listen shorter";
        assert_eq!(run.error(), format!("{ended} {before}: {remedy}"));
    }
    for (arguments, before) in [
        (&["scan", "sim:short.toml", "--listen", "4s", "--json"][..], "every node was asked"),
        (&["recover", "sim:short.toml", "--listen", "4s"], "all was done"),
        (&["slave", "sim:short.toml", "line.toml", "--node", "gauge", "--listen", "6s"], "anything was sent"),
    ] {
        let run = devicenet(arguments);
        assert_eq!(run.code(), 2, "{}", run.err());
        assert!(run.error().contains(&format!("ended at 5s, before {before}: ")), "{}", run.err());
    }
    let run = devicenet(&["master", "sim:short.toml", "line.toml", "--for", "10s", "--listen", "1s"]);
    assert_eq!(run.code(), 1, "its slaves have other sizes, or are absent: {}", run.err());
    let ended = "note: sim:short.toml: the scenario ended at 5s, before --for 10s was over\n";
    assert!(run.err().contains(ended), "{}", run.err());
    let run = devicenet(&["monitor", "sim:short.toml", "--for", "10s"]);
    assert_eq!(run.err(), "note: sim:short.toml: the scenario ended at 5s, before --for 10s was over\n");
    let log = "log:../../../tests/captures/slave-01-startup-poll.log";
    let run = devicenet(&["record", log, "--for", "10min", "--output", "not-recorded.log"]);
    assert!(
        run.err().contains(": the recording ended at 4.2097s, before --for 600s was over\n"),
        "{}",
        run.err()
    );
}

/// The only other node comes after fifteen seconds.
#[test]
fn nobody_to_acknowledge_is_told_within_ten_seconds() {
    let run = devicenet(&["get", "sim:late.toml", "10", "1/1/1"]);
    assert_eq!((run.out().as_str(), run.code()), ("", 3));
    assert!(run.error().starts_with("nobody on sim:late.toml acknowledges what is sent"), "{}", run.err());
}

#[test]
fn the_own_mac_id_must_be_free() {
    let run = get("10", "1/1/1", &["--own-mac", "11"]);
    assert_eq!(run.code(), 4);
    assert!(
        run.error().starts_with("MAC ID 11 is taken on sim:two.toml: choose another one"),
        "{}",
        run.err()
    );
    let run = get("10", "1/1/1", &["--own-mac", "10"]);
    assert_eq!(run.code(), 2, "{}", run.err());
}

#[test]
fn what_cannot_be_is_said_before_anything_is_sent() {
    for (arguments, code, words) in [
        (&["get", "no-such-can", "10", "1/1/1"][..], 3, "there is no interface no-such-can"),
        (&["get", "lo", "10", "1/1/1", "--allow-tx"], 3, "lo is not a CAN interface"),
        (&["get", "two.toml", "10", "1/1/1"], 2, "two.toml is a file: write log:two.toml"),
        (&["get", "sim:none.toml", "10", "1/1/1"], 2, "none.toml: the scenario cannot be read"),
        (&["get", "log:two.toml", "10", "1/1/1"], 2, "log:two.toml is a recording, which cannot be asked"),
        (
            &["set", "sim:two.toml", "10", "5/2/9", "65536"],
            2,
            "`65536`: Connection 2 expected_packet_rate takes 0 to 65535",
        ),
        (
            &["set", "sim:two.toml", "10", "100/1/1", "1"],
            2,
            "class 0x64 1 attribute 1 takes no number; give its bytes as they are on the wire",
        ),
    ] {
        let run = devicenet(arguments);
        assert_eq!(run.code(), code, "{arguments:?} {}", run.err());
        assert!(run.error().contains(words), "{arguments:?} {}", run.err());
        assert_eq!(run.out(), "");
    }
    for arguments in
        [&["get", "can0", "64", "1/1/1"][..], &["get", "can0", "10", "1/1"], &["get", "can0", "10"]]
    {
        assert_eq!(devicenet(arguments).code(), 2, "{arguments:?}");
    }
}

/// The node takes the MAC ID, says so, and starts anew with it: it would find its duplicate.
#[test]
fn a_node_is_not_sent_onto_a_mac_id_that_is_in_use() {
    let set = |to, listen| devicenet(&["set", "sim:two.toml", "10", "3/1/1", to, "--listen", listen]);
    // Heard; and nothing was heard yet, but it answers.
    for listen in ["3s", "1us"] {
        let run = set("11", listen);
        assert_eq!((run.out().as_str(), run.code()), ("", 4), "{}", run.err());
        let words = "MAC ID 11 is in use, and node 10 would fall silent with it: choose one that";
        assert!(run.error().starts_with(words), "{}", run.err());
        let run = set("12", listen);
        let done = "node 10  DeviceNet 1 MAC ID: done\n";
        assert_eq!((run.out().as_str(), run.code()), (done, 0), "{}", run.err());
        let note = "note: node 10 now checks MAC ID 12, and comes back as node 12";
        assert!(run.err().contains(note), "{}", run.err());
    }
    assert_eq!(set("62", "3s").code(), 2, "that of the command itself");
}

/// A slave that speaks format 8/8 has one byte for a class; it is there all the same, and its connection is released.
#[test]
fn a_class_that_the_format_has_no_room_for() {
    let get = devicenet(&["get", "sim:two.toml", "10", "0x3E7/1/1"]);
    assert_eq!(get.code(), 1, "{}", get.err());
    assert!(
        get.error().starts_with("node 10 cannot be asked for class 0x03E7 1 attribute 1: "),
        "{}",
        get.err()
    );
}
