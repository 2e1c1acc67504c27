//! `scan`.

use crate::devicenet;

#[test]
fn the_nodes_of_a_bus_are_asked_who_they_are() {
    let run = devicenet(&["scan", "sim:two.toml", "--listen", "3s"]);
    assert_eq!(
        (run.out().as_str(), run.code()),
        (
            "MAC  state   vendor  type                product  rev  serial      name     master\n \
             10  online  4660    0 (Generic device)  1        1.1  0x00002345  \"valve\"       -\n \
             11  online  4660    0 (Generic device)  7        2.1  0x00002346  \"gauge\"       -\n",
            0
        ),
        "{}",
        run.err()
    );
}

/// A slave that a master has is not asked; the master itself is.
#[test]
fn nodes_of_another_master_are_left_alone() {
    let run = devicenet(&["scan", "sim:owned.toml", "--listen", "6s", "--json"]);
    let nodes = run.json();
    assert_eq!(run.code(), 0, "{}", run.err());
    let macs: Vec<_> = nodes.iter().map(|node| node["mac"].as_u64().unwrap()).collect();
    assert_eq!(macs, [1, 10]);
    assert_eq!(nodes[0]["product_name"], "scanner");
    assert_eq!(
        (&nodes[0]["vendor"], &nodes[0]["device_type"], &nodes[0]["product"]),
        (&0x1234.into(), &12.into(), &2.into())
    );
    assert_eq!((&nodes[0]["serial"], &nodes[0]["revision"]), (&0x2340.into(), &"1.1".into()));
    assert_eq!(nodes[1]["master"], 1);
    assert!(nodes[1].get("product_name").is_none(), "{}", nodes[1]);
}

/// Nothing was heard of it in time, but it says whose it is.
#[test]
fn a_node_that_says_whose_it_is_is_listed() {
    let run = devicenet(&["scan", "sim:owned.toml", "--listen", "0s", "--json"]);
    assert_eq!(run.code(), 0, "{}", run.err());
    let nodes = run.json();
    let macs: Vec<_> = nodes.iter().map(|node| node["mac"].as_u64().unwrap()).collect();
    assert_eq!(macs, [1, 10]);
    assert_eq!((&nodes[1]["state"], &nodes[1]["owned"]), (&"online".into(), &true.into()));
    let run = devicenet(&["scan", "sim:owned.toml", "--listen", "0s"]);
    assert!(run.out().lines().last().unwrap().ends_with("?"), "{}", run.out());
}

#[test]
fn a_recording_is_only_listened_to() {
    let run = devicenet(&["scan", "log:../../../tests/captures/slave-01-startup-poll.log", "--json"]);
    let macs: Vec<_> = run.json().iter().map(|node| node["mac"].as_u64().unwrap()).collect();
    assert_eq!((macs, run.code(), run.err()), (vec![1, 10], 0, String::new()));
    let [master, valve] = &run.json()[..] else { panic!() };
    assert_eq!((&master["owned"], &valve["owned"]), (&false.into(), &true.into()), "it is polled");
    assert_eq!(valve["vendor"], 4660);
}
