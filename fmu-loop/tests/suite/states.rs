//! Restored instances continue with identical bits, with the state in memory or serialised.

use crate::case::{read, real_of, references, set_waves};
use crate::example::{resources, turning, with_given_speed, with_two_degrees};
use proptest::prelude::*;
use squid_fmi2::model_description::{Causality, ModelDescription};
use squid_fmi2::{Experiment, Instance, Interface, Model, Refusal, Resources, Silent, StateError, describe};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

/// One step: its size \[s\], and the offsets of the inputs from their start values in units of their nominal values.
type Move = (f64, Vec<f64>);

fn moves(count: usize) -> impl Strategy<Value = Vec<Move>> {
    let size = prop_oneof![Just(0.01), Just(0.00999999999999934), 1e-6..0.05, Just(0.02)];
    prop::collection::vec((size, prop::collection::vec(-0.3..0.3, 10)), count)
}

fn instance<M: Model>(resources: &Resources) -> Instance<M> {
    Instance::made_for(Interface::CoSimulation, describe::<M>(resources).unwrap())
}

fn started<M: Model>(resources: &Resources) -> Instance<M> {
    started_with(resources, |_| {})
}

fn started_with<M: Model>(resources: &Resources, prepare: fn(&mut Instance<M>)) -> Instance<M> {
    let mut instance = instance::<M>(resources);
    instance.set_up(Experiment { start: 1.5, ..Experiment::default() }).unwrap();
    prepare(&mut instance);
    instance.enter_initialization().unwrap();
    instance.exit_initialization(&mut Silent).unwrap();
    instance
}

/// Sets weight, buoyancy and centre of gravity slightly off their start values.
fn tune<M: Model>(instance: &mut Instance<M>, description: &ModelDescription, offset: f64) {
    for (name, per_offset) in [("weight", 10.0), ("buoyancy", -20.0), ("x_G", 0.01), ("z_G", 0.02)] {
        let Some(reference) = instance.table().reference(name) else { return };
        let all = real_of(description, Causality::Parameter);
        let start = all.iter().find(|one| one.0 == reference).unwrap().1;
        instance.set(&[reference], |_| start + per_offset * offset).unwrap();
    }
}

/// Runs the steps, and returns the bits of the outputs after each.
fn run<M: Model>(instance: &mut Instance<M>, description: &ModelDescription, moves: &[Move]) -> Vec<u64> {
    let inputs = real_of(description, Causality::Input);
    let outputs = references(&real_of(description, Causality::Output));
    let mut bits = Vec::new();
    for (size, offsets) in moves {
        for (&(reference, start, nominal), offset) in inputs.iter().zip(offsets) {
            instance.set(&[reference], |_| start + offset * nominal).unwrap();
        }
        tune(instance, description, offsets[0]);
        instance.step(instance.time(), *size, &mut Silent).unwrap();
        bits.extend(read(instance, &outputs).into_iter().map(f64::to_bits));
    }
    bits
}

fn continues_equally<M: Model>(resources: &Resources, before: &[Move], after: &[Move]) {
    continues_equally_from(started::<M>(resources), resources, before, after);
}

fn continues_equally_from<M: Model>(
    mut first: Instance<M>,
    resources: &Resources,
    before: &[Move],
    after: &[Move],
) {
    let description = describe::<M>(resources).unwrap().description;
    run(&mut first, &description, before);
    let snapshot = first.snapshot().unwrap();
    let bytes = first.serialise(&snapshot).unwrap();
    let expected = run(&mut first, &description, after);
    first.restore(&snapshot).unwrap();
    assert_eq!(first.serialise(&first.snapshot().unwrap()).unwrap(), bytes, "nothing is forgotten");
    assert_eq!(run(&mut first, &description, after), expected, "restored from snapshot");
    // An instance that never ran, and one that ran differently.
    for mut other in [instance::<M>(resources), first] {
        let read = other.deserialise(&bytes).unwrap();
        other.restore(&read).unwrap();
        assert_eq!(run(&mut other, &description, after), expected, "restored from bytes");
    }
    assert!(expected.len() > after.len());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn restored_plants_continue_equally(before in moves(6), after in moves(6)) {
        continues_equally::<PlantModel>(&resources(), &before, &after);
        continues_equally::<PlantModel>(&with_given_speed(), &before, &after);
        continues_equally::<PlantModel>(&turning(), &before, &after);
        for files in [resources(), turning()] {
            continues_equally_from(started_with::<PlantModel>(&files, set_waves), &files, &before, &after);
        }
    }

    #[test]
    fn restored_controllers_continue_equally(before in moves(9), after in moves(9)) {
        continues_equally::<Controller>(&resources(), &before, &after);
        continues_equally::<Controller>(&with_two_degrees(), &before, &after);
        continues_equally::<Controller>(&turning(), &before, &after);
    }

    #[test]
    fn restored_loops_continue_equally(before in moves(6), after in moves(6)) {
        continues_equally::<ClosedLoop>(&resources(), &before, &after);
        continues_equally::<ClosedLoop>(&with_two_degrees(), &before, &after);
        continues_equally::<ClosedLoop>(&with_given_speed(), &before, &after);
        continues_equally::<ClosedLoop>(&turning(), &before, &after);
        for files in [resources(), turning()] {
            continues_equally_from(started_with::<ClosedLoop>(&files, set_waves), &files, &before, &after);
        }
    }
}

fn check_every_phase<M: Model>(interface: Interface) {
    let described = || describe::<M>(&resources()).unwrap();
    let mut instance = Instance::<M>::made_for(interface, described());
    let round_trips = |instance: &Instance<M>| {
        let bytes = instance.serialise(&instance.snapshot().unwrap()).unwrap();
        let mut other = Instance::<M>::made_for(interface, described());
        other.restore(&other.deserialise(&bytes).unwrap()).unwrap();
        assert_eq!(other.phase(), instance.phase());
        assert_eq!(other.serialise(&other.snapshot().unwrap()).unwrap(), bytes);
    };
    round_trips(&instance);
    instance.enter_initialization().unwrap();
    round_trips(&instance);
    instance.exit_initialization(&mut Silent).unwrap();
    round_trips(&instance);
    instance.terminate().unwrap();
    round_trips(&instance);
}

#[test]
fn every_phase_round_trips_as_bytes() {
    for interface in [Interface::CoSimulation, Interface::ModelExchange] {
        check_every_phase::<PlantModel>(interface);
        check_every_phase::<ClosedLoop>(interface);
    }
    check_every_phase::<Controller>(Interface::CoSimulation);
}

/// A state with a valid checksum but the identity of another FMU is refused, and so is a truncated state.
#[test]
fn rejects_state_of_another_fmu() {
    let plant = started::<PlantModel>(&resources());
    let bytes = plant.serialise(&plant.snapshot().unwrap()).unwrap();
    let refused = started::<ClosedLoop>(&resources()).deserialise(&bytes).err().unwrap();
    assert!(matches!(refused, Refusal::BadState(StateError::OtherFmu)), "{refused}");
    for length in [0, 1, 40, bytes.len() / 2, bytes.len() - 1] {
        assert!(plant.deserialise(&bytes[..length]).is_err());
    }
}
