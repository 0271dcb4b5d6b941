//! Directional derivatives, compared with finite differences.

use crate::case::*;
use crate::example::resources;
use proptest::prelude::*;
use squid_fmi2::model_description::{Causality, ModelDescription};
use squid_fmi2::{Failure, Instance, Interface, Model, Refusal, Silent, describe};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

/// Asserts that derivatives equal the central differences of `value`, relative to the size of the compared quantities,
/// for one of three step sizes: near rest, the root in a thruster's curve is too curved for the largest one.
fn assert_slopes(names: &[&str], exact: &[f64], size: &[f64], step: f64, value: impl Fn(f64) -> Vec<f64>) {
    let steps = [step, 0.1 * step, 0.01 * step].map(|step| (step, value(step), value(-step)));
    for (position, name) in names.iter().enumerate() {
        let slopes =
            steps.each_ref().map(|(h, above, below)| (above[position] - below[position]) / (2.0 * h));
        let tolerance = 1e-5 * (exact[position].abs() + size[position]);
        let agrees = slopes.iter().any(|slope| (slope - exact[position]).abs() < tolerance);
        assert!(agrees, "{name}: {} and {slopes:?}", exact[position]);
    }
}

/// Returns `at + step * by`.
fn along(at: &[f64], by: &[f64], step: f64) -> Vec<f64> {
    at.iter().zip(by).map(|(at, by)| at + step * by).collect()
}

/// Returns the value references of derivatives and outputs, with their names.
fn unknowns(description: &ModelDescription) -> (Vec<u32>, Vec<&str>) {
    let rates = description.structure().derivatives.into_iter().map(|one| one.index as u32 - 1);
    let unknowns: Vec<u32> = rates.chain(references(&real_of(description, Causality::Output))).collect();
    let names = unknowns.iter().map(|&one| description.variables[one as usize].name.as_str()).collect();
    (unknowns, names)
}

/// Checks derivatives and outputs with respect to states and inputs, in continuous-time mode, along a direction.
fn check_in_continuous_time<M: Model>(case: Case, offsets: &[f64], direction: &[f64]) {
    let description = case.describe::<M>().description;
    let mut instance = case.instance::<M>(Interface::ModelExchange);
    instance.exit_initialization(&mut Silent).unwrap();
    instance.new_discrete_states(&mut Silent).unwrap();
    instance.enter_continuous_time_mode().unwrap();
    let inputs = real_of(&description, Causality::Input);
    let states = instance.table().states().to_vec();
    let mut trim = vec![0.0; states.len()];
    instance.continuous_states(&mut trim, &mut Silent).unwrap();
    let mut nominals = vec![0.0; states.len()];
    instance.nominals(&mut nominals).unwrap();
    let mut offset = offsets.iter().cycle();
    let mut near = |value: f64, nominal: f64| value + 0.2 * nominal * offset.next().unwrap();
    let at_states: Vec<f64> = trim.iter().zip(&nominals).map(|(&x, &nominal)| near(x, nominal)).collect();
    let at_inputs: Vec<f64> = inputs.iter().map(|&(_, start, nominal)| near(start, nominal)).collect();
    let sizes = nominals.iter().copied().chain(inputs.iter().map(|one| one.2));
    let seed: Vec<f64> = sizes.zip(direction.iter().cycle()).map(|(size, along)| size * along).collect();
    let (along_states, along_inputs) = seed.split_at(states.len());
    let input_references = references(&inputs);
    let (unknowns, names) = unknowns(&description);
    let values = |step: f64| {
        let mut moved = Instance::<M>::made_for(Interface::ModelExchange, case.describe());
        moved.restore(&instance.snapshot().unwrap()).unwrap();
        write(&mut moved, &input_references, &along(&at_inputs, along_inputs, step));
        moved.set_continuous_states(&along(&at_states, along_states, step)).unwrap();
        read(&mut moved, &unknowns)
    };
    let size: Vec<f64> = values(0.0).iter().map(|value| value.abs() + 1e-2).collect();
    let mut moved = Instance::<M>::made_for(Interface::ModelExchange, case.describe());
    moved.restore(&instance.snapshot().unwrap()).unwrap();
    write(&mut moved, &input_references, &at_inputs);
    moved.set_continuous_states(&at_states).unwrap();
    let knowns: Vec<u32> = states.iter().chain(&input_references).copied().collect();
    let mut exact = vec![0.0; unknowns.len()];
    moved.directional_derivative(&unknowns, &knowns, &seed, &mut exact, &mut Silent).unwrap();
    assert!(exact.iter().any(|value| *value != 0.0));
    assert_slopes(&names, &exact, &size, 1e-5, values);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn plant_derivatives_match_differences(
        offsets in prop::collection::vec(0.1..1.0, 17),
        direction in prop::collection::vec(-1.0..1.0, 13),
    ) {
        CASES.iter().for_each(|case| check_in_continuous_time::<PlantModel>(*case, &offsets, &direction));
    }

    #[test]
    fn loop_derivatives_match_differences(
        offsets in prop::collection::vec(0.1..1.0, 17),
        direction in prop::collection::vec(-1.0..1.0, 13),
    ) {
        CASES.iter().for_each(|case| check_in_continuous_time::<ClosedLoop>(*case, &offsets, &direction));
    }

    #[test]
    fn derivatives_of_first_commands_match_differences(
        at in prop::collection::vec(-1.0..1.0, 12),
        direction in prop::collection::vec(-1.0..1.0, 12),
    ) {
        for case in [SQUID, TWO_DEGREES, CURVED, GIVEN, TURNING] {
            check_first_outputs(case, &at, &direction);
        }
    }

    #[test]
    fn derivatives_of_the_next_tick_match_differences(
        at in prop::collection::vec(-1.0..1.0, 12),
        direction in prop::collection::vec(-1.0..1.0, 12),
        ticks in 0..20,
    ) {
        for case in [SQUID, TWO_DEGREES, CURVED, GIVEN, TURNING] {
            check_next_tick(case, &at, &direction, ticks);
        }
    }
}

