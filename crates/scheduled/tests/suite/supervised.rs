//! Supervised autopilot with limits of all references under arbitrary inputs: commands stay within their limits,
//! references within the envelope, and the state recovers completely afterwards.

use crate::example::{self, DEPTH, PITCH, RATE, SPEED};
use proptest::prelude::*;
use squid_scheduled::*;

/// Limits of the references: range of pitch and of speed, rate of speed and of depth.
const PITCHES: [f64; 2] = [-0.5, 0.5];
const SPEEDS: [f64; 2] = [0.6, 2.9];
const SPEED_RATES: [f64; 2] = [-0.5, 0.4];
const DEPTH_RATES: [f64; 2] = [-0.3, 0.3];
const TICK: f64 = 0.02;

/// Returns a design that tracks and measures pitch, speed and depth, and measures the rate of pitch.
pub fn design() -> ControllerDesign {
    let mut design = example::two_degrees();
    let more = [
        ("depth", Kind::Reference, 9.0),
        ("depth", Kind::Measurement, 9.0),
        ("pitch_rate", Kind::Measurement, 0.3),
    ];
    design.controller_inputs.extend(more.map(|(name, kind, scale)| example::input(name, kind, scale)));
    for rows in [&mut design.lft.by, &mut design.lft.duy, &mut design.lft.dty] {
        rows.iter_mut().for_each(|row| row.extend([0.02, -0.02, -0.01]));
    }
    design.actuators[0].steers = vec!["pitch".into(), "depth".into()];
    let ends = |ends: [f64; 2]| Some(ends.map(OverSpeed::Constant));
    design.envelope = [
        ("pitch", ReferenceLimits { range: ends(PITCHES), rate: None }),
        ("speed", ReferenceLimits { range: ends(SPEEDS), rate: ends(SPEED_RATES) }),
        ("depth", ReferenceLimits { range: None, rate: ends(DEPTH_RATES) }),
    ]
    .map(|(name, limits)| (name.to_owned(), limits))
    .into();
    let identity = |i: usize| (0..3).map(|j| if i == j { 0.05 } else { 0.0 }).collect();
    design.follow = vec![(0..2).map(identity).collect()];
    design.anti_windup = Some((0..2).map(identity).collect());
    let sensor =
        |error, rate, drift, resolution, from| Sensor { error, rate, drift, resolution, period: 0.0, from };
    let thrust = Source::Commands { gains: vec![0.01; 3], time: 10.0 };
    design.failsafe = Some(Failsafe {
        stale_after: 0.5,
        safe: vec![5.0; 3],
        sensors: [
            ("pitch", sensor(0.09, 1.0, 0.01, 0.01, Some(Source::Rate("pitch_rate".into())))),
            ("speed", sensor(0.3, 1.0, 0.01, 0.03, Some(thrust))),
            ("depth", sensor(1.0, 3.0, 0.2, 0.1, Some(Source::Path("pitch".into())))),
            ("pitch_rate", sensor(2.0, 1.0, 1.0, 1.0, None)),
        ]
        .map(|(name, sensor)| (name.to_owned(), sensor))
        .into(),
    });
    design
}

/// Returns the inputs of level flight at 1.9 m/s in 20 m.
pub fn level() -> Inputs {
    Inputs { measured: vec![-0.009, 1.9, 20.0, 0.0, 0.0], references: vec![-0.009, 1.9, 20.0] }
}

/// Autopilot with its supervisor, as in the FMU.
#[derive(Clone)]
pub struct Flight {
    pub autopilot: Autopilot,
    pub supervisor: Supervisor,
}

impl Flight {
    pub fn new(design: &ControllerDesign, at: &Inputs) -> Self {
        let mut autopilot = Autopilot::new(design).unwrap();
        autopilot.initialise(0.0, at).unwrap();
        let supervisor = Supervisor::new(design, &autopilot, at);
        Self { autopilot, supervisor }
    }

    /// Runs a tick, after following the applied commands if given.
    pub fn tick(
        &mut self,
        at: &Inputs,
        valid: &[bool],
        applied: Option<&[f64]>,
    ) -> Result<Health, TickError> {
        self.supervisor.judge(&self.autopilot, at, valid, 0.5);
        if let Some(applied) = applied {
            self.supervisor.follow(&mut self.autopilot, applied)?;
        }
        self.supervisor.tick(&mut self.autopilot)?;
        Ok(self.supervisor.health(&self.autopilot))
    }
}

