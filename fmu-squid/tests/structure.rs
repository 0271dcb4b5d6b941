//! `ModelStructure` tells the truth: what is not listed among the dependencies of an unknown does not move it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod example;

use example::resources;
use fmi2::model_description::{Causality, Initial, Kind, ModelDescription, ScalarVariable, Unknown};
use fmi2::{Experiment, Instance, Interface, Model, Silent, describe};
use fmu_controller::Controller;
use fmu_plant::PlantModel;
use fmu_squid::ClosedLoop;

fn instance<M: Model>(interface: Interface) -> Instance<M> {
    let mut instance = Instance::made_for(interface, describe::<M>(&resources()).unwrap());
    instance.set_up(Experiment::default()).unwrap();
    instance
}

fn is_real(variable: &ScalarVariable) -> bool {
    matches!(variable.kind, Kind::Real { .. })
}

/// The Real unknowns of a list that name their dependencies, with those.
fn named(description: &ModelDescription, list: &[Unknown]) -> Vec<(u32, Vec<u32>)> {
    let real = list.iter().filter(|unknown| is_real(&description.variables[unknown.index - 1]));
    let reference = |index: usize| description.variables[index - 1].value_reference;
    real.filter_map(|unknown| {
        let on = unknown.dependencies.as_ref()?;
        Some((reference(unknown.index), on.iter().map(|(index, _)| reference(*index)).collect()))
    })
    .collect()
}

/// Along every known of a list, the derivative of every unknown that does not depend on it is zero; some that do are not.
fn holds<M: Model>(instance: &mut Instance<M>, list: &[(u32, Vec<u32>)], knowns: &[u32]) {
    let mut moved = 0;
    for &known in knowns {
        let unknowns: Vec<u32> = list.iter().map(|(unknown, _)| *unknown).collect();
        let mut slopes = vec![f64::NAN; unknowns.len()];
        instance.directional_derivative(&unknowns, &[known], &[1.0], &mut slopes, &mut Silent).unwrap();
        for ((unknown, on), slope) in list.iter().zip(slopes) {
            assert!(slope == 0.0 || on.contains(&known), "{unknown} by {known}: {slope}");
            moved += usize::from(slope != 0.0);
        }
    }
    assert!(moved > 0 || knowns.is_empty());
}

fn inputs(description: &ModelDescription) -> Vec<u32> {
    let inputs = description.variables.iter().filter(|one| one.causality == Causality::Input && is_real(one));
    inputs.map(|one| one.value_reference).collect()
}

fn derivatives_agree<M: Model>(interface: Interface, prepare: fn(&mut Instance<M>)) {
    let description = describe::<M>(&resources()).unwrap().description;
    let structure = description.structure();
    let mut instance = instance::<M>(interface);
    prepare(&mut instance);
    instance.enter_initialization().unwrap();
    let mut knowns = inputs(&description);
    holds(&mut instance, &named(&description, &structure.initial_unknowns), &knowns);
    instance.exit_initialization(&mut Silent).unwrap();
    knowns.extend(instance.table().states());
    let lists = [structure.outputs, structure.derivatives].concat();
    // At the start a tick is due, in which the inputs of the controller act; they do so in the step that follows.
    if M::continuous().is_some() {
        holds(&mut instance, &named(&description, &lists), &knowns);
    }
}

#[test]
fn derivatives_vanish_where_no_dependency_is_listed() {
    derivatives_agree::<PlantModel>(Interface::CoSimulation, |_| {});
    derivatives_agree::<PlantModel>(Interface::ModelExchange, |_| {});
    derivatives_agree::<Controller>(Interface::CoSimulation, |_| {});
    let by_hand = |instance: &mut Instance<ClosedLoop>| {
        let manual = instance.table().reference("manual").unwrap();
        instance.set(&[manual], |_| true).unwrap();
    };
    derivatives_agree::<ClosedLoop>(Interface::CoSimulation, by_hand);
    derivatives_agree::<ClosedLoop>(Interface::ModelExchange, by_hand);
}