/// Returns the inputs of the controller near level flight, a direction, and the outputs.
fn around(case: Case, at: &[f64], direction: &[f64]) -> (Vec<u32>, Vec<f64>, Vec<f64>, Vec<u32>) {
    let description = case.describe::<Controller>().description;
    let inputs = real_of(&description, Causality::Input);
    let seed = inputs.iter().zip(direction).map(|(one, by)| one.2 * by).collect();
    let outputs = references(&real_of(&description, Causality::Output));
    (references(&inputs), at_inputs(&inputs, at), seed, outputs)
}

/// Checks the first outputs of the controller with respect to its inputs, in initialisation mode, by setting and
/// getting.
fn check_first_outputs(case: Case, at: &[f64], direction: &[f64]) {
    let (inputs, point, seed, outputs) = around(case, at, direction);
    let mut now = case.instance::<Controller>(Interface::CoSimulation);
    write(&mut now, &inputs, &point);
    let mut exact = vec![0.0; outputs.len()];
    now.directional_derivative(&outputs, &inputs, &seed, &mut exact, &mut Silent).unwrap();
    let values = |step: f64| {
        let mut moved = case.instance::<Controller>(Interface::CoSimulation);
        let at = along(&point, &seed, step);
        write(&mut moved, &inputs, &at);
        read(&mut moved, &outputs)
    };
    assert_outputs(&outputs, &exact, values);
}

/// The next tick also depends on applied commands if the anti-windup uses them, or if it follows them.
#[test]
fn no_derivatives_while_applied_commands_are_used() {
    let description = SQUID.describe::<Controller>().description;
    let of = |name: &str| u32::try_from(description.position(name).unwrap()).unwrap();
    let refused = |name: &str, value: bool| {
        let mut now = SQUID.instance::<Controller>(Interface::CoSimulation);
        now.exit_initialization(&mut Silent).unwrap();
        let derive = |now: &mut Instance<Controller>| {
            let (of, by) = ([of("lower")], [of("pitch")]);
            now.directional_derivative(&of, &by, &[1.0], &mut [0.0], &mut Silent).is_err()
        };
        assert!(!derive(&mut now));
        now.set(&[of(name)], |_| value).unwrap();
        derive(&mut now)
    };
    assert!(refused("engaged", false) && refused("applied_given", true));
}

/// Checks the commands of the tick at the start of the next step, by setting, stepping and getting.
fn check_next_tick(case: Case, at: &[f64], direction: &[f64], ticks: i32) {
    let (inputs, point, seed, outputs) = around(case, at, direction);
    let sample_time = 0.02;
    let mut now = case.instance::<Controller>(Interface::CoSimulation);
    now.exit_initialization(&mut Silent).unwrap();
    write(&mut now, &inputs, &point);
    for _ in 0..ticks {
        now.step(now.time(), sample_time, &mut Silent).unwrap();
    }
    let before = now.snapshot().unwrap();
    let mut exact = vec![0.0; outputs.len()];
    now.directional_derivative(&outputs, &inputs, &seed, &mut exact, &mut Silent).unwrap();
    let values = |step: f64| {
        let mut moved = case.instance::<Controller>(Interface::CoSimulation);
        moved.restore(&before).unwrap();
        let at = along(&point, &seed, step);
        write(&mut moved, &inputs, &at);
        moved.step(moved.time(), 1e-3, &mut Silent).unwrap();
        read(&mut moved, &outputs)
    };
    assert_outputs(&outputs, &exact, values);
    now.step(now.time(), 1e-3, &mut Silent).unwrap();
    now.directional_derivative(&outputs, &inputs, &seed, &mut exact, &mut Silent).unwrap();
    assert!(exact.iter().all(|value| *value == 0.0), "no tick is due now");
}

