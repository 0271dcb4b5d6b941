//! Steps of real importers: the time does not drift, and results do not depend on the partition of an interval.

use crate::case::{described, read, real_of, references, started};
use crate::example::resources;
use proptest::prelude::*;
use squid_fmi2::model_description::Causality;
use squid_fmi2::{Experiment, Failure, Instance, Interface, Model, Refusal, Silent, describe};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

/// Step sizes observed from importers for 0.01 s.
const NEARLY_A_HUNDREDTH: [f64; 4] = [0.01, 0.00999999999999934, 0.010000000000000009, 0.009999999999999787];

fn outputs<M: Model>(instance: &mut Instance<M>) -> Vec<f64> {
    read(instance, &references(&real_of(&described::<M>(), Causality::Output)))
}

/// Offsets an input from its start value, to cause motion.
fn disturb<M: Model>(instance: &mut Instance<M>, name: &str, by: f64) {
    let reference = instance.table().reference(name).unwrap();
    let start = read(instance, &[reference])[0];
    instance.set(&[reference], |_| start + by).unwrap();
}

/// Returns outputs after ten seconds of steps at the times computed by the importer.
fn flown<M: Model>(disturbed: &str, next: impl Fn(usize, f64) -> Option<(f64, f64)>) -> (f64, Vec<f64>) {
    let mut instance = started::<M>(Interface::CoSimulation);
    disturb(&mut instance, disturbed, 0.05);
    let mut count = 0;
    while let Some((at, size)) = next(count, instance.time()) {
        instance.step(at, size, &mut Silent).unwrap();
        count += 1;
    }
    (instance.time(), outputs(&mut instance))
}

fn partition_has_no_effect<M: Model>(disturbed: &str, tolerance: f64) {
    const END: f64 = 10.0;
    let cut = |size: f64| {
        flown::<M>(disturbed, move |_, now| (now < END - 1e-9).then(|| (now, size.min(END - now))))
    };
    let (time, expected) = cut(END);
    assert_eq!(time, END);
    let mut all =
        vec![("a third of a hundredth", cut(0.01 / 3.0)), ("a seventh of a second", cut(1.0 / 7.0))];
    for size in NEARLY_A_HUNDREDTH {
        // Each step starts at the importer's own time.
        all.push((
            "steps on the importer's grid",
            flown::<M>(disturbed, |k, _| (k < 1000).then_some((k as f64 * 0.01, size))),
        ));
        all.push((
            "steps summed by the importer",
            flown::<M>(disturbed, |k, now| (k < 1000).then_some((now, size))),
        ));
    }
    for (how, (time, values)) in all {
        assert!((time - END).abs() < 1e-11 * 1000.0, "{how}: {time} s");
        for (found, expected) in values.iter().zip(&expected) {
            assert!(
                (found - expected).abs() < tolerance * (1.0 + expected.abs()),
                "{how}: {found}, {expected}"
            );
        }
    }
}

#[test]
fn plant_does_not_depend_on_step_sizes() {
    partition_has_no_effect::<PlantModel>("lower", 1e-9);
}

#[test]
fn loop_does_not_depend_on_step_sizes() {
    partition_has_no_effect::<ClosedLoop>("current_vertical", 1e-9);
}

/// A current set at a tick acts in this tick, regardless of the rounding of the importer's time.
#[test]
fn tick_uses_inputs_set_at_its_time() {
    let flown = |size: f64, summed: bool| {
        let mut instance = started::<ClosedLoop>(Interface::CoSimulation);
        let steps = |seconds: f64| (seconds / size).round() as usize;
        for k in 0..steps(9.0) {
            if k == steps(7.02) {
                disturb(&mut instance, "current_horizontal", 0.3);
            }
            let at = if summed { instance.time() } else { k as f64 * size };
            instance.step(at, size, &mut Silent).unwrap();
        }
        outputs(&mut instance)
    };
    let expected = flown(0.02, false);
    for size in [0.001, 0.002, 0.005, 0.01, 0.02] {
        for summed in [false, true] {
            for (one, other) in flown(size, summed).into_iter().zip(&expected) {
                assert!((one - other).abs() < 1e-9 * (1.0 + other.abs()), "{size} s: {one} and {other}");
            }
        }
    }
}

