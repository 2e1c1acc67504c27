//! Every rule of the doctor has a scenario in `tests/scenarios/health` that breaks it, and one, with `-not` in its name, that
//! nearly does. What the doctor finds in each is complete here: nothing else may be found.

use core::time::Duration;
use std::collections::BTreeSet;

use devicenet_cli::health;
use devicenet_cli::scenario::Scenario;
use devicenet_cli::simulate::{self, Settings};
use devicenet_core::doctor::{Doctor, DoctorConfig, Finding, Intrusion, Rule};

use crate::scenario;

/// Rule, and the MAC ID of the node.
type Found = (Rule, Option<u8>);

/// A rule, what is found in its scenario, and in the one that nearly breaks it.
const SCENARIOS: &[(Rule, &[Found], &[Found])] = &[
    (Rule::NotAnswering, &[(Rule::NotAnswering, Some(10))], &[]),
    (Rule::NotFound, &[(Rule::NotFound, Some(10))], &[]),
    (Rule::SlowAnswers, &[(Rule::SlowAnswers, Some(10))], &[]),
    (Rule::MasterSilent, &[(Rule::MasterSilent, Some(1))], &[]),
    (Rule::DuplicateMacId, &[(Rule::DuplicateMacId, Some(10))], &[(Rule::IdentityChanged, Some(10))]),
    (
        Rule::WaitingForRecovery,
        &[(Rule::DuplicateMacId, Some(10)), (Rule::WaitingForRecovery, Some(10))],
        &[],
    ),
    (Rule::Fault, &[(Rule::Fault, Some(10))], &[]),
    (Rule::KeyMismatch, &[(Rule::KeyMismatch, Some(10))], &[]),
    (Rule::SizeMismatch, &[(Rule::SizeMismatch, Some(10))], &[]),
    (Rule::IdentityChanged, &[(Rule::IdentityChanged, Some(10))], &[(Rule::Restarted, Some(10))]),
    (Rule::AllocationRefused, &[(Rule::AllocationRefused, Some(11))], &[(Rule::Restarted, Some(1))]),
    (Rule::TwoMasters, &[(Rule::TwoMasters, Some(10))], &[]),
    (Rule::ForeignMacId, &[(Rule::ForeignMacId, Some(20))], &[]),
    (
        Rule::UnexpectedAllocation,
        &[
            (Rule::TwoMasters, Some(10)),
            (Rule::MasterSilent, Some(1)),
            (Rule::UnexpectedAllocation, Some(10)),
        ],
        &[(Rule::MasterSilent, Some(1)), (Rule::Restarted, Some(1))],
    ),
    (Rule::IdentifierCollision, &[(Rule::IdentifierCollision, Some(10))], &[]),
    (
        Rule::BusOff,
        &[(Rule::ErrorPassive, Some(10)), (Rule::BusOff, Some(10))],
        &[(Rule::DuplicateMacId, Some(10))],
    ),
    (Rule::ErrorPassive, &[(Rule::ErrorPassive, Some(1))], &[]),
    (
        Rule::ErrorFrames,
        &[(Rule::ErrorPassive, Some(10)), (Rule::ErrorPassive, Some(1)), (Rule::ErrorFrames, None)],
        &[],
    ),
    (
        Rule::NotAcknowledged,
        &[(Rule::ErrorPassive, Some(1)), (Rule::NotAcknowledged, None)],
        &[(Rule::ErrorPassive, Some(1))],
    ),
    (Rule::ForeignTraffic, &[(Rule::ForeignTraffic, None)], &[]),
    (Rule::BusLoad, &[(Rule::BusLoad, None)], &[]),
    (Rule::WrongLength, &[(Rule::WrongLength, Some(10))], &[]),
    (Rule::FragmentSequence, &[(Rule::FragmentSequence, Some(10))], &[]),
    (Rule::Restarted, &[(Rule::Restarted, Some(10))], &[]),
    (Rule::Left, &[(Rule::Left, Some(10))], &[(Rule::Restarted, Some(10))]),
];

/// Only a controller that loses frames can tell it: the simulated bus has no such listener.
const WITHOUT_SCENARIO: Rule = Rule::Overrun;

/// The findings in a scenario, with what its scan lists say, or else what is learned.
#[track_caller]
fn findings(scenario: &Scenario, intrusion: Intrusion) -> Vec<Finding> {
    let mut config = DoctorConfig::default();
    (config.bit_rate, config.intrusion) = (Some(scenario.bus.bit_rate), intrusion);
    let mut doctor = Box::new(Doctor::new(config));
    if !matches!(intrusion, Intrusion::Learned(_)) {
        health::expect(&mut doctor, scenario);
    }
    let outcome = simulate::examine(scenario, Settings::default(), &mut doctor);
    assert_eq!(outcome.verdict.failures, []);
    assert_eq!(doctor.forgotten(), devicenet_core::doctor::Forgotten::default());
    doctor.findings().copied().collect()
}