/// Returns any number: of any bits, or of an ordinary size.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![any::<u64>().prop_map(f64::from_bits), -1e3..1e3f64, -1.0..1.0f64]
}

fn any_numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(any_number(), count)
}

/// Returns an impossible measurement or the level value: plausible wrong values are tested elsewhere.
fn impossible_or(level: f64) -> impl Strategy<Value = f64> {
    let number = any::<u64>().prop_map(f64::from_bits);
    number.prop_map(move |one| if one.abs() < 100.0 { level } else { one })
}

fn measured() -> impl Strategy<Value = Vec<f64>> {
    level().measured.into_iter().map(impossible_or).collect::<Vec<_>>()
}

proptest! {
    #[test]
    fn any_inputs_leave_commands_within_limits_and_no_trace(
        rows in prop::collection::vec(
            (measured(), any_numbers(3), any_numbers(3), prop::collection::vec(any::<bool>(), 5), 0..4),
            1..15,
        ),
    ) {
        let design = design();
        let mut flight = Flight::new(&design, &level());
        let all = [true; 5];
        for _ in 0..100 {
            flight.tick(&level(), &all, None).unwrap();
        }
        let mut undisturbed = flight.clone();
        for (measured, references, applied, valid, what) in rows {
            let at = Inputs { measured, references };
            if what == 0 {
                _ = flight.autopilot.feed_back(&applied);
            }
            _ = flight.tick(&at, &valid, (what == 1).then_some(&applied));
            for (command, actuator) in flight.supervisor.commands().iter().zip(&design.actuators) {
                prop_assert!((actuator.minimum..=actuator.maximum).contains(command), "{}", command);
            }
        }
        for tick in 0..1500 {
            let mut at = level();
            at.measured.iter_mut().for_each(|one| *one += 1e-6 * f64::from(tick % 2));
            flight.tick(&at, &all, None).unwrap();
            undisturbed.tick(&at, &all, None).unwrap();
        }
        prop_assert_eq!(flight.supervisor.health(&flight.autopilot), Health::Ok);
        for (one, other) in flight.supervisor.commands().iter().zip(undisturbed.supervisor.commands()) {
            prop_assert!((one - other).abs() < 1e-2, "{} {}", one, other);
        }
    }

    /// Checks any requests while engaged and while following, when a reference is at the measured value.
    #[test]
    fn references_stay_in_envelope(
        rows in prop::collection::vec(
            (any_numbers(3), -0.4..0.4f64, 0.7..2.8f64, -2.0..2.0f64, 0..6, 1..40),
            1..20,
        ),
    ) {
        let mut flight = Flight::new(&design(), &level());
        let mut at = level();
        let mut last = flight.autopilot.references().to_vec();
        let mut time = 0.0;
        for (request, pitch, speed, sinks, what, ticks) in rows {
            let request = request.into_iter().map(|one| if one.is_finite() { one } else { 0.0 });
            at.references = request.collect();
            for tick in 0..ticks {
                // The vehicle moves within the limits of its sensors, so that none is lost.
                let towards = |now: f64, goal: f64| now + (goal - now).clamp(-0.015, 0.015);
                at.measured[RATE] = (towards(at.measured[PITCH], pitch) - at.measured[PITCH]) / TICK;
                at.measured[PITCH] = towards(at.measured[PITCH], pitch);
                at.measured[SPEED] = towards(at.measured[SPEED], speed + 1e-9 * ((time / TICK).round() % 2.0));
                at.measured[DEPTH] += TICK * sinks;
                let follows = what == 0 || what == 1 && tick == 0;
                // The saturation before the tick counts: during the tick the actuator may leave its limit.
                let yields = flight.autopilot.saturation()[0].ticks >= flight.autopilot.yielding().1;
                let health = flight.tick(&at, &[true; 5], follows.then_some(&[1.0, 2.0, 3.0])).unwrap();
                time += TICK;
                let references = flight.autopilot.references();
                prop_assert!((PITCHES[0]..=PITCHES[1]).contains(&references[PITCH]));
                prop_assert!((SPEEDS[0]..=SPEEDS[1]).contains(&references[SPEED]));
                for (signal, rates) in [(SPEED, SPEED_RATES), (DEPTH, DEPTH_RATES)] {
                    let rate = (references[signal] - last[signal]) / TICK;
                    let is_free = follows || yields && signal == DEPTH || health == Health::Failed;
                    let within = rates[0] - 1e-9 <= rate && rate <= rates[1] + 1e-9;
                    prop_assert!(is_free || within, "{} at {} s: {}", signal, time, rate);
                }
                last.copy_from_slice(references);
            }
        }
    }
}

