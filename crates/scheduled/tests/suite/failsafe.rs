//! Loss and recovery of sensors, and rejection of invalid failsafe data in the frozen design.

use crate::design::Rejected;
use crate::example::{self, DEPTH, PITCH, SPEED};
use squid_scheduled::*;

/// Returns a design with monitored sensors of pitch and speed; the inputs of the tests are constant.
fn design() -> ControllerDesign {
    let sensor = Sensor { error: 0.1, rate: 1.0, ..Sensor::default() };
    let sensors = ["pitch", "speed"].map(|name| (name.to_owned(), sensor.clone()));
    let mut design = example::design();
    let safe = vec![5.0; design.actuators.len()];
    design.failsafe = Some(Failsafe { stale_after: 0.5, safe, sensors: sensors.into() });
    design
}

struct Flight {
    autopilot: Autopilot,
    supervisor: Supervisor,
    inputs: Inputs,
    stale_after: f64,
}

impl Flight {
    fn new() -> Self {
        Self::drifting(0.0)
    }

    fn drifting(drift: f64) -> Self {
        let mut design = design();
        let sensors = design.failsafe.as_mut().unwrap().sensors.values_mut();
        sensors.for_each(|sensor| sensor.drift = drift);
        let mut autopilot = Autopilot::new(&design).unwrap();
        let inputs = autopilot.level(1.5);
        autopilot.initialise(0.0, &inputs).unwrap();
        let supervisor = Supervisor::new(&design, &autopilot, &inputs);
        Self { autopilot, supervisor, inputs, stale_after: 0.0 }
    }

    fn tick(&mut self, valid: bool) -> Health {
        let mut all = vec![true; self.inputs.measured.len()];
        all[PITCH] = valid;
        self.supervisor.judge(&self.autopilot, &self.inputs, &all, self.stale_after);
        self.supervisor.tick(&mut self.autopilot).unwrap();
        self.supervisor.health(&self.autopilot)
    }

    fn measure(&mut self, signal: usize, value: f64) -> Health {
        self.inputs.measured[signal] = value;
        self.tick(true)
    }
}

#[test]
fn rejects_changes_faster_than_the_vehicle() {
    // The first value is not checked; the largest change is 0.1 + 0.02 a tick later, 0.1 + 0.2 after ten ticks and
    // more.
    for (change, same, lost) in
        [(0.119, 0, false), (0.121, 0, true), (0.299, 9, false), (0.301, 9, true), (0.301, 200, true)]
    {
        let mut flight = Flight::new();
        let first = flight.measure(PITCH, 0.9);
        assert_ne!(first, Health::Failed);
        (0..same).for_each(|_| assert_ne!(flight.tick(true), Health::Failed));
        assert_eq!(flight.measure(PITCH, 0.9 - change) == Health::Failed, lost, "{change} after {same}");
    }
}

#[test]
fn loses_nan_invalid_and_out_of_range_values_at_once() {
    for value in [f64::NAN, f64::INFINITY, 1.6] {
        assert_eq!(Flight::new().measure(PITCH, value), Health::Failed);
    }
    assert_eq!(Flight::new().tick(false), Health::Failed);
    let mut flight = Flight::new();
    flight.tick(true);
    assert_eq!(flight.measure(SPEED, 0.0), Health::SpeedLost);
}

#[test]
fn loses_value_unchanged_for_stale_after() {
    let lost_at = |stale_after: f64| {
        let mut flight = Flight { stale_after, ..Flight::new() };
        (0..100).find(|_| flight.tick(true) == Health::Failed)
    };
    // The value counts as new at the first tick.
    assert_eq!((lost_at(0.5), lost_at(0.1), lost_at(0.0)), (Some(25), Some(5), None));
}

#[test]
fn regains_sensor_near_its_estimate() {
    let regained = u64::from(ticks(REGAINED_AFTER, 0.02));
    for (value, is_regained) in [(0.05, true), (0.5, false)] {
        let mut flight = Flight::new();
        flight.tick(true);
        assert_eq!(flight.tick(false), Health::Failed);
        (0..50).for_each(|_| assert_eq!(flight.tick(false), Health::Failed));
        assert!(flight.supervisor.commands().iter().all(|one| (one - 5.0).abs() < 1e-12), "the safe ones");
        let ticks = flight.autopilot.ticks();
        flight.measure(PITCH, value);
        let back =
            (0..200).find(|_| flight.tick(true) != Health::Failed).map(|_| flight.autopilot.ticks() - ticks);
        // The jump to the value is implausible; from the next tick on it has to stay plausible.
        assert_eq!(back.is_some(), is_regained, "{value}");
        assert!(back.is_none_or(|after| after >= regained && after <= regained + 1), "{back:?}");
    }
}

