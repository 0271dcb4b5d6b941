//! None of the three FMUs allocates during exchange and step, and instances free all their memory.
#![allow(unsafe_code, clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod abi;
mod example;

use std::sync::atomic::Ordering;

use abi::{MESSAGES, Unpacked, do_step, free, get};
use allocation_counter::measure;
use squid_fmi2::abi::{Component, Status, access, exchange, step};
use squid_fmi2::model_description::{Causality, Kind, ModelDescription, ScalarVariable, Variability};
use squid_fmi2::{Interface, Model, Resources, describe};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

/// Value references, and start values of the inputs and of the tunable parameters.
struct Signals {
    inputs: Vec<u32>,
    start: Vec<f64>,
    outputs: Vec<u32>,
    all: Vec<u32>,
    tunable: Vec<u32>,
    tuned: Vec<f64>,
    states: usize,
}

fn signals(description: &ModelDescription) -> Signals {
    let real = |wanted: &dyn Fn(&ScalarVariable) -> bool| {
        let all = description.variables.iter().filter(|one| matches!(one.kind, Kind::Real { .. }));
        let chosen = all.filter(|one| wanted(one));
        let start = |kind: &Kind| match kind {
            Kind::Real { start, .. } => start.unwrap_or(0.0),
            _ => 0.0,
        };
        chosen.map(|one| (one.value_reference, start(&one.kind))).unzip()
    };
    let (inputs, start) = real(&|one| one.causality == Causality::Input);
    let (outputs, _): (_, Vec<f64>) = real(&|one| one.causality == Causality::Output);
    let (tunable, tuned) = real(&|one| one.variability == Variability::Tunable);
    let (all, _): (_, Vec<f64>) = real(&|_| true);
    Signals { inputs, start, outputs, all, tunable, tuned, states: description.structure().derivatives.len() }
}

fn set_all<M: Model>(c: Component, signals: &Signals) {
    let count = signals.inputs.len();
    let status = unsafe { access::set_real::<M>(c, signals.inputs.as_ptr(), count, signals.start.as_ptr()) };
    assert_eq!(status, Status::Ok);
}

/// Changes the tunable parameters.
fn tune<M: Model>(c: Component, signals: &Signals, factor: f64) {
    let mut values = [0.0; 8];
    values.iter_mut().zip(&signals.tuned).for_each(|(value, start)| *value = factor * start);
    let count = signals.tunable.len();
    let status = unsafe { access::set_real::<M>(c, signals.tunable.as_ptr(), count, values.as_ptr()) };
    assert_eq!(status, Status::Ok);
}

/// Simulates a thousand communication steps with all calls that belong to one.
fn simulate<M: Model>(c: Component, signals: &Signals) -> f64 {
    let (mut values, mut rates) = ([0.0; 256], [0.0; 256]);
    let (orders, count) = ([1; 256], signals.outputs.len());
    let mut sum = 0.0;
    for k in 0..1000 {
        set_all::<M>(c, signals);
        tune::<M>(c, signals, 1.0 + 1e-3 * f64::from(k % 3));
        if signals.states > 0 {
            let (references, slopes) = (signals.inputs.as_ptr(), [1e-3; 16]);
            let count = signals.inputs.len();
            let orders = orders.as_ptr();
            let status = unsafe {
                step::set_real_input_derivatives::<M>(c, references, count, orders, slopes.as_ptr())
            };
            assert_eq!(status, Status::Ok);
        }
        assert_eq!(do_step::<M>(c, f64::from(k) * 0.03, 0.03), Status::Ok);
        assert_eq!(get::<M>(c, &signals.all, &mut values), Status::Ok);
        sum += values[..signals.all.len()].iter().sum::<f64>();
        if signals.states > 0 {
            let (references, orders) = (signals.outputs.as_ptr(), orders.as_ptr());
            let derivatives = rates.as_mut_ptr();
            let status =
                unsafe { step::get_real_output_derivatives::<M>(c, references, count, orders, derivatives) };
            assert_eq!(status, Status::Ok);
        }
        unsafe {
            let (mut time, mut status) = (0.0, Status::Ok);
            assert_eq!(step::get_real_status::<M>(c, 2, &mut time), Status::Ok);
            assert_eq!(step::get_status::<M>(c, 0, &mut status), Status::Ok);
        }
    }
    sum
}

