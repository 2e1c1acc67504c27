//! Every transition of the cycle of a controlled node (DLL_CS), through frames and time: where it leads, and what is counted as lost by
//! it. The rows are those of EPSG DS 301 for a node that is polled, of openPOWERLINK 2.7.2 (`dllkstatemachine.c`) for a stopped one;
//! `docs/conformance.md` names the test of each state.

use core::time::Duration;

use super::bench::*;
use crate::cycle::{CycleState, PollWithoutSoc};
use crate::error::Symptom;
use crate::nmt::NmtState;
use crate::wire::{Flags, NmtCommandId};

/// What was counted: SoC, PReq, SoA.
fn lost(bench: &Bench) -> [u32; 3] {
    let counters = &bench.node.dictionary().counters;
    [Symptom::LossOfSoc, Symptom::LossOfPreq, Symptom::LossOfSoa]
        .map(|symptom| counters.of(symptom).cumulative)
}

/// A node in a place of its cycle, without a loss up to there. Thresholds of 0: it stays where it is.
fn placed(state: NmtState, place: CycleState, poll_without_soc: PollWithoutSoc) -> Bench {
    let mut config = config();
    config.options.poll_without_soc = poll_without_soc;
    let mut bench = Bench::in_state(NmtState::PreOperational1, config);
    for object in [0x1C0B, 0x1C0C, 0x1C0D] {
        bench.writes(object, 3, &[0; 4]).unwrap();
    }
    if place == CycleState::NonCyclic {
        bench.is(NmtState::PreOperational1);
        return bench;
    }
    if state == NmtState::Stopped && place == CycleState::WaitPreq {
        // Left over from before it was stopped, by a command without a SoA before it. That loss is over with the next SoC.
        bench.goes_to(NmtState::PreOperational2);
        bench.soc();
        bench.command(NmtCommandId::STOP_NODE);
        bench.soc();
    } else {
        bench.goes_to(state);
        if state != NmtState::Stopped {
            // The ASnd of the commands came in the place of a SoA.
            bench.cycle();
        }
        bench.soc();
        match place {
            CycleState::NonCyclic | CycleState::WaitPreq => {}
            CycleState::WaitSoa if state == NmtState::Stopped => {}
            CycleState::WaitSoa => bench.preq(Flags::DATA_VALID, &[0]),
            CycleState::WaitSoc => {
                if state != NmtState::Stopped {
                    bench.preq(Flags::DATA_VALID, &[0]);
                }
                bench.soa();
            }
        }
    }
    bench.is(state);
    assert_eq!(bench.node.cycle_state(), place, "{state}");
    bench.forget();
    bench
}

