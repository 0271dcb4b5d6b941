//! Compiled sources of random designs against [`squid_scheduled::Autopilot`]: all outputs are identical to the bit.
#![allow(clippy::unwrap_used, missing_docs)]

mod design;

use design::example::{SIGNALS, SPEED, TRACKED};
use design::{Random, random};
use squid_embedded::{ExportError, Real, SourceError, Standing, compare as compare_sources, export};
use squid_scheduled::{Autopilot, ControllerDesign, Health, Inputs, Supervisor, TickError};
use std::f64::consts::TAU;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

const TICKS: usize = 2000;
const STATUS_OUT_OF_RANGE: u64 = 1;
const STATUS_SATURATED: u64 = 2;
const STATUS_REFERENCE_LIMITED: u64 = 4;
const STATUS_FAILED: u64 = 8;
/// Bits of lost measurements.
const STATUS_LOST: u64 = 0xfff0;
/// Bit of the first actuator at its limit.
const STATUS_SATURATED_FIRST: u64 = 0x10000;

/// Operation at a row.
#[derive(Debug, Clone, Copy, PartialEq)]
enum What {
    Step,
    Reset,
    /// Follow the applied commands, then step.
    Follow,
    /// Feed back the applied commands, then step.
    FeedBack,
}

/// Operation, inputs, applied commands in units of the outputs, and ages of the measurements in s.
type Row = (What, Inputs, Vec<f64>, Vec<f64>);

/// An autopilot with its supervisor, as in the FMU.
#[derive(Clone)]
struct Flown {
    autopilot: Autopilot,
    supervisor: Supervisor,
}

fn standing() -> Standing {
    Standing { claims: vec!["Nothing is proved of an example.".into()], certificate_sha256: None }
}

/// Returns the outputs of the compiled source: a row of doubles for the initialisation and for each row of inputs.
fn replayed(design: &ControllerDesign, real: Real, rows: &[Row]) -> Vec<Vec<f64>> {
    let folder = tempfile::tempdir().unwrap();
    let source = export(design, &standing(), real).unwrap();
    assert_eq!(source.name, "example_a_b_c_f", "vehicle and design, as in replay.c");
    let file = |end: &str| folder.path().join(format!("{}.{end}", source.name));
    std::fs::write(file("h"), &source.header).unwrap();
    std::fs::write(file("c"), &source.source).unwrap();
    let replay = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/replay.c");
    let warnings = ["-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror"];
    let program = folder.path().join("replay");
    let done = Command::new("cc")
        .args(["-std=c99", "-O1"])
        .args(warnings)
        .arg("-I")
        .args([folder.path(), &file("c"), &replay])
        .arg("-o")
        .args([&program])
        .arg("-lm")
        .status()
        .unwrap();
    assert!(done.success(), "{design:?}");
    let taken = |(what, inputs, applied, ages): &Row| {
        let measured = (0..SIGNALS).filter(|i| design.measures(*i)).map(|i| inputs.measured[i]);
        let wanted = (0..TRACKED).filter(|i| design.follows(*i)).map(|i| inputs.references[i]);
        let all = std::iter::once(f64::from(*what as u8)).chain(measured).chain(wanted);
        let ages = watched(design).map(|i| ages[i]);
        all.chain(ages).chain(applied.iter().copied()).collect::<Vec<_>>()
    };
    let bytes: Vec<u8> = rows.iter().flat_map(taken).flat_map(f64::to_le_bytes).collect();
    let mut child = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut input = child.stdin.take().unwrap();
    let writer = std::thread::spawn(move || input.write_all(&bytes).unwrap());
    let output = child.wait_with_output().unwrap();
    writer.join().unwrap();
    assert!(output.status.success());
    let numbers: Vec<f64> =
        output.stdout.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect();
    numbers.chunks_exact(design.actuators.len() + 4 + followed(design).count()).map(<[f64]>::to_vec).collect()
}