fn assert_outputs(outputs: &[u32], exact: &[f64], values: impl Fn(f64) -> Vec<f64>) {
    let names: Vec<String> = outputs.iter().map(|one| format!("output {one}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    assert_slopes(&names, exact, &vec![1.0; outputs.len()], 1e-6, values);
}

/// Checks first outputs and derivatives with respect to the inputs, in initialisation mode, by setting and getting.
fn check_start<M: Model>(case: Case, offsets: &[f64], direction: &[f64], prepare: fn(&mut Instance<M>)) {
    let description = case.describe::<M>().description;
    let inputs = real_of(&description, Causality::Input);
    let offset = |(&(_, start, nominal), by): (&(u32, f64, f64), &f64)| start + 0.1 * nominal * by;
    let point: Vec<f64> = inputs.iter().zip(offsets.iter().cycle()).map(offset).collect();
    let seed: Vec<f64> =
        inputs.iter().zip(direction.iter().cycle()).map(|(one, along)| 0.1 * one.2 * along).collect();
    let (unknowns, names) = unknowns(&description);
    let start = |step: f64| {
        let mut instance = case.instance::<M>(Interface::CoSimulation);
        prepare(&mut instance);
        let at = along(&point, &seed, step);
        write(&mut instance, &references(&inputs), &at);
        instance
    };
    let mut exact = vec![0.0; unknowns.len()];
    let known = references(&inputs);
    start(0.0).directional_derivative(&unknowns, &known, &seed, &mut exact, &mut Silent).unwrap();
    let size: Vec<f64> = read(&mut start(0.0), &unknowns).iter().map(|value| value.abs() + 1e-2).collect();
    assert_slopes(&names, &exact, &size, 1e-4, |step| read(&mut start(step), &unknowns));
    assert!(exact.iter().any(|value| *value != 0.0));
}

#[test]
fn derivatives_at_start_match_those_of_initialisation() {
    let directions = [[1.0, 0.3, -0.7], [-0.2, 1.0, 0.4]];
    for (case, direction) in CASES.iter().flat_map(|case| directions.iter().map(|one| (*case, one))) {
        check_start::<PlantModel>(case, &[0.5, -0.3, 0.2, 0.4], direction, |_| {});
        check_start::<ClosedLoop>(case, &[0.31, -0.27, 0.23, 0.4], direction, |_| {});
        check_start::<ClosedLoop>(case, &[0.31, -0.27, 0.23, 0.4], direction, |instance| {
            let manual = instance.table().reference("manual").unwrap();
            instance.set(&[manual], |_| true).unwrap();
        });
    }
}

/// The slopes of the trims differ on either side of a row of their table, and vanish beyond its ends.
#[test]
fn derivatives_at_a_trim_row_are_right_sided() {
    let mut instance = LPV.instance::<PlantModel>(Interface::ModelExchange);
    instance.exit_initialization(&mut Silent).unwrap();
    let reference = |name: &str| instance.table().reference(name).unwrap();
    let (speed, rate) = (reference("operating_speed"), reference("der(surge_over_ground)"));
    let mut slope_at = |at: f64| {
        let mut value = |speed_now: f64| {
            instance.set(&[speed], |_| speed_now).unwrap();
            read(&mut instance, &[rate])[0]
        };
        let step = 1e-6;
        let (above, below, here) = (value(at + step), value(at - step), value(at));
        let mut exact = [f64::NAN];
        instance.directional_derivative(&[rate], &[speed], &[1.0], &mut exact, &mut Silent).unwrap();
        (exact[0], (above - here) / step, (here - below) / step)
    };
    for row in [0.5, 1.75, 3.0] {
        let (exact, right, left) = slope_at(row);
        assert!((exact - right).abs() < 1e-6, "at {row} m/s {exact}, and {right}");
        assert!((right - left).abs() > 1e-4, "at {row} m/s {right} and {left}");
    }
}

/// Returns inputs near level flight at the centre of the speeds, away from the breakpoints of the trim table.
fn at_inputs(inputs: &[(u32, f64, f64)], offsets: &[f64]) -> Vec<f64> {
    let point = inputs.iter().zip(offsets).map(|((_, start, nominal), offset)| match *nominal {
        1.0 => off_breakpoint(start + 0.45 * offset),
        _ => start + 0.045 * offset,
    });
    point.collect()
}

/// Shifts a speed away from the breakpoints of the trim table, which are about 0.1 m/s apart.
fn off_breakpoint(speed: f64) -> f64 {
    let trims =
        describe::<Controller>(&resources()).unwrap().model.axes()[0].design().trim.forward_speed.clone();
    let near = trims.into_iter().find(|corner| (corner - speed).abs() < 1e-3);
    near.map_or(speed, |corner| corner + 2e-3)
}

#[test]
fn rejects_derivatives_by_parameters() {
    let mut instance = instance::<PlantModel>(Interface::CoSimulation);
    let reference = |name: &str| described::<PlantModel>().position(name).unwrap() as u32;
    let (pitch, mass) = (reference("pitch"), reference("mass"));
    let refused = instance.directional_derivative(&[pitch], &[mass], &[1.0], &mut [0.0], &mut Silent);
    assert!(matches!(refused, Err(Failure::Refused(Refusal::ByParameter { name })) if name == "mass"));
}