/// In a flight an output that is read after an input was set has moved as the derivative says, which is zero where no dependency is listed.
fn values_move_as_listed<M: Model>(at_least: usize) {
    let description = describe::<M>(&resources()).unwrap().description;
    let list = named(&description, &description.structure().outputs);
    let unknowns: Vec<u32> = list.iter().map(|(unknown, _)| *unknown).collect();
    let mut instance = instance::<M>(Interface::CoSimulation);
    instance.enter_initialization().unwrap();
    instance.exit_initialization(&mut Silent).unwrap();
    (0..7).for_each(|k| instance.step(f64::from(k) * 0.013, 0.013, &mut Silent).unwrap());
    let state = instance.snapshot().unwrap();
    let mut moved = 0;
    for input in inputs(&description) {
        let read = |instance: &mut Instance<M>, reference: &[u32]| {
            let mut values = Vec::new();
            instance.get(reference, &mut Silent, |_, value: f64| values.push(value)).unwrap();
            values
        };
        instance.restore(&state).unwrap();
        let (before, start) = (read(&mut instance, &unknowns), read(&mut instance, &[input])[0]);
        let mut slopes = vec![f64::NAN; unknowns.len()];
        instance.directional_derivative(&unknowns, &[input], &[1.0], &mut slopes, &mut Silent).unwrap();
        let by = 1e-6;
        instance.set(&[input], |_| start + by).unwrap();
        for (position, after) in read(&mut instance, &unknowns).into_iter().enumerate() {
            let change = after - before[position];
            assert!(
                change == 0.0 || list[position].1.contains(&input),
                "{input} moves {}",
                unknowns[position]
            );
            assert!((change / by - slopes[position]).abs() < 1e-5, "{} by {input}", unknowns[position]);
            moved += usize::from(change != 0.0);
        }
    }
    assert!(moved >= at_least, "{moved}");
}

#[test]
fn what_is_read_moves_with_the_inputs_that_are_listed() {
    values_move_as_listed::<PlantModel>(6);
    values_move_as_listed::<ClosedLoop>(6);
    values_move_as_listed::<Controller>(0);
}

fn first_values<M: Model>(unknowns: &[u32], changed: Option<(u32, f64)>) -> Option<Vec<f64>> {
    let mut instance = instance::<M>(Interface::CoSimulation);
    if let Some((parameter, value)) = changed {
        instance.set(&[parameter], |_| value).unwrap();
    }
    instance.enter_initialization().unwrap();
    let mut values = vec![f64::NAN; unknowns.len()];
    instance.get(unknowns, &mut Silent, |position, value| values[position] = value).ok()?;
    Some(values)
}

/// A first value moves with the parameters that it is said to depend on, and with no other; derivatives by them are refused.
fn parameters_act_as_listed<M: Model>(at_least: usize) {
    let description = describe::<M>(&resources()).unwrap().description;
    let list = named(&description, &description.structure().initial_unknowns);
    let unknowns: Vec<u32> = list.iter().map(|(unknown, _)| *unknown).collect();
    let before = first_values::<M>(&unknowns, None).unwrap();
    let parameters = description.variables.iter().filter(|one| one.causality == Causality::Parameter);
    let mut acted = 0;
    for parameter in parameters.filter(|one| is_real(one)) {
        assert_eq!(parameter.initial(), Some(Initial::Exact));
        let Kind::Real { start: Some(start), .. } = parameter.kind else {
            panic!("a parameter has a start value")
        };
        let reference = parameter.value_reference;
        let Some(after) = first_values::<M>(&unknowns, Some((reference, start * (1.0 + 1e-6)))) else {
            continue;
        };
        for (((unknown, on), before), after) in list.iter().zip(&before).zip(after) {
            assert!(*before == after || on.contains(&reference), "{} moves {unknown}", parameter.name);
            acted += usize::from(*before != after);
        }
        let mut instance = instance::<M>(Interface::CoSimulation);
        instance.enter_initialization().unwrap();
        let refused =
            instance.directional_derivative(&unknowns[..1], &[reference], &[1.0], &mut [0.0], &mut Silent);
        let sentence = refused.unwrap_err().to_string();
        assert!(sentence.contains(&format!("such as '{}', are not computed", parameter.name)), "{sentence}");
    }
    assert!(acted >= at_least, "{acted}");
}

#[test]
fn first_values_depend_on_the_parameters_that_are_listed() {
    parameters_act_as_listed::<PlantModel>(20);
    parameters_act_as_listed::<ClosedLoop>(20);
}