/// Returns inputs that vary, leave the range, or are far too large, infinite or NaN; with occasional resets.
fn rows(random: &mut Random, design: &ControllerDesign) -> Vec<Row> {
    let mut inputs = at_rest(design);
    let row = |tick: usize| {
        // The last quarter is undisturbed, so that an actuator stays at its limit.
        let steady = tick > TICKS - TICKS / 4;
        for number in inputs.measured.iter_mut().chain(&mut inputs.references) {
            *number += random.between(-0.1, 0.1);
        }
        // A circular angle jumps by full turns, and by half a turn, for which both directions are equally short.
        if let Some(index) = design.signals.iter().position(|signal| signal.circular) {
            let turned = [0.5 * TAU, TAU, -3.0 * TAU][random.below(3)];
            let which = random.below(30);
            inputs.measured[index] += if which == 0 { turned } else { 0.0 };
            inputs.references[index] += if which == 1 { turned } else { 0.0 };
        }
        if random.one_of(40) && !steady {
            inputs = at_rest(design);
            inputs.measured[SPEED] = random.between(-1.0, 5.0);
            inputs.references[SPEED] = random.between(-1.0, 5.0);
        }
        let mut now = inputs.clone();
        let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1e308, 1e12, -0.0, 5e-324];
        if random.one_of(25) && !steady {
            let index = random.below(SIGNALS + TRACKED);
            let number = odd[random.below(odd.len())];
            // Autopilot rejects all of them, but C has only the inputs that the design takes.
            match index.checked_sub(SIGNALS) {
                Some(index) if design.follows(index) => now.references[index] = number,
                None if design.measures(index) => now.measured[index] = number,
                _ => {}
            }
        }
        let what = match random.below(60) {
            _ if steady => What::Step,
            0 => What::Reset,
            1..10 => What::Follow,
            10..20 => What::FeedBack,
            _ => What::Step,
        };
        let mut applied: Vec<f64> = design.actuators.iter().map(|one| any_command(random, one)).collect();
        if random.one_of(40) {
            let index = random.below(applied.len());
            applied[index] = odd[random.below(odd.len())];
        }
        let ages = (0..SIGNALS).map(|_| if random.one_of(200) { random.between(-1.0, 2.0) } else { 0.0 });
        (what, now, applied, ages.collect())
    };
    (0..TICKS).map(row).collect()
}

/// Returns a command in the units of the actuator, occasionally beyond its limits.
fn any_command(random: &mut Random, actuator: &squid_scheduled::Actuator) -> f64 {
    let [least, most] = [actuator.minimum, actuator.maximum].map(|end| actuator.input_for(end).0);
    random.between(1.2 * least - 0.2 * most, 1.2 * most - 0.2 * least)
}

/// Returns the indices of the signals whose sensors are monitored.
fn watched(design: &ControllerDesign) -> impl Iterator<Item = usize> {
    (0..SIGNALS).filter(|index| design.failsafe.is_some() && design.measures(*index))
}

/// Returns the indices of the references that the design follows.
fn followed(design: &ControllerDesign) -> impl Iterator<Item = usize> {
    (0..TRACKED).filter(|index| design.follows(*index))
}

fn at_rest(design: &ControllerDesign) -> Inputs {
    let autopilot = Autopilot::new(design).unwrap();
    autopilot.level(design.scheduling.centre)
}