/// Checks that a sensor lost for long may deviate by 0.1 and the drift of ten seconds, and no more.
#[test]
fn keeps_deviating_sensor_lost() {
    for (value, is_regained) in [(1.05, true), (1.15, false)] {
        let mut flight = Flight::drifting(0.1);
        flight.tick(true);
        flight.measure(SPEED, flight.inputs.measured[SPEED] - value);
        let lost = (0..5000).filter(|_| flight.tick(true) == Health::SpeedLost).count();
        assert_eq!(lost < 5000, is_regained, "{value}: {lost} ticks");
    }
}

#[test]
fn rejects_invalid_failsafe_with_its_key() {
    let mut rejected = Rejected::new(design());
    let mut at = |key: &str, change: fn(&mut Failsafe)| {
        rejected.at(key, |design| change(design.failsafe.as_mut().unwrap()));
    };
    at("failsafe.stale_after", |f| f.stale_after = -1.0);
    at("failsafe.safe[0]", |f| f.safe[0] = 101.0);
    at("failsafe.safe", |f| f.safe.truncate(1));
    at("failsafe.sensors", |f| f.sensors.clear());
    at("failsafe.sensors.speed.error", |f| f.sensors.get_mut("speed").unwrap().error = f64::NAN);
    at("failsafe.sensors.speed.from", |f| {
        f.sensors.get_mut("speed").unwrap().from = Some(Source::Path("depth".into()));
    });
    at("failsafe.sensors", |f| {
        let sensor = Sensor { error: 0.1, rate: 1.0, ..Sensor::default() };
        f.sensors.insert("heave".into(), sensor);
    });
    insta::assert_snapshot!(rejected.messages);
}

/// Loses the depth sensor while its reference is still in the transition that began at the engagement.
#[test]
fn lost_depth_holds_reference_during_transition() {
    let mut design = example::two_degrees();
    design.controller_inputs[3] = example::input("depth", Kind::Measurement, 2.0);
    design.controller_inputs[1] = example::input("depth", Kind::Reference, 2.0);
    design.controller_inputs[2] = example::input("pitch", Kind::Measurement, 0.2);
    let rate = ReferenceLimits { range: None, rate: Some([-0.3, 0.3].map(OverSpeed::Constant)) };
    design.envelope.insert("depth".to_owned(), rate);
    let sensor = Sensor {
        error: 0.5,
        rate: 1.0,
        drift: 0.1,
        from: Some(Source::Path("pitch".to_owned())),
        ..Sensor::default()
    };
    let safe = vec![0.0; design.actuators.len()];
    let plain = Sensor { from: None, ..sensor.clone() };
    let sensors = [("pitch", plain.clone()), ("speed", plain), ("depth", sensor)];
    let sensors = sensors.map(|(name, one)| (name.to_owned(), one));
    design.failsafe = Some(Failsafe { stale_after: 0.5, safe, sensors: sensors.into() });
    let mut autopilot = Autopilot::new(&design).unwrap();
    let mut inputs = autopilot.level(1.5);
    inputs.measured[DEPTH] = 20.0;
    inputs.references[DEPTH] = 20.0;
    autopilot.initialise(0.0, &inputs).unwrap();
    let mut supervisor = Supervisor::new(&design, &autopilot, &inputs);
    let applied = autopilot.outputs().commands.clone();
    inputs.references[DEPTH] = 25.0;
    let mut all = vec![true; inputs.measured.len()];
    supervisor.judge(&autopilot, &inputs, &all, 0.0);
    supervisor.follow(&mut autopilot, &applied).unwrap();
    let mut tick = |valid: bool| {
        all[DEPTH] = valid;
        supervisor.judge(&autopilot, &inputs, &all, 0.0);
        supervisor.tick(&mut autopilot).unwrap();
        (supervisor.health(&autopilot), autopilot.references()[DEPTH])
    };
    let before = (0..50).map(|_| tick(true)).last().unwrap().1;
    assert!(20.1 < before && before < 20.4, "{before}");
    for _ in 0..500 {
        let (health, reference) = tick(false);
        assert_eq!(health, Health::Reckoned);
        assert!((reference - before).abs() < 1e-9, "{reference}");
    }
}
