//! The load of a bus, as the monitor tells it.

use crate::devicenet;

/// The load of each node adds up to that of the bus, and so do the purposes: every frame has a sender and a purpose.
#[test]
fn loads_add_up() {
    let objects = devicenet(&["monitor", "sim:../../scenarios/plant.toml", "--json"]).json();
    assert!(objects.iter().any(|object| object["event"] == "summary"));
    for summary in objects.iter().filter(|object| object["event"] == "summary") {
        let loads = summary["load_total"].as_object().unwrap();
        let all = loads["all"].as_f64().unwrap();
        let sum: f64 =
            loads.iter().filter(|(name, _)| *name != "all").map(|(_, load)| load.as_f64().unwrap()).sum();
        assert!((all - sum).abs() < 1e-5, "{loads:?}");
        let nodes = summary["nodes"].as_array().unwrap();
        let nodes: f64 = nodes.iter().map(|node| node["load_total"].as_f64().unwrap()).sum();
        let nobody = loads["errors"].as_f64().unwrap() + loads["offline"].as_f64().unwrap();
        assert!(nodes <= all + 1e-5 && nodes + nobody + 1e-3 >= all, "{nodes} of {all}");
    }
}

/// What the monitor says of the load is what the simulated bus says of itself, to the bit.
#[test]
fn the_load_is_that_of_the_bus() {
    let last = devicenet(&["monitor", "sim:drop.toml", "--json"]).json().pop().unwrap();
    let bus = devicenet(&["simulate", "drop.toml", "--summary", "--json"]).json();
    let busy = bus.last().unwrap()["bus"]["load"].as_f64().unwrap();
    let load = last["load_total"]["all"].as_f64().unwrap();
    assert!((load - busy).abs() < 1e-6, "{load} instead of {busy}");
}

/// A recording does not tell its bit rate. What would be too much at 125 kbit/s is no finding, and a burst shows that it was more.
#[test]
fn the_load_of_an_unknown_bit_rate_is_the_most_that_it_can_be() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/unknown-rate.log");
    // Every 1.2 ms a frame of 0.9 ms at 125 kbit/s.
    let frame = |at: u32| format!("({}.{:06}) can0 3C1#5555555555555555\n", at / 1_000_000, at % 1_000_000);
    let slow: String = (0..5_000).map(|n| frame(n * 1_200)).collect();
    std::fs::write(path, &slow).unwrap();
    let endpoint = format!("log:{path}");
    let told = |more: &[&str]| {
        let last = devicenet(&[&["monitor", &endpoint, "--json"], more].concat()).json().pop().unwrap();
        let is_judged = last["findings"].as_array().unwrap().iter().any(|found| found["rule"] == "bus_load");
        let load = last["load_total"]["all"].as_f64().unwrap();
        let source = last["bit_rate_source"].as_str().unwrap().to_owned();
        (last["bit_rate"].as_u64().unwrap(), source, load, is_judged)
    };
    let (rate, source, load, is_judged) = told(&[]);
    assert_eq!((rate, source.as_str(), is_judged), (125_000, "least", false));
    assert!((0.7..0.8).contains(&load), "{load}");
    let text = devicenet(&["monitor", &endpoint]).out();
    assert!(
        text.contains("in the end: up, error-active, load at most 7")
            && text.contains("of 125 kbit/s or more: "),
        "{text}"
    );
    let (rate, source, _, is_judged) = told(&["--bit-rate", "125k"]);
    assert_eq!((rate, source.as_str(), is_judged), (125_000, "known", true));
    // The same, behind forty that an adapter told at once: then it is not judged either.
    let late: String = (0..40).map(|_| frame(0)).collect();
    std::fs::write(path, late + &(0..5_000).map(|n| frame(1_000_000 + n * 1_200)).collect::<String>())
        .unwrap();
    let (rate, source, _, is_judged) = told(&["--bit-rate", "125k"]);
    assert_eq!((rate, source.as_str(), is_judged), (250_000, "least", false));
    let summary = devicenet(&["decode", "--summary", "--json", "--bit-rate", "125k", path]).json();
    assert_eq!((&summary[0]["bit_rate"], &summary[0]["bit_rate_source"]), (&250_000.into(), &"least".into()));
    assert!(summary.iter().all(|line| line["rule"] != "bus_load"), "{summary:?}");
    // The same, and two hundred frames within the time of sixty.
    let burst: String = (0..200).map(|n| frame(6_000_000 + n * 250)).collect();
    std::fs::write(path, slow + &burst).unwrap();
    let (rate, source, load, is_judged) = told(&[]);
    assert_eq!((rate, source.as_str(), is_judged), (500_000, "least", false));
    assert!((0.18..0.2).contains(&load), "{load}");
    let bus = devicenet(&["decode", "--summary", "--json", path]).json().remove(0);
    assert_eq!((&bus["bit_rate"], &bus["bit_rate_source"]), (&500_000.into(), &"least".into()));
    assert!((bus["load"].as_f64().unwrap() - load).abs() < 0.001, "{bus}");
    let text = devicenet(&["decode", "--summary", path]).out();
    let words = "at 500 kbit/s or more (--bit-rate says which), stuff bits and intermission included\n";
    assert!(text.contains("bus load at most 1") && text.contains(words), "{text}");
}

/// An error frame takes 17 bits at least, and at a bit rate that is only the least, the share of the time is neither the least nor the most.
#[test]
fn the_load_of_errors_is_told_as_what_it_is() {
    let path = concat!(env!("CARGO_TARGET_TMPDIR"), "/errors.log");
    let line = |n: u32| {
        format!("({}.000000) can0 3C1#5555555555555555\n({0}.500000) can0 20000080#0000000000000000\n", n + 1)
    };
    std::fs::write(path, (0..10).map(line).collect::<String>()).unwrap();
    let endpoint = format!("log:{path}");
    let of_rate: [(&[&str], [&str; 3]); 2] = [
        (&["--bit-rate", "125k"], ["bus load 0.", "take 0.01 % of the time at least: how", "load 0."]),
        (&[], ["bus load about 0.", "take about 0.01 % of the time: how", "load about 0."]),
    ];
    for (rate, [load, errors, monitored]) in of_rate {
        let summary = devicenet(&[&["decode", "--summary", path], rate].concat()).out();
        assert!(
            summary.contains(load) && summary.contains(&format!("\n10 error frames {errors} much")),
            "{summary}"
        );
        let text = devicenet(&[&["monitor", &endpoint, "--text"], rate].concat()).out();
        assert!(text.contains(&format!("error-active, {monitored}")), "{text}");
    }
}
