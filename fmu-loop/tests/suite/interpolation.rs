//! Ramped inputs: one long step with rates is the limit of many short steps with constant inputs.

use crate::example::{Flight, resources};
use squid_fmi2::{Model, Refusal, Silent, describe};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

fn started<M: Model>() -> Flight<M> {
    Flight::started(describe(&resources()).unwrap())
}

/// Simulates a second with a ramped input, in one step with a rate and in many with held values.
fn ramp_and_stairs<M: Model>(input: &str, rate: f64, prepare: fn(&mut Flight<M>)) -> [Flight<M>; 2] {
    let [mut ramp, mut stairs] = [started::<M>(), started::<M>()];
    [&mut ramp, &mut stairs].into_iter().for_each(prepare);
    let start = ramp.get(input);
    let references = [ramp.reference(input)];
    ramp.instance.set_input_derivatives(&references, &[1], &[rate]).unwrap();
    ramp.instance.step(0.0, 1.0, &mut Silent).unwrap();
    let pieces = 5000;
    for piece in 0..pieces {
        let middle = (f64::from(piece) + 0.5) / f64::from(pieces);
        stairs.set(input, start + rate * middle);
        let (at, size) = (f64::from(piece) / f64::from(pieces), 1.0 / f64::from(pieces));
        stairs.instance.step(at, size, &mut Silent).unwrap();
    }
    stairs.set(input, start + rate);
    assert!((ramp.get(input) - start - rate).abs() < 1e-12, "the input has moved along");
    [ramp, stairs]
}

fn assert_alike<M: Model>(flights: &mut [Flight<M>; 2], outputs: &[&str], tolerance: f64) {
    let [one, other] = flights;
    for name in outputs {
        let (one, other) = (one.get(name), other.get(name));
        assert!((one - other).abs() < tolerance * (1.0 + other.abs()), "{name}: {one} and {other}");
    }
}

#[test]
fn plant_follows_ramps_of_commands_and_currents() {
    for (input, rate) in [("lower", 40.0), ("upper_port", -300.0), ("current_horizontal", 0.5)] {
        let mut flights = ramp_and_stairs::<PlantModel>(input, rate, |_| {});
        assert_alike(&mut flights, &["pitch", "pitch_rate", "depth", "distance", "lower_output"], 1e-5);
        let [ramp, _] = &mut flights;
        let before = ramp.get(input);
        ramp.instance.step(1.0, 0.5, &mut Silent).unwrap();
        assert_eq!(ramp.get(input), before, "the rate was for one step");
    }
}

#[test]
fn loop_follows_ramps_of_references_between_ticks() {
    let mut flights =
        ramp_and_stairs::<ClosedLoop>("pitch_reference", 0.1, |flight| flight.set("manual", true));
    assert_alike(&mut flights, &["pitch", "speed", "depth", "pitch_reference_used", "lower"], 1e-3);
    let mut flights = ramp_and_stairs::<ClosedLoop>("current_vertical", 0.2, |_| {});
    assert_alike(&mut flights, &["pitch", "depth"], 1e-5);
}

#[test]
fn rejects_rates_of_other_variables() {
    let mut controller = started::<Controller>();
    let pitch = controller.reference("pitch");
    let refused = controller.instance.set_input_derivatives(&[pitch], &[1], &[0.1]).unwrap_err();
    assert!(matches!(refused, Refusal::Unsupported { .. }), "{refused}");
    let mut plant = started::<PlantModel>();
    let [lower, depth] = ["lower", "depth"].map(|name| plant.reference(name));
    let mut refused = |reference, order, rate| {
        plant.instance.set_input_derivatives(&[lower, reference], &[1, order], &[1.0, rate]).unwrap_err()
    };
    for order in [0, 2] {
        assert!(
            matches!(refused(lower, order, 1.0), Refusal::BadOrder { order: found, .. } if found == order)
        );
    }
    assert!(matches!(refused(lower, 1, f64::NAN), Refusal::NotFinite { .. }));
    assert!(matches!(refused(depth, 1, 1.0), Refusal::NotInterpolated { name } if name == "depth"));
    assert!(matches!(refused(999, 1, 1.0), Refusal::UnknownReference { reference: 999, .. }));
    let before = plant.get("lower");
    plant.instance.step(0.0, 1.0, &mut Silent).unwrap();
    assert_eq!(plant.get("lower"), before, "none of the refused rates was set");
}

/// A state saved between setting the rate and the step contains the rate.
#[test]
fn saved_state_contains_the_rates() {
    let mut plant = started::<PlantModel>();
    let lower = plant.reference("lower");
    plant.instance.set_input_derivatives(&[lower], &[1], &[30.0]).unwrap();
    let bytes = plant.instance.serialise(&plant.instance.snapshot().unwrap()).unwrap();
    let mut other = started::<PlantModel>();
    other.instance.restore(&other.instance.deserialise(&bytes).unwrap()).unwrap();
    for one in [&mut plant, &mut other] {
        one.instance.step(0.0, 1.0, &mut Silent).unwrap();
    }
    assert_eq!(plant.get("pitch").to_bits(), other.get("pitch").to_bits());
    assert_eq!(other.get("lower"), plant.get("lower"));
}