/// Requests 25 deg or more at the engagement and -5 deg 0.1 s later; the reference never falls below that.
#[test]
fn request_at_engagement_leaves_no_trace() {
    let [high, low] = [25f64, -5.0].map(f64::to_radians);
    for request in [high, 1e6, 1e300] {
        let mut flight = Flight::new(&design(), &level());
        let mut at = level();
        at.references[PITCH] = request;
        let applied = flight.supervisor.commands().to_vec();
        flight.tick(&at, &[true; 5], Some(&applied)).unwrap();
        (0..4).for_each(|_| _ = flight.tick(&at, &[true; 5], None).unwrap());
        at.references[PITCH] = low;
        let references = |flight: &mut Flight| {
            flight.tick(&at, &[true; 5], None).unwrap();
            flight.autopilot.references()[PITCH]
        };
        let all: Vec<f64> = (0..500).map(|_| references(&mut flight)).collect();
        assert!(all.iter().all(|one| *one >= low - 1e-12), "{request}: {all:?}");
        assert_eq!(all.last(), Some(&low));
    }
}

/// Engages while the vehicle pitches and sinks: the references continue with its rates and reach the request without a
/// jump in rate.
#[test]
fn references_start_with_rate_of_vehicle() {
    let (pitch_rate, pitch) = (0.08, -0.1);
    let mut at = level();
    (at.measured[RATE], at.measured[PITCH]) = (pitch_rate, pitch);
    let mut flight = Flight::new(&design(), &at);
    let applied = flight.supervisor.commands().to_vec();
    let mut references = vec![];
    for tick in 0..600 {
        flight.tick(&at, &[true; 5], (tick == 0).then_some(&applied)).unwrap();
        references.push(flight.autopilot.references().to_vec());
        at.measured[PITCH] = pitch + 1e-4 * f64::from(tick % 2);
        at.measured[RATE] = 1e-4 * f64::from(tick % 2);
        at.measured[DEPTH] = 20.0 + 1e-3 * f64::from(tick % 2);
    }
    let rate = |signal: usize, tick: usize| (references[tick + 1][signal] - references[tick][signal]) / TICK;
    assert!((rate(PITCH, 0) - pitch_rate).abs() < 0.01, "{}", rate(PITCH, 0));
    let trim = flight.autopilot.trim().signal(1.9, PITCH, 0.0);
    let sinks = -1.9 * (pitch - trim);
    assert!((rate(DEPTH, 0) - sinks).abs() < 0.02, "{} {sinks}", rate(DEPTH, 0));
    for signal in [PITCH, DEPTH] {
        let jump =
            (1..598).map(|tick| (rate(signal, tick) - rate(signal, tick - 1)).abs()).fold(0.0, f64::max);
        assert!(jump < 0.02, "{signal}: {jump}");
    }
    assert_eq!(references[599], level().references);
}

#[test]
fn rejects_inputs_in_wrong_units_at_start() {
    let mut messages = String::new();
    for (change, expected, value) in [
        ((|at: &mut Inputs| at.references[PITCH] = 60.0) as fn(&mut Inputs), "pitch_reference", "60 rad"),
        (|at| at.measured[PITCH] = 5.0, "pitch", "5 rad"),
        (|at| at.measured[RATE] = 20.0, "pitch_rate", "20 rad/s"),
        (|at| at.measured[DEPTH] = -10.0, "depth", "-10 m"),
    ] {
        let mut at = level();
        change(&mut at);
        let mut autopilot = Autopilot::new(&design()).unwrap();
        let error = autopilot.initialise(0.0, &at).unwrap_err();
        let TickError::OtherUnit { name, found, .. } = &error else { panic!("{error}") };
        assert_eq!((name.as_str(), found.as_str()), (expected, value));
        messages += &format!("{error}\n");
    }
    insta::assert_snapshot!(messages);
}