/// An event, what it costs (SoC, PReq, SoA), and where it leads.
type Row = (&'static str, [u32; 3], CycleState);

#[track_caller]
fn holds(state: NmtState, place: CycleState, poll_without_soc: PollWithoutSoc, rows: &[Row]) {
    for (event, losses, to) in rows {
        let mut bench = placed(state, place, poll_without_soc);
        let before = lost(&bench);
        match *event {
            "SoC" => bench.soc(),
            "PReq" => bench.preq(Flags::DATA_VALID, &[0]),
            "PRes" => bench.pres_of_another(),
            "SoA" => bench.soa(),
            "ASnd" => bench.sdo("00 00 00 00"),
            "other" => bench.bytes(&[[0xFF; 6], [2; 6], [8, 0, 0x45, 0, 0, 1]].concat()),
            "timeout" => bench.wait(Duration::from_millis(CYCLE) + Duration::from_micros(100)),
            _ => panic!("{event}"),
        }
        let after = lost(&bench);
        let new = [0, 1, 2].map(|at| after[at] - before[at]);
        assert_eq!((new, bench.node.cycle_state()), (*losses, *to), "{event} at {place} in {state}");
        if *event == "PReq" && state != NmtState::Stopped {
            let rd = u8::from(state == NmtState::Operational);
            bench.says(&std::format!(
                "node 1 -> all: PRes, {}, EN=0 RD={rd}, PR=0 RS=0, 1 byte",
                state.code()
            ));
        }
        bench.says_nothing();
        bench.is(state);
    }
}

const NOTHING: [u32; 3] = [0, 0, 0];
const SOC: [u32; 3] = [1, 0, 0];
const PREQ: [u32; 3] = [0, 1, 0];
const SOA: [u32; 3] = [0, 0, 1];
const SOC_AND_SOA: [u32; 3] = [1, 0, 1];
const POLLED: [NmtState; 2] = [NmtState::ReadyToOperate, NmtState::Operational];

#[test]
fn a_node_outside_of_the_cycle_enters_it_with_a_soc() {
    let mut bench = placed(NmtState::PreOperational1, CycleState::NonCyclic, PollWithoutSoc::Stay);
    for frame in [Bench::soa, Bench::pres_of_another, |bench: &mut Bench| bench.preq(Flags::empty(), &[])] {
        frame(&mut bench);
        assert_eq!((bench.node.cycle_state(), lost(&bench)), (CycleState::NonCyclic, NOTHING));
    }
    bench.soc();
    assert_eq!((bench.node.cycle_state(), lost(&bench)), (CycleState::WaitPreq, NOTHING));
}

#[test]
fn polled_waiting_for_soc() {
    use CycleState::{WaitPreq, WaitSoc};
    for state in POLLED {
        holds(
            state,
            WaitSoc,
            PollWithoutSoc::Stay,
            &[
                ("SoC", NOTHING, WaitPreq),
                ("PReq", SOC, WaitSoc),
                ("PRes", SOC, WaitSoc),
                ("SoA", SOC, WaitSoc),
                ("ASnd", NOTHING, WaitSoc),
                ("other", NOTHING, WaitSoc),
                ("timeout", SOC, WaitSoc),
            ],
        );
    }
}

/// openPOWERLINK takes a PReq or PRes there for one behind the SoC that was lost.
#[test]
fn polled_waiting_for_soc_as_openpowerlink() {
    use CycleState::{WaitPreq, WaitSoa, WaitSoc};
    for state in POLLED {
        holds(
            state,
            WaitSoc,
            PollWithoutSoc::WaitSoa,
            &[
                ("SoC", NOTHING, WaitPreq),
                ("PReq", SOC, WaitSoa),
                ("PRes", SOC, WaitSoa),
                ("SoA", SOC, WaitSoc),
                ("timeout", SOC, WaitSoc),
            ],
        );
    }
}

#[test]
fn polled_waiting_for_preq() {
    use CycleState::{WaitPreq, WaitSoa, WaitSoc};
    for state in POLLED {
        holds(
            state,
            WaitPreq,
            PollWithoutSoc::Stay,
            &[
                ("PReq", NOTHING, WaitSoa),
                ("SoA", PREQ, WaitSoc),
                ("SoC", SOA, WaitPreq),
                ("ASnd", SOA, WaitPreq),
                ("other", SOA, WaitPreq),
                ("PRes", NOTHING, WaitPreq),
                ("timeout", SOC_AND_SOA, WaitSoc),
            ],
        );
    }
}

#[test]
fn polled_waiting_for_soa() {
    use CycleState::{WaitPreq, WaitSoa, WaitSoc};
    for state in POLLED {
        holds(
            state,
            WaitSoa,
            PollWithoutSoc::Stay,
            &[
                ("SoA", NOTHING, WaitSoc),
                ("PReq", SOC_AND_SOA, WaitSoc),
                ("SoC", SOA, WaitPreq),
                ("ASnd", SOA, WaitSoa),
                ("other", SOA, WaitSoa),
                ("PRes", NOTHING, WaitSoa),
                ("timeout", SOC_AND_SOA, WaitSoc),
            ],
        );
    }
}

/// In `PreOperational2` no PReq is due, and the time is not looked at: the cycle length may not be known yet.
#[test]
fn before_it_is_ready_no_preq_is_due_and_no_time_runs() {
    use CycleState::{WaitPreq, WaitSoa, WaitSoc};
    let (state, stay) = (NmtState::PreOperational2, PollWithoutSoc::Stay);
    holds(
        state,
        WaitSoc,
        stay,
        &[("SoC", NOTHING, WaitPreq), ("SoA", SOC, WaitSoc), ("timeout", NOTHING, WaitSoc)],
    );
    holds(
        state,
        WaitPreq,
        stay,
        &[("PReq", NOTHING, WaitSoa), ("SoA", NOTHING, WaitSoc), ("timeout", NOTHING, WaitPreq)],
    );
    holds(
        state,
        WaitSoa,
        stay,
        &[("SoA", NOTHING, WaitSoc), ("SoC", SOA, WaitPreq), ("timeout", NOTHING, WaitSoa)],
    );
}

#[test]
fn stopped_waiting_for_soc() {
    use CycleState::{WaitSoa, WaitSoc};
    holds(
        NmtState::Stopped,
        WaitSoc,
        PollWithoutSoc::Stay,
        &[
            ("SoC", NOTHING, WaitSoa),
            ("SoA", SOC, WaitSoc),
            ("PReq", SOC, WaitSoc),
            ("PRes", NOTHING, WaitSoc),
            ("ASnd", NOTHING, WaitSoc),
            ("timeout", SOC, WaitSoc),
        ],
    );
}

#[test]
fn stopped_waiting_for_preq() {
    use CycleState::{WaitPreq, WaitSoa, WaitSoc};
    holds(
        NmtState::Stopped,
        WaitPreq,
        PollWithoutSoc::Stay,
        &[
            ("PReq", NOTHING, WaitSoa),
            ("SoA", NOTHING, WaitSoc),
            ("SoC", SOA, WaitPreq),
            ("ASnd", SOA, WaitPreq),
            ("other", SOA, WaitPreq),
            ("PRes", NOTHING, WaitPreq),
            ("timeout", SOC_AND_SOA, WaitSoc),
        ],
    );
}

#[test]
fn stopped_waiting_for_soa() {
    use CycleState::{WaitSoa, WaitSoc};
    holds(
        NmtState::Stopped,
        WaitSoa,
        PollWithoutSoc::Stay,
        &[
            ("SoA", NOTHING, WaitSoc),
            ("SoC", SOA, WaitSoa),
            ("ASnd", SOA, WaitSoa),
            ("other", SOA, WaitSoa),
            ("PReq", NOTHING, WaitSoa),
            ("PRes", NOTHING, WaitSoa),
            ("timeout", SOC_AND_SOA, WaitSoc),
        ],
    );
}