fn run(
    design: &ControllerDesign,
    Flown { autopilot, supervisor }: &mut Flown,
    (what, inputs, applied, ages): &Row,
) -> Result<(), TickError> {
    let given = |(actuator, taken): (&squid_scheduled::Actuator, &f64)| actuator.given(*taken);
    let applied: Vec<f64> = design.actuators.iter().zip(applied).map(given).collect();
    if *what == What::Reset {
        autopilot.initialise(0.0, inputs)?;
        supervisor.initialise(autopilot, inputs);
        return Ok(());
    }
    if *what == What::FeedBack
        && (!supervisor.has_failed()
            || design
                .actuators
                .iter()
                .zip(&applied)
                .any(|(actuator, one)| !(0.0..=actuator.largest_applied()).contains(&one.abs())))
    {
        autopilot.feed_back(&applied)?;
    }
    let stale_after = design.failsafe.as_ref().map_or(0.0, |failsafe| failsafe.stale_after);
    let period = |port: &squid_scheduled::Port| {
        let sensor = design.failsafe.as_ref().and_then(|failsafe| failsafe.sensors.get(&port.name));
        sensor.map_or(0.0, |sensor| sensor.period)
    };
    let is_fresh = |(age, port): (&f64, &squid_scheduled::Port)| {
        stale_after == 0.0 || (0.0..=stale_after + period(port)).contains(age)
    };
    let valid: Vec<bool> = ages.iter().zip(&design.signals).map(is_fresh).collect();
    supervisor.judge(autopilot, inputs, &valid, stale_after);
    if *what == What::Follow {
        supervisor.follow(autopilot, &applied)?;
    }
    supervisor.tick(autopilot).map(|_| ())
}

/// Runs the autopilot on the same rows and compares. Returns the counts of each code, of each health, and of ticks with
/// an actuator at its limit for long enough that references yield.
fn compare(design: &ControllerDesign, rows: &[Row], found: &[Vec<f64>]) -> ([usize; 4], [usize; 5], usize) {
    let mut autopilot = Autopilot::new(design).unwrap();
    let rest = at_rest(design);
    autopilot.initialise(0.0, &rest).unwrap();
    let supervisor = Supervisor::new(design, &autopilot, &rest);
    let mut flown = Flown { autopilot, supervisor };
    let (mut codes, mut healths, mut yielded) = ([0; 4], [0; 5], 0);
    assert_eq!(found.len(), rows.len() + 1);
    let mut last = None;
    for (index, found) in found.iter().enumerate() {
        let before = flown.clone();
        let done = match index.checked_sub(1).map(|index| &rows[index]) {
            None => Ok(()),
            Some(row) => run(design, &mut flown, row),
        };
        let (code, rest) = (found[0] as usize, &found[1..]);
        codes[code] += 1;
        let m = design.actuators.len();
        if let Err(reason) = done {
            use TickError::{AppliedTooLarge, Diverged, InputNotFinite, OtherUnit, SingularLoop};
            let expected = match reason {
                InputNotFinite { .. } | AppliedTooLarge { .. } | OtherUnit { .. } => 1,
                SingularLoop { .. } => 2,
                Diverged { .. } => 3,
            };
            assert_eq!(code, expected, "tick {index}: {reason}");
            // C leaves the state unchanged.
            flown = before;
        } else {
            assert_eq!(code, 0, "tick {index}");
            let Flown { autopilot, supervisor } = &flown;
            let outputs = autopilot.outputs();
            let taken =
                |(actuator, command): (&squid_scheduled::Actuator, &f64)| actuator.input_for(*command).0;
            let commands = design.actuators.iter().zip(supervisor.commands()).map(taken);
            let used = followed(design).map(|index| autopilot.references()[index]);
            let monitors = [outputs.scheduling_parameter, outputs.trim[0]];
            let expected: Vec<u64> = commands.chain(monitors).chain(used).map(f64::to_bits).collect();
            let (status, numbers) = rest.split_last().unwrap();
            assert_eq!(numbers.len(), m + 2 + followed(design).count());
            let numbers: Vec<u64> = numbers.iter().copied().map(f64::to_bits).collect();
            assert_eq!(numbers, expected, "tick {index}: {rest:?} is not {outputs:?}");
            let has = |bit: u64| *status as u64 & bit != 0;
            let health = supervisor.health(autopilot);
            let failed = health == Health::Failed;
            healths[health as usize] += 1;
            assert_eq!(has(STATUS_FAILED), failed, "tick {index}");
            assert_eq!(has(STATUS_OUT_OF_RANGE), outputs.out_of_range && !failed, "tick {index}");
            assert_eq!(has(STATUS_REFERENCE_LIMITED), outputs.reference_limited && !failed, "tick {index}");
            let saturation = autopilot.saturation();
            assert_eq!(
                has(STATUS_SATURATED),
                saturation.iter().any(|one| one.now) && !failed,
                "tick {index}"
            );
            for (actuator, one) in saturation.iter().enumerate() {
                assert_eq!(has(STATUS_SATURATED_FIRST << actuator), one.now && !failed, "tick {index}");
            }
            yielded +=
                usize::from(saturation.iter().any(|one| one.ticks == autopilot.yielding().1) && !failed);
            assert_eq!(has(STATUS_LOST), !supervisor.is_complete(), "tick {index}");
            last = Some(rest.to_vec());
        }
        assert_eq!(last.as_deref(), Some(rest), "tick {index}: an error changes no output");
    }
    (codes, healths, yielded)
}

