//! Many instances and threads at once: each behaves like a single instance.

use crate::abi::{Unpacked, do_step, free, get, set};
use crate::example;
use squid_fmi2::abi::Status;
use squid_fmi2::model_description::Causality;
use squid_fmi2::{Interface, Model, describe};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

const THREADS: usize = 8;
const INSTANCES: usize = 6;
const STEPS: usize = 60;

/// Simulates all instances of one thread in turn, each with its own value of an input; returns the bits of an output.
fn fly<M: Model>(fmu: &Unpacked<M>, input: u32, output: u32, first: usize) -> Vec<u64> {
    let all: Vec<_> = (0..INSTANCES).map(|_| fmu.started(Interface::CoSimulation)).collect();
    let mut bits = Vec::new();
    for k in 0..STEPS {
        for (number, &c) in all.iter().enumerate() {
            let value = 0.01 * (first + number) as f64 + 1e-3 * k as f64;
            assert_eq!(set::<M>(c, input, value), Status::Ok);
            assert_eq!(do_step::<M>(c, k as f64 * 0.02, 0.02), Status::Ok);
            let mut found = [f64::NAN];
            assert_eq!(get::<M>(c, &[output], &mut found), Status::Ok);
            bits.push(found[0].to_bits());
        }
    }
    all.into_iter().for_each(free::<M>);
    bits
}

fn single_and_concurrent_runs_are_equal<M: Model>(input: &str, output: &str) {
    let fmu = Unpacked::<M>::new(&example::resources());
    let description = describe::<M>(&example::resources()).unwrap().description;
    let reference = |name: &str| description.variables[description.position(name).unwrap()].value_reference;
    assert_eq!(description.variables[description.position(input).unwrap()].causality, Causality::Input);
    let (input, output) = (reference(input), reference(output));
    let alone: Vec<_> = (0..THREADS).map(|thread| fly(&fmu, input, output, 10 * thread)).collect();
    let crowd: Vec<_> = std::thread::scope(|scope| {
        let fly = |thread| {
            scope.spawn({
                let fmu = &fmu;
                move || fly(fmu, input, output, 10 * thread)
            })
        };
        let threads: Vec<_> = (0..THREADS).map(fly).collect();
        threads.into_iter().map(|one| one.join().unwrap()).collect()
    });
    assert_eq!(alone, crowd);
    assert_ne!(alone[0], alone[1], "the input acts");
}

#[test]
fn plants_are_independent() {
    single_and_concurrent_runs_are_equal::<PlantModel>("current_horizontal", "distance");
}

#[test]
fn controllers_are_independent() {
    single_and_concurrent_runs_are_equal::<Controller>("pitch_reference", "lower");
}

#[test]
fn loops_are_independent() {
    single_and_concurrent_runs_are_equal::<ClosedLoop>("current_vertical", "depth");
}

/// Sets NaN and infinity in every Real variable, in every state in which it can be set.
fn rejects_non_finite<M: Model>() {
    let fmu = Unpacked::<M>::new(&example::resources());
    let description = describe::<M>(&example::resources()).unwrap().description;
    let (fresh, started) = (fmu.instantiate(Interface::CoSimulation), fmu.started(Interface::CoSimulation));
    let mut tried = 0;
    for variable in &description.variables {
        let (settable, in_flight) = (variable.needs_start(), variable.causality == Causality::Input);
        if !settable || variable.unit().is_none() {
            continue;
        }
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let reference = variable.value_reference;
            assert_eq!(set::<M>(fresh, reference, value), Status::Error, "{}", variable.name);
            if in_flight {
                let (mut before, mut after) = ([0.0], [0.0]);
                assert_eq!(get::<M>(started, &[reference], &mut before), Status::Ok);
                assert_eq!(set::<M>(started, reference, value), Status::Error, "{}", variable.name);
                assert_eq!(get::<M>(started, &[reference], &mut after), Status::Ok);
                assert_eq!(before, after, "{}", variable.name);
                tried += 1;
            }
        }
    }
    assert!(tried >= 12);
    assert_eq!(do_step::<M>(started, 0.0, 0.1), Status::Ok, "the refusals left no trace");
    free::<M>(fresh);
    free::<M>(started);
}

#[test]
fn rejects_nan_and_infinity_everywhere() {
    rejects_non_finite::<PlantModel>();
    rejects_non_finite::<Controller>();
    rejects_non_finite::<ClosedLoop>();
}
