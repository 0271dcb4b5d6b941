//! A supervised autopilot with limits of all references, flown with anything: commands stay within their limits,
//! references within the envelope, and after it all is as if nothing had happened.

use crate::example::{self, DEPTH, PITCH, RATE, SPEED};
use proptest::prelude::*;
use squid_scheduled::*;

/// The limits of the references: range of pitch and of speed, rate of speed and of depth.
const PITCHES: [f64; 2] = [-0.5, 0.5];
const SPEEDS: [f64; 2] = [0.6, 2.9];
const SPEED_RATES: [f64; 2] = [-0.5, 0.4];
const DEPTH_RATES: [f64; 2] = [-0.3, 0.3];
const TICK: f64 = 0.02;

/// Pitch, speed and depth are followed and measured, and the rate of pitch is measured.
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

/// Level flight at 1.9 m/s in 20 m.
pub fn level() -> Inputs {
    Inputs { measured: vec![-0.009, 1.9, 20.0, 0.0, 0.0], references: vec![-0.009, 1.9, 20.0] }
}

/// An autopilot with its supervisor, as the FMU has them.
#[derive(Clone)]
pub struct Flown {
    pub autopilot: Autopilot,
    pub supervisor: Supervisor,
}

impl Flown {
    pub fn new(design: &ControllerDesign, at: &Inputs) -> Self {
        let mut autopilot = Autopilot::new(design).unwrap();
        autopilot.initialise(0.0, at).unwrap();
        let supervisor = Supervisor::new(design, &autopilot, at);
        Self { autopilot, supervisor }
    }

    /// A tick, after following what is applied if that is given.
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

/// Any number: of any bits, or of an ordinary size.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![any::<u64>().prop_map(f64::from_bits), -1e3..1e3f64, -1.0..1.0f64]
}

fn any_numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec(any_number(), count)
}

/// A measurement that no vehicle makes, or none: what could be true is another matter.
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
        let mut flown = Flown::new(&design, &level());
        let all = [true; 5];
        for _ in 0..100 {
            flown.tick(&level(), &all, None).unwrap();
        }
        let mut undisturbed = flown.clone();
        for (measured, references, applied, valid, what) in rows {
            let at = Inputs { measured, references };
            if what == 0 {
                _ = flown.autopilot.feed_back(&applied);
            }
            _ = flown.tick(&at, &valid, (what == 1).then_some(&applied));
            for (command, actuator) in flown.supervisor.commands().iter().zip(&design.actuators) {
                prop_assert!((actuator.minimum..=actuator.maximum).contains(command), "{}", command);
            }
        }
        for tick in 0..1500 {
            let mut at = level();
            at.measured.iter_mut().for_each(|one| *one += 1e-6 * f64::from(tick % 2));
            flown.tick(&at, &all, None).unwrap();
            undisturbed.tick(&at, &all, None).unwrap();
        }
        prop_assert_eq!(flown.supervisor.health(&flown.autopilot), Health::Ok);
        for (one, other) in flown.supervisor.commands().iter().zip(undisturbed.supervisor.commands()) {
            prop_assert!((one - other).abs() < 1e-2, "{} {}", one, other);
        }
    }

    /// Also while it is engaged, and whatever is asked. While it follows, a reference is where the vehicle is.
    #[test]
    fn references_stay_in_the_envelope(
        rows in prop::collection::vec(
            (any_numbers(3), -0.4..0.4f64, 0.7..2.8f64, -2.0..2.0f64, 0..6, 1..40),
            1..20,
        ),
    ) {
        let mut flown = Flown::new(&design(), &level());
        let mut at = level();
        let mut last = flown.autopilot.references().to_vec();
        let mut time = 0.0;
        for (asked, pitch, speed, sinks, what, ticks) in rows {
            let asked = asked.into_iter().map(|one| if one.is_finite() { one } else { 0.0 });
            at.references = asked.collect();
            for tick in 0..ticks {
                // A vehicle that moves as one can, so that no sensor is lost.
                let towards = |now: f64, goal: f64| now + (goal - now).clamp(-0.015, 0.015);
                at.measured[RATE] = (towards(at.measured[PITCH], pitch) - at.measured[PITCH]) / TICK;
                at.measured[PITCH] = towards(at.measured[PITCH], pitch);
                at.measured[SPEED] = towards(at.measured[SPEED], speed + 1e-9 * ((time / TICK).round() % 2.0));
                at.measured[DEPTH] += TICK * sinks;
                let follows = what == 0 || what == 1 && tick == 0;
                // Before the tick: in its course the actuator may leave its limit.
                let yields = flown.autopilot.saturation()[0].ticks >= flown.autopilot.yielding().1;
                let health = flown.tick(&at, &[true; 5], follows.then_some(&[1.0, 2.0, 3.0])).unwrap();
                time += TICK;
                let used = flown.autopilot.references();
                prop_assert!((PITCHES[0]..=PITCHES[1]).contains(&used[PITCH]));
                prop_assert!((SPEEDS[0]..=SPEEDS[1]).contains(&used[SPEED]));
                for (signal, rates) in [(SPEED, SPEED_RATES), (DEPTH, DEPTH_RATES)] {
                    let rate = (used[signal] - last[signal]) / TICK;
                    let is_free = follows || yields && signal == DEPTH || health == Health::Failed;
                    let within = rates[0] - 1e-9 <= rate && rate <= rates[1] + 1e-9;
                    prop_assert!(is_free || within, "{} at {} s: {}", signal, time, rate);
                }
                last.copy_from_slice(used);
            }
        }
    }
}

