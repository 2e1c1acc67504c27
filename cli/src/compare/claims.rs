//! The claims of the paper, each held against what was measured.

use core::fmt;
use core::time::Duration;

use serde::{Serialize, Serializer};

use super::bench::Traffic;
use super::half::Half;

/// What the paper claims of DeviceNeX over DeviceNet, and what came out.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Claim {
    /// In the words of the paper, or close to them.
    pub claim: &'static str,
    /// Whether the figures bear it out.
    pub holds: bool,
    /// What they say, in a sentence.
    pub finding: String,
    /// The figures.
    pub measures: Vec<Measure>,
}

/// A figure of both protocols.
#[derive(Clone, PartialEq, Eq, Debug, Serialize)]
pub struct Measure {
    /// What was measured.
    pub measure: String,
    /// Of DeviceNet.
    pub devicenet: Value,
    /// Of DeviceNeX.
    pub devicenex: Value,
}

/// A figure.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Value {
    /// A number of things.
    Count(usize),
    /// A time, in seconds when it is serialised.
    Time(Duration),
    /// What cannot be counted.
    Words(&'static str),
}

pub(super) fn claims(net: &Half, nex: &Half) -> Vec<Claim> {
    vec![
        at_once(net, nex),
        nodes(net, nex),
        two_steps(net, nex),
        peer_to_peer(net, nex),
        replacement(net, nex),
        standby(net, nex),
    ]
}

fn at_once(net: &Half, nex: &Half) -> Claim {
    let (old, new) = (&net.fresh, &nex.fresh);
    let holds = new.usable_at_last == new.devices && old.usable_at_last < old.devices;
    let finding = format!(
        "{} of {} DeviceNet devices get on line by themselves, {} of {} of DeviceNeX, and cause {} and {} error frames. {}",
        old.usable_at_last,
        old.devices,
        new.usable_at_last,
        new.devices,
        old.error_frames,
        new.error_frames,
        if new.usable < new.devices {
            "But that takes DeviceNeX longer than five seconds: every device finds the bit rate, says Hello twice without an \
             address, and twice with one."
        } else {
            "They are there within five seconds."
        }
    );
    let measures = vec![
        count("error frames", old.error_frames, new.error_frames),
        count("devices that go bus-off", old.bus_off, new.bus_off),
        count("devices usable after 5 s", old.usable, new.usable),
        count("devices usable at last", old.usable_at_last, new.usable_at_last),
        time("until the last of these is", old.until_usable, new.until_usable),
    ];
    Claim { claim: "out-of-box devices can be connected at the same time", holds, finding, measures }
}

fn nodes(net: &Half, nex: &Half) -> Claim {
    let (old, new) = (&net.full, &nex.full);
    let finding = format!("{} nodes on line against {}.", new.on_line, old.on_line);
    let measures = vec![
        count("nodes on line", old.on_line, new.on_line),
        time("until all are, from power-up", old.until_on_line, new.until_on_line),
    ];
    Claim { claim: "larger node count", holds: new.on_line > old.on_line, finding, measures }
}

fn two_steps(net: &Half, nex: &Half) -> Claim {
    let (old, new) = (&net.establishment, &nex.establishment);
    let holds = new.of_producer.frames == 2 && new.of_consumer.frames == 2;
    let consumer = if new.of_consumer.frames == 2 {
        "So does one that consumes.".to_owned()
    } else {
        format!(
            "One that consumes needs {}, which is more than two steps: over an explicit connection it is told whose data.",
            new.of_consumer.frames
        )
    };
    let finding = format!(
        "A device that produces needs {} frames from on-line to its first data, against {}. {consumer} Access to the network \
         costs {} bus time, and with it everything is there {}.",
        new.of_producer.frames,
        old.of_producer.frames,
        if old.access.wire < new.access.wire { "more" } else { "less" },
        if new.until_data > old.until_data { "later" } else { "sooner" }
    );
    let measures = vec![
        count("frames from on-line to data, a producer", old.of_producer.frames, new.of_producer.frames),
        time("bus time of these", old.of_producer.wire, new.of_producer.wire),
        count("frames from on-line to data, a consumer", old.of_consumer.frames, new.of_consumer.frames),
        time("bus time of these", old.of_consumer.wire, new.of_consumer.wire),
        count(&format!("frames of all {} producers", old.devices), old.of_all.frames, new.of_all.frames),
        time("bus time of these", old.of_all.wire, new.of_all.wire),
        time("bus time of network access", old.access.wire, new.access.wire),
        time("from power-up to the data of all", old.until_data, new.until_data),
    ];
    Claim { claim: "a connection is established in two steps", holds, finding, measures }
}

