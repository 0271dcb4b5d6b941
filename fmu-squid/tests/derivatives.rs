//! Directional derivatives and derivatives of outputs by time, against differences.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod example;

use example::{resources, without_lag};
use fmi2::model_description::{Causality, Kind, ModelDescription};
use fmi2::{Described, Experiment, Instance, Interface, Model, Resources, Silent, describe};
use fmu_controller::Controller;
use fmu_plant::PlantModel;
use fmu_squid::ClosedLoop;
use proptest::prelude::*;

/// Which files, and which equations of motion by their number.
#[derive(Clone, Copy)]
struct Case {
    resources: fn() -> Resources,
    fidelity: i32,
}

const SQUID: Case = Case { resources, fidelity: 1 };
const LPV: Case = Case { resources, fidelity: 2 };
const WITHOUT_LAG: Case = Case { resources: without_lag, fidelity: 1 };
const CASES: [Case; 3] = [SQUID, LPV, WITHOUT_LAG];

impl Case {
    fn describe<M: Model>(self) -> Described<M> {
        describe(&(self.resources)()).unwrap()
    }

    /// An instance in initialization mode.
    fn instance<M: Model>(self, interface: Interface) -> Instance<M> {
        let mut instance = Instance::made_for(interface, self.describe::<M>());
        instance.set_up(Experiment::default()).unwrap();
        if let Some(fidelity) = instance.table().reference("fidelity") {
            instance.set(&[fidelity], |_| self.fidelity).unwrap();
        }
        instance.enter_initialization().unwrap();
        instance
    }
}

fn described<M: Model>() -> ModelDescription {
    SQUID.describe::<M>().description
}

fn instance<M: Model>(interface: Interface) -> Instance<M> {
    SQUID.instance(interface)
}

fn real_of(description: &ModelDescription, causality: Causality) -> Vec<(u32, f64, f64)> {
    let all = description.variables.iter().filter(|one| one.causality == causality);
    let number = |one: &fmi2::model_description::ScalarVariable| match one.kind {
        Kind::Real { start, nominal, .. } => {
            Some((one.value_reference, start.unwrap_or(0.0), nominal.unwrap_or(1.0)))
        }
        _ => None,
    };
    all.filter_map(number).collect()
}

fn references(signals: &[(u32, f64, f64)]) -> Vec<u32> {
    signals.iter().map(|one| one.0).collect()
}

fn read<M: Model>(instance: &mut Instance<M>, references: &[u32]) -> Vec<f64> {
    let mut values = Vec::new();
    instance.get(references, &mut Silent, |_, value: f64| values.push(value)).unwrap();
    values
}

fn write<M: Model>(instance: &mut Instance<M>, references: &[u32], values: &[f64]) {
    instance.set(references, |position| values[position]).unwrap();
}

/// Asserts that derivatives are the differences of `value` on both sides, relative to the size of what is compared.
fn assert_slopes(names: &[&str], exact: &[f64], size: &[f64], step: f64, value: impl Fn(f64) -> Vec<f64>) {
    let (above, below) = (value(step), value(-step));
    for (position, name) in names.iter().enumerate() {
        let slope = (above[position] - below[position]) / (2.0 * step);
        let tolerance = 1e-5 * (exact[position].abs() + size[position]);
        assert!((slope - exact[position]).abs() < tolerance, "{name}: {} and {slope}", exact[position]);
    }
}