#[test]
fn c_source_matches_the_autopilot_to_the_bit() {
    let (mut codes, mut healths, mut yielded) = ([0; 4], [0; 5], 0);
    for seed in 0..20 {
        let mut numbers = Random::new(seed);
        let design = random(&mut numbers, seed);
        design.validate().unwrap();
        let rows = rows(&mut numbers, &design);
        let found = replayed(&design, Real::Double, &rows);
        let each = compare(&design, &rows, &found);
        codes.iter_mut().zip(each.0).for_each(|(sum, count)| *sum += count);
        healths.iter_mut().zip(each.1).for_each(|(sum, count)| *sum += count);
        yielded += each.2;
    }
    println!("{codes:?} {healths:?} {yielded}");
    assert!(yielded > 1000, "{yielded}");
    assert!(healths.iter().all(|count| *count > 200), "{healths:?}");
    assert!(codes[0] > 10_000 && codes[1] > 100 && codes[3] > 10, "{codes:?}");
}

/// The loop `1 - theta` has no solution at rho = 1; the state remains unchanged.
#[test]
fn reports_a_loop_without_solution() {
    let mut design = random(&mut Random::new(3), 3);
    let (n, p, m) = (design.lft.a.len(), design.controller_inputs.len(), design.actuators.len());
    let zeros = |rows: usize, columns: usize| vec![vec![0.0; columns]; rows];
    design.failsafe = None;
    design.lft.blocks = vec![1];
    (design.lft.bt, design.lft.dut) = (zeros(n, 1), zeros(m, 1));
    (design.lft.ct, design.lft.dty, design.lft.dtt) = (zeros(1, n), zeros(1, p), vec![vec![1.0]]);
    let rest = at_rest(&design);
    let mut fast = rest.clone();
    fast.measured[SPEED] = 9.0;
    let idle = vec![0.0; m];
    let row = |what: What, inputs: &Inputs| (what, inputs.clone(), idle.clone(), vec![0.0; SIGNALS]);
    let rows = [
        row(What::Step, &rest),
        row(What::Step, &fast),
        row(What::Reset, &fast),
        row(What::Follow, &fast),
        row(What::Step, &rest),
    ];
    let found = replayed(&design, Real::Double, &rows);
    assert_eq!(compare(&design, &rows, &found).0, [3, 0, 3, 0]);
}