/// Evaluates the right-hand side a thousand times, with occasional events.
fn integrate<M: Model>(c: Component, signals: &Signals) -> f64 {
    let (mut states, mut rates, mut sum) = ([0.0; 64], [0.0; 64], 0.0);
    let n = signals.states;
    let mut info = squid_fmi2::abi::EventInfo::default();
    unsafe {
        for k in 0..1000 {
            if k % 10 == 0 {
                assert_eq!(exchange::enter_event_mode::<M>(c), Status::Ok);
                tune::<M>(c, signals, 1.0 + 1e-3 * f64::from(k % 3));
                assert_eq!(exchange::new_discrete_states::<M>(c, &mut info), Status::Ok);
                assert_eq!(exchange::enter_continuous_time_mode::<M>(c), Status::Ok);
            }
            set_all::<M>(c, signals);
            assert_eq!(exchange::set_time::<M>(c, f64::from(k) * 1e-3), Status::Ok);
            assert_eq!(exchange::get_continuous_states::<M>(c, states.as_mut_ptr(), n), Status::Ok);
            assert_eq!(exchange::get_derivatives::<M>(c, rates.as_mut_ptr(), n), Status::Ok);
            states.iter_mut().zip(rates).for_each(|(state, rate)| *state += 1e-3 * rate);
            assert_eq!(exchange::set_continuous_states::<M>(c, states.as_ptr(), n), Status::Ok);
            let (mut event, mut end) = (0, 0);
            let status = exchange::completed_integrator_step::<M>(c, 1, &mut event, &mut end);
            assert_eq!(status, Status::Ok);
            assert_eq!(get::<M>(c, &signals.outputs, &mut rates), Status::Ok);
            sum += states[3] + rates[0];
        }
    }
    sum
}

fn allocates_nothing<M: Model>(run: fn(Component, &Signals) -> f64, interface: Interface) {
    for files in [example::resources(), example::with_curves(), example::turning()] {
        allocates_nothing_of::<M>(&files, &[], run, interface);
        allocates_nothing_of::<M>(&files, &example::SEA, run, interface);
    }
}

fn allocates_nothing_of<M: Model>(
    files: &Resources,
    parameters: &[(&str, f64)],
    run: fn(Component, &Signals) -> f64,
    interface: Interface,
) {
    let fmu = Unpacked::<M>::new(files);
    let description = describe::<M>(files).unwrap().description;
    let signals = signals(&description);
    // The controller has no wave parameters.
    let reference = |name: &str| Some(description.variables[description.position(name)?].value_reference);
    let known = parameters.iter().filter_map(|(name, value)| Some((reference(name)?, *value)));
    let c = fmu.started_with(interface, &known.collect::<Vec<_>>());
    let mut sum = 0.0;
    let flight = measure(|| sum = run(c, &signals));
    assert_eq!(flight.count_total, 0, "{interface:?}");
    assert!(sum != 0.0 && sum.is_finite());
    free::<M>(c);
}

fn leaves_nothing_behind<M: Model>(count: usize) {
    let fmu = Unpacked::<M>::new(&example::resources());
    let one = || {
        let c = fmu.started(Interface::CoSimulation);
        assert_eq!(do_step::<M>(c, 0.0, 0.01), Status::Ok);
        free::<M>(c);
    };
    one();
    let all = measure(|| (0..count).for_each(|_| one()));
    assert!(all.count_total > 0, "the allocator counts");
    assert_eq!(all.bytes_current, 0, "bytes left after {count} instances");
}

#[test]
fn steps_do_not_allocate_and_instances_do_not_leak() {
    let (co_simulation, model_exchange) = (Interface::CoSimulation, Interface::ModelExchange);
    allocates_nothing::<PlantModel>(simulate::<PlantModel>, co_simulation);
    allocates_nothing::<Controller>(simulate::<Controller>, co_simulation);
    allocates_nothing::<ClosedLoop>(simulate::<ClosedLoop>, co_simulation);
    allocates_nothing::<PlantModel>(integrate::<PlantModel>, model_exchange);
    allocates_nothing::<ClosedLoop>(integrate::<ClosedLoop>, model_exchange);
    assert_eq!(MESSAGES.load(Ordering::Relaxed), 0, "nothing is logged in the normal path");
    leaves_nothing_behind::<PlantModel>(1000);
    leaves_nothing_behind::<Controller>(10_000);
    leaves_nothing_behind::<ClosedLoop>(1000);
}
