//! Inputs on ramps: one long step with rates is the limit of many short ones with held inputs.

use crate::example::resources;
use fmi2::{Experiment, Instance, Model, Silent, describe};
use fmu_controller::Controller;
use fmu_plant::PlantModel;
use fmu_squid::ClosedLoop;

fn started<M: Model>() -> Instance<M> {
    let mut instance = Instance::new(describe::<M>(&resources()).unwrap());
    instance.set_up(Experiment::default()).unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization(&mut Silent).unwrap();
    instance
}

fn reference<M: Model>(instance: &Instance<M>, name: &str) -> u32 {
    instance.table().reference(name).unwrap()
}

fn get<M: Model>(instance: &mut Instance<M>, name: &str) -> f64 {
    let (reference, mut found) = (reference(instance, name), f64::NAN);
    instance.get(&[reference], &mut Silent, |_, value| found = value).unwrap();
    found
}

fn set<M: Model>(instance: &mut Instance<M>, name: &str, value: f64) {
    let reference = reference(instance, name);
    instance.set(&[reference], |_| value).unwrap();
}

/// Flies a second with an input on a ramp, in one step with a rate and in many with held values.
fn ramp_and_stairs<M: Model>(input: &str, rate: f64, prepare: fn(&mut Instance<M>)) -> [Instance<M>; 2] {
    let [mut ramp, mut stairs] = [started::<M>(), started::<M>()];
    [&mut ramp, &mut stairs].into_iter().for_each(prepare);
    let start = get(&mut ramp, input);
    let references = [reference(&ramp, input)];
    ramp.set_input_derivatives(&references, &[1], &[rate]).unwrap();
    ramp.step(0.0, 1.0, &mut Silent).unwrap();
    let pieces = 5000;
    for piece in 0..pieces {
        let middle = (f64::from(piece) + 0.5) / f64::from(pieces);
        set(&mut stairs, input, start + rate * middle);
        stairs.step(f64::from(piece) / f64::from(pieces), 1.0 / f64::from(pieces), &mut Silent).unwrap();
    }
    set(&mut stairs, input, start + rate);
    assert!((get(&mut ramp, input) - start - rate).abs() < 1e-12, "the input has moved along");
    [ramp, stairs]
}

fn assert_alike<M: Model>(flights: &mut [Instance<M>; 2], outputs: &[&str], tolerance: f64) {
    let [one, other] = flights;
    for name in outputs {
        let (one, other) = (get(one, name), get(other, name));
        assert!((one - other).abs() < tolerance * (1.0 + other.abs()), "{name}: {one} and {other}");
    }
}

#[test]
fn the_plant_follows_ramps_of_commands_and_currents() {
    for (input, rate) in [("lower", 40.0), ("upper_port", -300.0), ("current_horizontal", 0.5)] {
        let mut flights = ramp_and_stairs::<PlantModel>(input, rate, |_| {});
        assert_alike(&mut flights, &["pitch", "pitch_rate", "depth", "distance", "lower_output"], 1e-5);
        let [ramp, _] = &mut flights;
        let (before, input) = (get(ramp, input), input);
        ramp.step(1.0, 0.5, &mut Silent).unwrap();
        assert_eq!(get(ramp, input), before, "the rate was for one step");
    }
}

#[test]
fn the_loop_follows_ramps_of_references_from_tick_to_tick() {
    let manual = |instance: &mut Instance<ClosedLoop>| {
        let reference = reference(instance, "manual");
        instance.set(&[reference], |_| true).unwrap();
    };
    let mut flights = ramp_and_stairs::<ClosedLoop>("pitch_reference", 0.1, manual);
    assert_alike(&mut flights, &["pitch", "speed", "depth", "pitch_reference_used", "lower"], 1e-3);
    let mut flights = ramp_and_stairs::<ClosedLoop>("current_vertical", 0.2, |_| {});
    assert_alike(&mut flights, &["pitch", "depth"], 1e-5);
}

#[test]
fn what_cannot_be_interpolated_is_refused() {
    let mut controller = started::<Controller>();
    let pitch = reference(&controller, "pitch");
    let refused = controller.set_input_derivatives(&[pitch], &[1], &[0.1]).unwrap_err().to_string();
    assert_eq!(refused, "is not supported: the model description says canInterpolateInputs = false");
    let mut plant = started::<PlantModel>();
    let [lower, depth] = ["lower", "depth"].map(|name| reference(&plant, name));
    for (reference, order, rate, expected) in [
        (lower, 2, 1.0, "the derivative of order 2"),
        (lower, 0, 1.0, "the derivative of order 0"),
        (lower, 1, f64::NAN, "cannot be set to NaN"),
        (depth, 1, 1.0, "'depth' cannot be interpolated"),
        (999, 1, 1.0, "value reference 999"),
    ] {
        let refused = plant.set_input_derivatives(&[lower, reference], &[1, order], &[1.0, rate]);
        let message = refused.unwrap_err().to_string();
        assert!(message.contains(expected), "{message}");
    }
    let before = get(&mut plant, "lower");
    plant.step(0.0, 1.0, &mut Silent).unwrap();
    assert_eq!(get(&mut plant, "lower"), before, "none of the refused rates was set");
}

/// A state taken between the rate and the step remembers the rate.
#[test]
fn a_state_remembers_the_rates() {
    let mut plant = started::<PlantModel>();
    let lower = reference(&plant, "lower");
    plant.set_input_derivatives(&[lower], &[1], &[30.0]).unwrap();
    let bytes = plant.serialise(&plant.snapshot().unwrap()).unwrap();
    let mut other = started::<PlantModel>();
    other.restore(&other.deserialise(&bytes).unwrap()).unwrap();
    for one in [&mut plant, &mut other] {
        one.step(0.0, 1.0, &mut Silent).unwrap();
    }
    assert_eq!(get(&mut plant, "pitch").to_bits(), get(&mut other, "pitch").to_bits());
    assert_eq!(get(&mut other, "lower"), get(&mut plant, "lower"));
}