/// Single precision rounds by 6e-8, double precision by 1e-16; the commands differ by little more.
#[test]
fn single_precision_agrees_with_double_precision() {
    for seed in 0..4 {
        let mut numbers = Random::new(seed);
        let design = random(&mut numbers, seed);
        let mut inputs = at_rest(&design);
        let row = |index: usize| {
            inputs.measured[SPEED] += numbers.between(-0.02, 0.02);
            inputs.measured[0] += numbers.between(-0.01, 0.01);
            let what = match index {
                0 => What::Reset,
                100..120 => What::Follow,
                _ => What::Step,
            };
            let middle = |one: &squid_scheduled::Actuator| one.input_for(0.5 * (one.minimum + one.maximum)).0;
            let applied = design.actuators.iter().map(middle).collect();
            (what, inputs.clone(), applied, vec![0.0; SIGNALS])
        };
        let rows: Vec<Row> = (0..500).map(row).collect();
        let [double, float] = Real::ALL.map(|real| replayed(&design, real, &rows));
        let m = design.actuators.len();
        let mut largest = 0.0f64;
        for (double, float) in double.iter().zip(&float) {
            assert_eq!(double[0], float[0]);
            for index in 0..m {
                let span = design.actuators[index].input_for(design.actuators[index].maximum).0
                    - design.actuators[index].input_for(design.actuators[index].minimum).0;
                largest = largest.max((double[1 + index] - float[1 + index]).abs() / span);
            }
        }
        assert!(largest > 0.0 && largest < 1e-4, "design {seed}: {largest:e} of the range");
    }
}

#[test]
fn refuses_designs_that_c_cannot_represent() {
    let refused = |change: fn(&mut ControllerDesign), real: Real| {
        let mut design = random(&mut Random::new(3), 3);
        change(&mut design);
        export(&design, &standing(), real).unwrap_err()
    };
    let keyword = refused(|design| design.actuators[0].name = "register".into(), Real::Double);
    assert!(matches!(&keyword, ExportError::Keyword { name } if name == "register"), "{keyword}");
    let float =
        refused(|design| design.trim.forward_speed[1] = design.trim.forward_speed[0] + 1e-9, Real::Float);
    assert!(matches!(float, ExportError::Float { .. }), "{float}");
    let design = refused(|design| design.sample_time = -1.0, Real::Double);
    assert!(matches!(design, ExportError::Design(_)), "{design}");
    insta::assert_snapshot!([keyword, float, design].map(|error| error.to_string()).join("\n"));
}

#[test]
fn compares_every_number_and_token_of_a_source() {
    let design = random(&mut Random::new(3), 3);
    let text = export(&design, &standing(), Real::Double).unwrap().source;
    let error = |other: &str| compare_sources(other, &text).unwrap_err();
    compare_sources(&text.replace(",\n    ", ", "), &text).unwrap();
    let first =
        text.split("UPDATE[").nth(1).unwrap().split_once("{\n    {").unwrap().1.split(',').next().unwrap();
    let (head, tail) = text.split_once("UPDATE[").unwrap();
    let number = error(&format!("{head}UPDATE[{}", tail.replacen(first, "0x1.5p+3", 1)));
    let SourceError::Number { table, found, expected, .. } = &number else { panic!("{number}") };
    assert_eq!((table.as_str(), found.as_str(), expected.as_str()), ("UPDATE", "0x1.5p+3", first.trim()));
    let sign = error(&text.replace("rho - t->rho", "rho + t->rho"));
    let SourceError::Other { found, expected, .. } = &sign else { panic!("{sign}") };
    assert_eq!((found.as_str(), expected.as_str()), ("+", "-"));
    for other in [&text.replace("return code;", ""), &text[..text.len() - 2]] {
        assert!(matches!(error(other), SourceError::Other { .. }), "{}", error(other));
    }
    let hidden = error(&text.replace("    put_out", "    // \\\n    put_out"));
    assert!(matches!(hidden, SourceError::Hides { .. }), "{hidden}");
    let made_up = [
        SourceError::Number { line: 1, table: "UPDATE".into(), found: "1".into(), expected: "2".into() },
        SourceError::Other { line: 1, found: "+".into(), expected: "-".into() },
        SourceError::Hides { line: 1, found: "\\" },
    ];
    insta::assert_snapshot!(made_up.map(|error| error.to_string()).join("\n"));
}