/// A time in hundredths of a second, an input, and its offset from the start value in nominal values.
type Setting = (usize, usize, f64);

/// Returns outputs after three seconds in which inputs are set, each hundredth divided into `pieces` steps.
fn outputs_under<M: Model>(settings: &[Setting], pieces: usize, summed: bool) -> Vec<f64> {
    let inputs = real_of(&described::<M>(), Causality::Input);
    let mut instance = started::<M>(Interface::CoSimulation);
    if let Some(manual) = instance.table().reference("manual") {
        instance.set(&[manual], |_| true).unwrap();
    }
    let size = 0.01 / pieces as f64;
    for hundredth in 0..300 {
        for &(_, input, off) in settings.iter().filter(|(when, _, _)| *when == hundredth) {
            let (reference, start, nominal) = inputs[input % inputs.len()];
            instance.set(&[reference], |_| start + off * nominal).unwrap();
        }
        for piece in 0..pieces {
            let at = if summed { instance.time() } else { (hundredth * pieces + piece) as f64 * size };
            instance.step(at, size, &mut Silent).unwrap();
        }
    }
    outputs(&mut instance)
}

fn check_settings<M: Model>(settings: &[Setting]) {
    let expected = outputs_under::<M>(settings, 1, false);
    for (pieces, summed) in [(1, true), (2, true), (3, false), (7, true), (10, false)] {
        for (one, other) in outputs_under::<M>(settings, pieces, summed).into_iter().zip(&expected) {
            let alike = (one - other).abs() < 1e-9 * (1.0 + other.abs());
            assert!(alike, "{pieces} steps a hundredth, summed: {summed}: {one} and {other}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    /// Neither the partition of the time between settings nor the importer's computation of time has an effect.
    #[test]
    fn inputs_have_the_same_effect_for_any_steps(
        settings in prop::collection::vec((0usize..290, any::<usize>(), -0.3..0.3), 1..6),
    ) {
        check_settings::<PlantModel>(&settings);
        check_settings::<Controller>(&settings);
        check_settings::<ClosedLoop>(&settings);
    }
}

/// A clock that counts from 1970 loses nanoseconds by rounding, but wrong steps are still detected.
#[test]
fn wrong_steps_are_detected_at_large_times() {
    const START: f64 = 1_763_400_000.0;
    let mut plant = Instance::new(describe::<PlantModel>(&resources()).unwrap());
    plant.set_up(Experiment { start: START, ..Experiment::default() }).unwrap();
    plant.enter_initialization().unwrap();
    plant.exit_initialization(&mut Silent).unwrap();
    for (at, size) in [(START + 1.0, 0.01), (START - 1.0, 2.0), (START + 1e-3, 0.01)] {
        let refused = plant.step(at, size, &mut Silent).unwrap_err();
        let Failure::Refused(Refusal::WrongCommunicationPoint { given, expected }) = refused else {
            panic!("{refused}")
        };
        assert_eq!((given, expected), (at, START));
    }
    for k in 0..100 {
        plant.step(START + f64::from(k) * 0.01, 0.01, &mut Silent).unwrap();
    }
    assert_eq!(plant.time(), START + 1.0);
}

/// The number of ticks equals the number of sample times, for any partition into steps.
#[test]
fn controller_ticks_do_not_depend_on_step_sizes() {
    partition_has_no_effect::<Controller>("pitch_reference", 1e-12);
}

#[test]
fn million_tiny_steps_do_not_drift() {
    let mut instance = started::<Controller>(Interface::CoSimulation);
    disturb(&mut instance, "pitch_reference", 0.05);
    for k in 0..1_000_000 {
        instance.step(f64::from(k) * 1e-6, 1e-6, &mut Silent).unwrap();
    }
    assert!((instance.time() - 1.0).abs() < 1e-12, "{}", instance.time());
    assert_eq!(instance.model().axes()[0].autopilot().ticks(), 50);
    let mut single = started::<Controller>(Interface::CoSimulation);
    disturb(&mut single, "pitch_reference", 0.05);
    single.step(0.0, 1.0, &mut Silent).unwrap();
    assert_eq!(outputs(&mut single), outputs(&mut instance));
}

#[test]
fn microsecond_steps_equal_long_steps() {
    let (mut tiny, mut single) =
        (started::<PlantModel>(Interface::CoSimulation), started(Interface::CoSimulation));
    for plant in [&mut tiny, &mut single] {
        disturb(plant, "lower", 5.0);
    }
    for k in 0..20_000 {
        tiny.step(f64::from(k) * 1e-6, 1e-6, &mut Silent).unwrap();
    }
    single.step(0.0, 0.02, &mut Silent).unwrap();
    for (one, other) in outputs(&mut tiny).into_iter().zip(outputs(&mut single)) {
        assert!((one - other).abs() < 1e-9 * (1.0 + other.abs()), "{one} and {other}");
    }
}

/// A fourth-order integrator with the derivatives of the loop, and its ticks as events.
#[test]
fn model_exchange_equals_co_simulation() {
    let mut exchange = started::<ClosedLoop>(Interface::ModelExchange);
    let mut simulated = started::<ClosedLoop>(Interface::CoSimulation);
    let count = exchange.table().states().len();
    let mut next = exchange.new_discrete_states(&mut Silent).unwrap().next.unwrap();
    let (mut time, end) = (0.0, 8.0);
    let mut states = vec![0.0; count];
    while time < end - 1e-9 {
        exchange.enter_continuous_time_mode().unwrap();
        exchange.continuous_states(&mut states, &mut Silent).unwrap();
        let pieces = 4;
        let h = (next.min(end) - time) / f64::from(pieces);
        for piece in 0..pieces {
            runge_kutta(&mut exchange, time + f64::from(piece) * h, h, &mut states);
        }
        time = next.min(end);
        exchange.set_time(time).unwrap();
        exchange.enter_event_mode().unwrap();
        if time < end - 1e-9 {
            next = exchange.new_discrete_states(&mut Silent).unwrap().next.unwrap();
            assert!(next > time);
        }
    }
    simulated.step(0.0, end, &mut Silent).unwrap();
    let pairs = outputs(&mut exchange).into_iter().zip(outputs(&mut simulated));
    for (index, (one, other)) in pairs.enumerate() {
        assert!((one - other).abs() < 1e-8 * (1.0 + other.abs()), "output {index}: {one} and {other}");
    }
}

fn runge_kutta<M: Model>(instance: &mut Instance<M>, time: f64, h: f64, states: &mut [f64]) {
    let mut rate = |at: f64, offset: &[f64], by: f64| {
        let moved: Vec<f64> = states.iter().zip(offset).map(|(x, slope)| x + by * slope).collect();
        let mut slope = vec![0.0; moved.len()];
        instance.set_time(at).unwrap();
        instance.set_continuous_states(&moved).unwrap();
        instance.derivatives(&mut slope, &mut Silent).unwrap();
        slope
    };
    let still = vec![0.0; states.len()];
    let k1 = rate(time, &still, 0.0);
    let k2 = rate(time + 0.5 * h, &k1, 0.5 * h);
    let k3 = rate(time + 0.5 * h, &k2, 0.5 * h);
    let k4 = rate(time + h, &k3, h);
    for (index, state) in states.iter_mut().enumerate() {
        *state += h / 6.0 * (k1[index] + 2.0 * (k2[index] + k3[index]) + k4[index]);
    }
    instance.set_continuous_states(states).unwrap();
    instance.integrator_step_completed(&mut Silent).unwrap();
}