fn peer_to_peer(net: &Half, nex: &Half) -> Claim {
    let (Traffic { frames, wire }, new) = (net.transfer.traffic, nex.transfer.traffic);
    let finding = format!(
        "{} instead of {frames}: B tells A and C itself, without a master that asks and passes on. That a frame holds more data \
         does not show with two bytes.",
        if new.frames == 1 { "One frame".to_owned() } else { format!("{} frames", new.frames) }
    );
    let measures = vec![
        count("frames that move an input from B to A and C", frames, new.frames),
        time("bus time of these", wire, new.wire),
        time("delay from B to the last of both, at least", net.transfer.fastest, nex.transfer.fastest),
        time("at most", net.transfer.slowest, nex.transfer.slowest),
    ];
    let holds = new.frames < frames && new.wire < wire;
    Claim { claim: "more data in a frame, peer to peer without a proxy", holds, finding, measures }
}

fn replacement(net: &Half, nex: &Half) -> Claim {
    let (old, new) = (&net.replacement, &nex.replacement);
    let finding = format!(
        "Nobody has to do anything in either: DeviceNet has automatic device replacement too, with one spare at MAC ID 63. \
         It takes {} against {}. The device that comes back {}, in DeviceNet it is {}.",
        Value::Time(new.until_data),
        Value::Time(old.until_data),
        new.returned,
        old.returned
    );
    let measures = vec![
        time("from the cut to the first data of the spare", old.until_data, new.until_data),
        Measure {
            measure: "the device that comes back".to_owned(),
            devicenet: Value::Words(old.returned),
            devicenex: Value::Words(new.returned),
        },
    ];
    let holds = new.until_data < old.until_data && new.is_spare_again;
    Claim { claim: "fully automatic device replacement", holds, finding, measures }
}

fn standby(net: &Half, nex: &Half) -> Claim {
    let (old, new) = (&net.standby, &nex.standby);
    let holds = new.passed < old.passed;
    let finding = format!(
        "{} of {} frames pass the filter of a device in Standby, and {} of {} that of a DeviceNet device without a task. {}",
        new.passed,
        new.frames,
        old.passed,
        old.frames,
        if holds {
            "That is less."
        } else {
            "The filter of DeviceNet lets nothing through that is not for the device, either, in a controller that compares all \
             eleven bits; the paper has those in mind that compare eight. What DeviceNeX saves are the other frames: there is \
             no master that polls."
        }
    );
    let measures = vec![
        count("frames on the bus in 10 s, one device missing", old.frames, new.frames),
        count("of them through the filter of an idle device", old.passed, new.passed),
    ];
    Claim { claim: "fewer interrupts in Standby", holds, finding, measures }
}

fn count(measure: &str, devicenet: usize, devicenex: usize) -> Measure {
    Measure {
        measure: measure.to_owned(),
        devicenet: Value::Count(devicenet),
        devicenex: Value::Count(devicenex),
    }
}

fn time(measure: &str, devicenet: Duration, devicenex: Duration) -> Measure {
    Measure {
        measure: measure.to_owned(),
        devicenet: Value::Time(devicenet),
        devicenex: Value::Time(devicenex),
    }
}

impl Value {
    /// Its length in a picture; `None` for words.
    pub(super) fn size(self) -> Option<f64> {
        match self {
            Self::Count(count) => Some(count as f64),
            Self::Time(time) => Some(time.as_secs_f64()),
            Self::Words(_) => None,
        }
    }
}

/// `64`, `3.376 ms`, `2.006 s`
impl fmt::Display for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count(count) => write!(f, "{count}"),
            // Integers are the same on every machine.
            Self::Time(time) if *time < Duration::from_secs(1) => {
                let micros = time.as_micros();
                write!(f, "{}.{:03} ms", micros / 1_000, micros % 1_000)
            }
            Self::Time(time) => write!(f, "{}.{:03} s", time.as_secs(), time.subsec_millis()),
            Self::Words(words) => f.write_str(words),
        }
    }
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Count(count) => serializer.serialize_u64(*count as u64),
            Self::Time(time) => serializer.serialize_f64(time.as_nanos() as f64 / 1e9),
            Self::Words(words) => serializer.serialize_str(words),
        }
    }
}