/// Rates and outputs of a model under its own states and inputs, in continuous-time mode, along a direction.
fn hold_in_continuous_time<M: Model>(case: Case, offsets: &[f64], direction: &[f64]) {
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
    let rates = description.structure().derivatives.into_iter().map(|one| one.index as u32 - 1);
    let unknowns: Vec<u32> = rates.chain(references(&real_of(&description, Causality::Output))).collect();
    let names: Vec<&str> =
        unknowns.iter().map(|&one| description.variables[one as usize].name.as_str()).collect();
    let values = |step: f64| {
        let mut moved = Instance::<M>::made_for(Interface::ModelExchange, case.describe());
        moved.restore(&instance.snapshot().unwrap()).unwrap();
        let along = |at: &[f64], by: &[f64]| -> Vec<f64> {
            at.iter().zip(by).map(|(at, by)| at + step * by).collect()
        };
        write(&mut moved, &input_references, &along(&at_inputs, along_inputs));
        moved.set_continuous_states(&along(&at_states, along_states)).unwrap();
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
    fn of_the_plant(
        offsets in prop::collection::vec(0.1..1.0, 17),
        direction in prop::collection::vec(-1.0..1.0, 13),
    ) {
        CASES.iter().for_each(|case| hold_in_continuous_time::<PlantModel>(*case, &offsets, &direction));
    }

    #[test]
    fn of_the_loop(
        offsets in prop::collection::vec(0.1..1.0, 17),
        direction in prop::collection::vec(-1.0..1.0, 13),
    ) {
        CASES.iter().for_each(|case| hold_in_continuous_time::<ClosedLoop>(*case, &offsets, &direction));
    }

    /// The first outputs by the inputs, in initialization mode, by setting and getting.
    #[test]
    fn of_the_controllers_first_outputs(
        at in prop::collection::vec(-1.0..1.0, 4),
        direction in prop::collection::vec(-1.0..1.0, 4),
    ) {
        let description = described::<Controller>();
        let (inputs, outputs) = (
            real_of(&description, Causality::Input),
            references(&real_of(&description, Causality::Output)),
        );
        let place = at_inputs(&inputs, &at);
        let seed: Vec<f64> = direction.iter().zip([0.1, 1.0, 0.1, 1.0]).map(|(by, size)| by * size).collect();
        let mut now = instance::<Controller>(Interface::CoSimulation);
        write(&mut now, &references(&inputs), &place);
        let mut exact = vec![0.0; outputs.len()];
        now.directional_derivative(&outputs, &references(&inputs), &seed, &mut exact, &mut Silent).unwrap();
        let values = |step: f64| {
            let mut moved = instance::<Controller>(Interface::CoSimulation);
            let at: Vec<f64> = place.iter().zip(&seed).map(|(at, by)| at + step * by).collect();
            write(&mut moved, &references(&inputs), &at);
            read(&mut moved, &outputs)
        };
        let names: Vec<String> = outputs.iter().map(|one| format!("output {one}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert_slopes(&names, &exact, &vec![1.0; outputs.len()], 1e-6, values);
    }

    /// In a flight: the commands of the tick that the next step begins with, by setting, stepping and getting.
    #[test]
    fn of_the_controllers_next_tick(
        at in prop::collection::vec(-1.0..1.0, 4),
        direction in prop::collection::vec(-1.0..1.0, 4),
        ticks in 0..20,
    ) {
        let description = described::<Controller>();
        let (inputs, outputs) = (
            real_of(&description, Causality::Input),
            references(&real_of(&description, Causality::Output)),
        );
        let (sample_time, place) = (0.02, at_inputs(&inputs, &at));
        let seed: Vec<f64> = direction.iter().zip([0.1, 1.0, 0.1, 1.0]).map(|(by, size)| by * size).collect();
        let mut now = instance::<Controller>(Interface::CoSimulation);
        now.exit_initialization(&mut Silent).unwrap();
        write(&mut now, &references(&inputs), &place);
        for _ in 0..ticks {
            now.step(now.time(), sample_time, &mut Silent).unwrap();
        }
        let before = now.snapshot().unwrap();
        let mut exact = vec![0.0; outputs.len()];
        now.directional_derivative(&outputs, &references(&inputs), &seed, &mut exact, &mut Silent).unwrap();
        let values = |step: f64| {
            let mut moved = instance::<Controller>(Interface::CoSimulation);
            moved.restore(&before).unwrap();
            let at: Vec<f64> = place.iter().zip(&seed).map(|(at, by)| at + step * by).collect();
            write(&mut moved, &references(&inputs), &at);
            moved.step(moved.time(), 1e-3, &mut Silent).unwrap();
            read(&mut moved, &outputs)
        };
        let names: Vec<String> = outputs.iter().map(|one| format!("output {one}")).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        assert_slopes(&names, &exact, &vec![1.0; outputs.len()], 1e-6, values);
        now.step(now.time(), 1e-3, &mut Silent).unwrap();
        now.directional_derivative(&outputs, &references(&inputs), &seed, &mut exact, &mut Silent).unwrap();
        assert!(exact.iter().all(|value| *value == 0.0), "no tick is due now");
    }
}

/// First outputs and rates by the inputs, in initialization mode, by setting and getting.
fn hold_at_the_start<M: Model>(
    case: Case,
    offsets: &[f64],
    direction: &[f64],
    prepare: fn(&mut Instance<M>),
) {
    let description = case.describe::<M>().description;
    let inputs = real_of(&description, Causality::Input);
    let offset = |(&(_, start, nominal), by): (&(u32, f64, f64), &f64)| start + 0.1 * nominal * by;
    let place: Vec<f64> = inputs.iter().zip(offsets.iter().cycle()).map(offset).collect();
    let seed: Vec<f64> =
        inputs.iter().zip(direction.iter().cycle()).map(|(one, along)| 0.1 * one.2 * along).collect();
    let rates = description.structure().derivatives.into_iter().map(|one| one.index as u32 - 1);
    let unknowns: Vec<u32> = rates.chain(references(&real_of(&description, Causality::Output))).collect();
    let names: Vec<&str> =
        unknowns.iter().map(|&one| description.variables[one as usize].name.as_str()).collect();
    let start = |step: f64| {
        let mut instance = case.instance::<M>(Interface::CoSimulation);
        prepare(&mut instance);
        let at: Vec<f64> = place.iter().zip(&seed).map(|(at, by)| at + step * by).collect();
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
fn at_the_start_they_are_those_of_the_initialisation() {
    let directions = [[1.0, 0.3, -0.7], [-0.2, 1.0, 0.4]];
    for (case, direction) in CASES.iter().flat_map(|case| directions.iter().map(|one| (*case, one))) {
        hold_at_the_start::<PlantModel>(case, &[0.5, -0.3, 0.2, 0.4], direction, |_| {});
        hold_at_the_start::<ClosedLoop>(case, &[0.31, -0.27, 0.23, 0.4], direction, |_| {});
        hold_at_the_start::<ClosedLoop>(case, &[0.31, -0.27, 0.23, 0.4], direction, |instance| {
            let manual = instance.table().reference("manual").unwrap();
            instance.set(&[manual], |_| true).unwrap();
        });
    }
}

/// The slopes of the trims differ on either side of a row of their table, and beyond it there are none.
#[test]
fn at_a_row_of_the_trim_table_they_are_those_to_the_right() {
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

/// Inputs near level flight in the middle of the speeds, off the corners of the trim table.
fn at_inputs(inputs: &[(u32, f64, f64)], offsets: &[f64]) -> Vec<f64> {
    let size = [0.05, 0.5, 0.05, 0.5];
    let place = inputs.iter().zip(offsets).zip(size).map(|((one, offset), size)| one.1 + 0.9 * size * offset);
    place.enumerate().map(|(i, value)| if i % 2 == 1 { off_corner(value) } else { value }).collect()
}

/// The trim table of the example has a corner every 0.1 m/s or so; its speeds along the body are a little less.
fn off_corner(speed: f64) -> f64 {
    let trims = describe::<Controller>(&resources()).unwrap().model.design().trim.forward_speed.clone();
    let near = trims.into_iter().find(|corner| (corner - speed).abs() < 1e-3);
    near.map_or(speed, |corner| corner + 2e-3)
}

fn outputs_move_as_told<M: Model>(case: Case) {
    let description = case.describe::<M>().description;
    let mut instance = case.instance::<M>(Interface::CoSimulation);
    instance.exit_initialization(&mut Silent).unwrap();
    let inputs = real_of(&description, Causality::Input);
    let outputs = references(&real_of(&description, Causality::Output));
    for (position, &(reference, start, nominal)) in inputs.iter().enumerate() {
        instance.set(&[reference], |_| start + 0.05 * (position as f64 + 1.0) * nominal).unwrap();
    }
    for _ in 0..123 {
        instance.step(instance.time(), 0.0171, &mut Silent).unwrap();
    }
    let mut told = vec![0.0; outputs.len()];
    instance.output_derivatives(&outputs, &vec![1; outputs.len()], &mut told, &mut Silent).unwrap();
    let before = read(&mut instance, &outputs);
    let h = 1e-6;
    instance.step(instance.time(), h, &mut Silent).unwrap();
    let after = read(&mut instance, &outputs);
    for (position, told) in told.iter().enumerate() {
        let found = (after[position] - before[position]) / h;
        let name = &description.variables[outputs[position] as usize].name;
        assert!((found - told).abs() < 1e-4 * (1.0 + told.abs()), "{name}: {told} and {found}");
    }
    assert!(told.iter().filter(|value| **value != 0.0).count() > 5);
    let refused = instance.output_derivatives(&outputs[..1], &[2], &mut [0.0], &mut Silent);
    assert!(refused.unwrap_err().to_string().contains("order 2"));
}

/// An input on a ramp moves the outputs that it reaches at once, both by what it is and by its rate.
#[test]
fn on_a_ramp_outputs_move_as_their_derivatives_say() {
    let description = described::<PlantModel>();
    let mut instance = instance::<PlantModel>(Interface::CoSimulation);
    instance.exit_initialization(&mut Silent).unwrap();
    let current = description.position("current_horizontal").unwrap() as u32;
    let outputs = references(&real_of(&description, Causality::Output));
    let orders = vec![1; outputs.len()];
    let ramp = |instance: &mut Instance<PlantModel>, size: f64| {
        instance.set_input_derivatives(&[current], &[1], &[0.1]).unwrap();
        instance.step(instance.time(), size, &mut Silent).unwrap();
    };
    (0..10).for_each(|_| ramp(&mut instance, 0.1));
    let state = instance.snapshot().unwrap();
    let bytes = instance.serialise(&state).unwrap();
    let mut told = vec![0.0; outputs.len()];
    instance.output_derivatives(&outputs, &orders, &mut told, &mut Silent).unwrap();
    let (h, before) = (1e-6, read(&mut instance, &outputs));
    ramp(&mut instance, h);
    let speed = description.position("speed").unwrap() as u32;
    for ((output, after), (before, told)) in
        outputs.iter().zip(read(&mut instance, &outputs)).zip(before.iter().zip(&told))
    {
        let found = (after - before) / h;
        assert!((found - told).abs() < 1e-4 * (1.0 + told.abs()), "{output}: {told} and {found}");
        assert!(*output != speed || *told < -0.05, "the water comes faster and faster: {told}");
    }
    // The rates are part of the state, also of one that went through bytes; a step without them ends them.
    let mut again = vec![0.0; outputs.len()];
    instance.restore(&instance.deserialise(&bytes).unwrap()).unwrap();
    instance.output_derivatives(&outputs, &orders, &mut again, &mut Silent).unwrap();
    assert_eq!(again, told);
    instance.step(instance.time(), h, &mut Silent).unwrap();
    instance.output_derivatives(&outputs, &orders, &mut again, &mut Silent).unwrap();
    let position = outputs.iter().position(|output| *output == speed).unwrap();
    assert!((again[position] - told[position] - 0.1).abs() < 1e-2, "{again:?}");
}

#[test]
fn outputs_move_as_their_derivatives_say() {
    for case in CASES {
        outputs_move_as_told::<PlantModel>(case);
        outputs_move_as_told::<ClosedLoop>(case);
    }
}

#[test]
fn parameters_are_no_knowns() {
    let mut instance = instance::<PlantModel>(Interface::CoSimulation);
    let reference = |name: &str| described::<PlantModel>().position(name).unwrap() as u32;
    let (pitch, mass) = (reference("pitch"), reference("mass"));
    let refused = instance.directional_derivative(&[pitch], &[mass], &[1.0], &mut [0.0], &mut Silent);
    assert!(refused.unwrap_err().to_string().contains("such as 'mass', are not computed"));
}