/// Asked for 25 deg at the engagement and for -5 deg 0.1 s later, the reference is never below that.
#[test]
fn what_was_asked_at_the_engagement_leaves_no_trace() {
    let [high, low] = [25f64, -5.0].map(f64::to_radians);
    for asked in [high, 1e6, 1e300] {
        let mut flown = Flown::new(&design(), &level());
        let mut at = level();
        at.references[PITCH] = asked;
        let applied = flown.supervisor.commands().to_vec();
        flown.tick(&at, &[true; 5], Some(&applied)).unwrap();
        (0..4).for_each(|_| _ = flown.tick(&at, &[true; 5], None).unwrap());
        at.references[PITCH] = low;
        let used = |flown: &mut Flown| {
            flown.tick(&at, &[true; 5], None).unwrap();
            flown.autopilot.references()[PITCH]
        };
        let all: Vec<f64> = (0..500).map(|_| used(&mut flown)).collect();
        assert!(all.iter().all(|one| *one >= low - 1e-12), "{asked}: {all:?}");
        assert_eq!(all.last(), Some(&low));
    }
}

/// Engaged while the vehicle pitches and sinks: the references go on with its rates and arrive without a jump in rate.
#[test]
fn a_reference_begins_with_the_rate_of_the_vehicle() {
    let (pitch_rate, pitch) = (0.08, -0.1);
    let mut at = level();
    (at.measured[RATE], at.measured[PITCH]) = (pitch_rate, pitch);
    let mut flown = Flown::new(&design(), &at);
    let applied = flown.supervisor.commands().to_vec();
    let mut used = vec![];
    for tick in 0..600 {
        flown.tick(&at, &[true; 5], (tick == 0).then_some(&applied)).unwrap();
        used.push(flown.autopilot.references().to_vec());
        at.measured[PITCH] = pitch + 1e-4 * f64::from(tick % 2);
        at.measured[RATE] = 1e-4 * f64::from(tick % 2);
        at.measured[DEPTH] = 20.0 + 1e-3 * f64::from(tick % 2);
    }
    let rate = |signal: usize, tick: usize| (used[tick + 1][signal] - used[tick][signal]) / TICK;
    assert!((rate(PITCH, 0) - pitch_rate).abs() < 0.01, "{}", rate(PITCH, 0));
    let trim = flown.autopilot.trim().signal(1.9, PITCH, 0.0);
    let sinks = -1.9 * (pitch - trim);
    assert!((rate(DEPTH, 0) - sinks).abs() < 0.02, "{} {sinks}", rate(DEPTH, 0));
    for signal in [PITCH, DEPTH] {
        let jump =
            (1..598).map(|tick| (rate(signal, tick) - rate(signal, tick - 1)).abs()).fold(0.0, f64::max);
        assert!(jump < 0.02, "{signal}: {jump}");
    }
    assert_eq!(used[599], level().references);
}

#[test]
fn what_is_meant_in_another_unit_is_refused_at_the_start() {
    let refused = |change: fn(&mut Inputs)| {
        let mut at = level();
        change(&mut at);
        let mut autopilot = Autopilot::new(&design()).unwrap();
        autopilot.initialise(0.0, &at).unwrap_err().to_string()
    };
    for (words, expected) in [
        (
            refused(|at| at.references[PITCH] = 60.0),
            "pitch_reference is 60 rad at the first tick, but must be from -6.28",
        ),
        (refused(|at| at.measured[PITCH] = 5.0), "pitch is 5 rad at the first tick, but must be from -1.57"),
        (
            refused(|at| at.measured[RATE] = 20.0),
            "pitch_rate is 20 rad/s at the first tick, but must be from -6.28",
        ),
        (
            refused(|at| at.measured[DEPTH] = -10.0),
            "depth is -10 m at the first tick, but must be from -5 to 12000 m",
        ),
    ] {
        assert!(words.starts_with(expected), "{words}");
        assert_eq!(words.contains("deg"), words.contains("rad"), "{words}");
    }
}