fn short(findings: &[Finding]) -> Vec<Found> {
    findings.iter().map(|finding| (finding.rule, finding.node.map(u8::from))).collect()
}

#[test]
fn every_rule_has_a_scenario_that_breaks_it_and_one_that_does_not() {
    let listed: Vec<Rule> = SCENARIOS.iter().map(|(rule, ..)| *rule).collect();
    let expected: Vec<Rule> = Rule::ALL.iter().copied().filter(|rule| *rule != WITHOUT_SCENARIO).collect();
    assert_eq!(listed, expected, "every rule has one");
    let mut wrong = Vec::new();
    for &(rule, broken, kept) in SCENARIOS {
        assert!(broken.iter().any(|(found, _)| *found == rule), "{rule} is not in its own scenario");
        assert!(kept.iter().all(|(found, _)| *found != rule), "{rule} is in that of its near miss");
        let intrusion = match rule {
            Rule::ForeignMacId => Intrusion::Expected,
            Rule::UnexpectedAllocation => Intrusion::Learned(Duration::from_secs(5)),
            _ => Intrusion::Allowed,
        };
        for (name, expected) in [(rule.code().to_owned(), broken), (format!("{rule}-not"), kept)] {
            let found = findings(&scenario(&format!("health/{name}")), intrusion);
            if short(&found) != expected {
                let words: Vec<String> = found.iter().map(ToString::to_string).collect();
                wrong.push(format!("{name}: {:?}, {words:#?}", short(&found)));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// A scenario that is added must be listed above.
#[test]
fn every_scenario_belongs_to_a_rule() {
    let directory = devicenet_tests::workspace_root().join("tests/scenarios/health");
    let files = std::fs::read_dir(&directory).expect("the scenarios are there");
    let found: BTreeSet<String> = files
        .map(|entry| entry.expect("a readable entry").file_name().into_string().expect("UTF-8"))
        .collect();
    let name = |rule: &Rule, not: &str| format!("{rule}{not}.toml");
    let expected: BTreeSet<String> =
        SCENARIOS.iter().flat_map(|(rule, ..)| [name(rule, ""), name(rule, "-not")]).collect();
    assert_eq!(found, expected);
}

/// What the other scenarios show. A network in order has no finding; where there is one, it is what the scenario is about.
const OTHERS: &[(&str, &[Found])] = &[
    ("auto-bit-rate", &[]),
    ("bus-off-boi-0", &[(Rule::ErrorPassive, Some(10)), (Rule::BusOff, Some(10))]),
    (
        "bus-off-boi-1",
        &[(Rule::ErrorPassive, Some(10)), (Rule::BusOff, Some(10)), (Rule::DuplicateMacId, Some(10))],
    ),
    (
        "duplicate-3-at-once",
        &[(Rule::ErrorFrames, None), (Rule::ErrorPassive, Some(63)), (Rule::DuplicateMacId, Some(63))],
    ),
    (
        "duplicate-3-at-once-alone",
        &[(Rule::ErrorFrames, None), (Rule::ErrorPassive, Some(63)), (Rule::DuplicateMacId, Some(63))],
    ),
    (
        "duplicate-63-at-once",
        &[
            (Rule::ErrorFrames, None),
            (Rule::ErrorPassive, Some(63)),
            (Rule::DuplicateMacId, Some(63)),
            (Rule::BusOff, Some(63)),
        ],
    ),
    (
        "duplicate-63-at-once-alone",
        &[
            (Rule::ErrorFrames, None),
            (Rule::ErrorPassive, Some(63)),
            (Rule::DuplicateMacId, Some(63)),
            (Rule::BusOff, Some(63)),
        ],
    ),
    (
        "duplicate-at-once",
        &[(Rule::ErrorFrames, None), (Rule::ErrorPassive, Some(63)), (Rule::DuplicateMacId, Some(63))],
    ),
    ("duplicate-at-once-alone", &[(Rule::ErrorFrames, None), (Rule::ErrorPassive, Some(63))]),
    ("duplicate-in-the-first-wait", &[(Rule::DuplicateMacId, Some(10))]),
    ("duplicate-in-the-second-wait", &[(Rule::DuplicateMacId, Some(10))]),
    ("duplicate-late", &[(Rule::DuplicateMacId, Some(10))]),
    ("duplicate-while-the-first-is-alone", &[(Rule::ErrorPassive, Some(10))]),
    ("exchange", &[]),
    ("lone", &[(Rule::ErrorPassive, Some(10)), (Rule::NotAcknowledged, None)]),
    ("lone-until-another-comes", &[(Rule::ErrorPassive, Some(10))]),
    ("master-lost", &[(Rule::MasterSilent, Some(1)), (Rule::Restarted, Some(1))]),
    ("offline-owner-lost", &[(Rule::DuplicateMacId, Some(10))]),
    ("offline-repair", &[(Rule::DuplicateMacId, Some(10)), (Rule::WaitingForRecovery, Some(10))]),
    ("offline-tool", &[(Rule::DuplicateMacId, Some(10)), (Rule::WaitingForRecovery, Some(10))]),
    ("quick-connect", &[]),
    ("quick-connect-duplicate", &[(Rule::DuplicateMacId, Some(10))]),
    (
        "replacement",
        &[
            (Rule::ErrorPassive, Some(1)),
            (Rule::NotAcknowledged, None),
            (Rule::NotAnswering, Some(10)),
            (Rule::IdentityChanged, Some(63)),
            (Rule::IdentityChanged, Some(10)),
        ],
    ),
    (
        "segments-joined",
        &[(Rule::ErrorFrames, None), (Rule::ErrorPassive, Some(10)), (Rule::DuplicateMacId, Some(10))],
    ),
    ("triggered-producer", &[]),
    ("two-producers", &[(Rule::IdentifierCollision, Some(10))]),
    ("slave-lost", &[(Rule::NotAnswering, Some(10)), (Rule::Restarted, Some(10))]),
    (
        "wrong-bit-rate",
        &[
            (Rule::ErrorPassive, Some(5)),
            (Rule::ErrorFrames, None),
            (Rule::ErrorPassive, Some(10)),
            (Rule::ErrorPassive, Some(0)),
        ],
    ),
    (
        "wrong-devices",
        &[
            (Rule::KeyMismatch, Some(10)),
            (Rule::AllocationRefused, Some(13)),
            (Rule::NotFound, Some(12)),
            (Rule::SizeMismatch, Some(11)),
        ],
    ),
];

#[test]
fn no_false_alarms_in_the_other_scenarios() {
    let mut wrong = Vec::new();
    for &(name, expected) in OTHERS {
        let found = findings(&scenario(name), Intrusion::Allowed);
        if short(&found) != expected {
            let words: Vec<String> = found.iter().map(ToString::to_string).collect();
            wrong.push(format!("{name}: {:?}, {words:#?}", short(&found)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// The built-in plant: nine acts, and what a plant engineer would be told of them.
#[test]
fn the_plant() {
    let plant =
        Scenario::parse("plant", simulate::PLANT, std::path::Path::new("")).expect("the plant is right");
    let mut report = String::new();
    for finding in findings(&plant, Intrusion::Allowed) {
        let until = finding.until.map_or_else(|| "..".to_owned(), |until| format!("{until:.3}"));
        let code = finding.scanner_status().map_or_else(String::new, |status| format!(" [{}]", status.0));
        report += &format!("{:.3} - {until}  {}{code}  {finding}\n", finding.since, finding.severity);
        report += &format!("    {}\n", finding.advice());
    }
    insta::with_settings!({
        description => "since when, until when, how bad, the code of a scanner display, what, and what to check next",
        omit_expression => true,
        prepend_module_to_snapshot => false,
    }, {
        insta::assert_snapshot!("health__plant", report);
    });
}

/// Whoever begins to listen later hears a part of it: it can find less than who has heard all, and nothing else.
#[test]
fn who_joins_later_finds_nothing_else() {
    let plant =
        Scenario::parse("plant", simulate::PLANT, std::path::Path::new("")).expect("the plant is right");
    let health =
        SCENARIOS.iter().flat_map(|(rule, ..)| [format!("health/{rule}"), format!("health/{rule}-not")]);
    let named =
        OTHERS.iter().map(|(name, _)| (*name).to_owned()).chain(health).map(|name| (scenario(&name), name));
    let mut wrong = Vec::new();
    for (scenario, name) in [(plant, "plant".to_owned())].into_iter().chain(named) {
        let frames = simulate::outcome(&scenario, Settings::default()).summary.bus.frames;
        let mut config = DoctorConfig::default();
        config.bit_rate = Some(scenario.bus.bit_rate);
        // A prime does not fall into step with what is repeated.
        let step = (frames / CUTS).max(1) | 1;
        let cuts = std::iter::once(0).chain((2..=frames).step_by(usize::try_from(step).expect("a few")));
        let mut doctors: Vec<_> = cuts.map(|cut| (cut, Box::new(Doctor::new(config)))).collect();
        let listening = doctors.iter_mut().map(|(cut, doctor)| (*cut, &mut **doctor));
        let _ = simulate::examine_from(&scenario, Settings::default(), listening);
        let ((_, whole), later) = doctors.split_first().expect("one has heard all");
        for (cut, doctor) in later {
            let is_less = |found: &Finding, known: &Finding| {
                let rule = if found.rule == Rule::NotFound { Rule::NotAnswering } else { found.rule };
                (known.rule == rule || known.rule == found.rule)
                    // Who waits for recovery had a MAC ID before that.
                    && (known.node == found.node || found.node.is_none())
                    && found.severity <= known.severity
            };
            let others =
                doctor.findings().filter(|found| !whole.findings().any(|known| is_less(found, known)));
            wrong.extend(others.map(|found| format!("{name} from frame {cut}: {} {found}", found.severity)));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// So many begin to listen to each scenario.
const CUTS: u64 = 40;
