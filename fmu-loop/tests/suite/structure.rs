//! `ModelStructure` is correct: an unknown does not depend on variables missing from its dependencies.

use crate::case::*;
use squid_fmi2::model_description::{Causality, Initial, Kind, ModelDescription, ScalarVariable, Unknown};
use squid_fmi2::{Failure, Instance, Interface, Model, Refusal, Silent};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

/// Cases with different dependencies.
const CASES: [Case; 8] = [SQUID, WITHOUT_LAG, TWO_DEGREES, CURVED, GIVEN, TURNING, WAVES, TURNING_WAVES];

fn is_real(variable: &ScalarVariable) -> bool {
    matches!(variable.kind, Kind::Real { .. })
}

/// Returns the Real unknowns of a list that state their dependencies, with these.
fn named(description: &ModelDescription, list: &[Unknown]) -> Vec<(u32, Vec<u32>)> {
    let real = list.iter().filter(|unknown| is_real(&description.variables[unknown.index - 1]));
    let reference = |index: usize| description.variables[index - 1].value_reference;
    real.filter_map(|unknown| {
        let on = unknown.dependencies.as_ref()?;
        Some((reference(unknown.index), on.iter().map(|(index, _)| reference(*index)).collect()))
    })
    .collect()
}

/// Asserts that the derivative of every unknown with respect to every known missing from its dependencies is zero, and
/// that some of the others are not.
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
    references(&real_of(description, Causality::Input))
}

fn derivatives_agree<M: Model>(case: Case, interface: Interface, prepare: fn(&mut Instance<M>)) {
    let description = case.describe::<M>().description;
    let structure = description.structure();
    let mut instance = case.set_up::<M>(interface);
    prepare(&mut instance);
    instance.enter_initialization().unwrap();
    let mut knowns = inputs(&description);
    holds(&mut instance, &named(&description, &structure.initial_unknowns), &knowns);
    instance.exit_initialization(&mut Silent).unwrap();
    knowns.extend(instance.table().states());
    let lists = [structure.outputs, structure.derivatives].concat();
    // A tick is due at the start; the inputs of the controller act in that tick, during the following step.
    if M::MODEL_EXCHANGE {
        holds(&mut instance, &named(&description, &lists), &knowns);
    }
}

#[test]
fn derivatives_vanish_where_no_dependency_is_listed() {
    let by_hand = |instance: &mut Instance<ClosedLoop>| {
        let manual = instance.table().reference("manual").unwrap();
        instance.set(&[manual], |_| true).unwrap();
    };
    let by_lpv_model = |instance: &mut Instance<PlantModel>| {
        if let Some(fidelity) = instance.table().reference("fidelity") {
            instance.set(&[fidelity], |_| 2).unwrap();
        }
    };
    for case in CASES {
        derivatives_agree::<PlantModel>(case, Interface::ModelExchange, by_lpv_model);
        derivatives_agree::<PlantModel>(case, Interface::CoSimulation, |_| {});
        derivatives_agree::<PlantModel>(case, Interface::ModelExchange, |_| {});
        derivatives_agree::<Controller>(case, Interface::CoSimulation, |_| {});
        derivatives_agree::<ClosedLoop>(case, Interface::CoSimulation, by_hand);
        derivatives_agree::<ClosedLoop>(case, Interface::ModelExchange, by_hand);
    }
}

/// Outputs read after setting an input change according to their derivatives, which are zero without a dependency.
fn check_read_values<M: Model>(case: Case, at_least: usize) {
    let description = case.describe::<M>().description;
    let list = named(&description, &description.structure().outputs);
    let unknowns: Vec<u32> = list.iter().map(|(unknown, _)| *unknown).collect();
    let mut instance = case.set_up::<M>(Interface::CoSimulation);
    instance.enter_initialization().unwrap();
    instance.exit_initialization(&mut Silent).unwrap();
    (0..7).for_each(|k| instance.step(f64::from(k) * 0.013, 0.013, &mut Silent).unwrap());
    let state = instance.snapshot().unwrap();
    let mut moved = 0;
    for input in inputs(&description) {
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
fn read_values_depend_on_listed_inputs_only() {
    for case in CASES {
        check_read_values::<PlantModel>(case, 6);
        check_read_values::<ClosedLoop>(case, 6);
        check_read_values::<Controller>(case, 0);
    }
}

fn first_values<M: Model>(case: Case, unknowns: &[u32], changed: Option<(u32, f64)>) -> Option<Vec<f64>> {
    let mut instance = case.set_up::<M>(Interface::CoSimulation);
    if let Some((parameter, value)) = changed {
        instance.set(&[parameter], |_| value).unwrap();
    }
    instance.enter_initialization().unwrap();
    let mut values = vec![f64::NAN; unknowns.len()];
    instance.get(unknowns, &mut Silent, |position, value| values[position] = value).ok()?;
    Some(values)
}

/// An initial value depends on the parameters listed for it, and on no others; derivatives with respect to parameters
/// are refused.
fn check_initial_values<M: Model>(case: Case, at_least: usize) {
    let description = case.describe::<M>().description;
    let list = named(&description, &description.structure().initial_unknowns);
    let unknowns: Vec<u32> = list.iter().map(|(unknown, _)| *unknown).collect();
    let before = first_values::<M>(case, &unknowns, None).unwrap();
    let parameters = description.variables.iter().filter(|one| one.causality == Causality::Parameter);
    let mut acted = 0;
    for parameter in parameters.filter(|one| is_real(one)) {
        assert_eq!(parameter.initial(), Some(Initial::Exact));
        let Kind::Real { start: Some(start), .. } = parameter.kind else {
            panic!("a parameter has a start value")
        };
        let reference = parameter.value_reference;
        let Some(after) = first_values::<M>(case, &unknowns, Some((reference, start * (1.0 + 1e-6)))) else {
            continue;
        };
        for (((unknown, on), before), after) in list.iter().zip(&before).zip(after) {
            assert!(*before == after || on.contains(&reference), "{} moves {unknown}", parameter.name);
            acted += usize::from(*before != after);
        }
        let mut instance = case.set_up::<M>(Interface::CoSimulation);
        instance.enter_initialization().unwrap();
        let refused =
            instance.directional_derivative(&unknowns[..1], &[reference], &[1.0], &mut [0.0], &mut Silent);
        let Err(Failure::Refused(Refusal::ByParameter { name })) = refused else {
            panic!("{}", parameter.name)
        };
        assert_eq!(name, parameter.name);
    }
    assert!(acted >= at_least, "{acted}");
}

#[test]
fn initial_values_depend_on_listed_parameters_only() {
    for case in CASES {
        check_initial_values::<PlantModel>(case, 20);
        check_initial_values::<ClosedLoop>(case, 20);
    }
}

/// The output of an actuator without lag is the current command throughout the lifetime of the instance.
fn check_output_is_command(interface: Interface) {
    let mut instance = WITHOUT_LAG.set_up::<PlantModel>(interface);
    let name = instance.model().vehicle().actuators.last().unwrap().name.clone();
    let reference = |name: &str| instance.table().reference(name).unwrap();
    let (command, output, other) =
        (reference(&name), reference(&format!("{name}_output")), reference("initial_depth"));
    let at = |instance: &mut Instance<PlantModel>| read(instance, &[output])[0];
    instance.set(&[command], |_| 3.5).unwrap();
    instance.enter_initialization().unwrap();
    assert_eq!(at(&mut instance), 3.5);
    instance.set(&[other], |_| 60.0).unwrap();
    assert_eq!(at(&mut instance), 3.5);
    instance.exit_initialization(&mut Silent).unwrap();
    assert_eq!(at(&mut instance), 3.5);
    instance.set(&[command], |_| 2.5).unwrap();
    assert_eq!(at(&mut instance), 2.5);
    instance.set(&[command], |_| 1.5).unwrap();
    instance.terminate().unwrap();
    assert_eq!(at(&mut instance), 1.5);
}

#[test]
fn actuator_without_lag_outputs_its_command() {
    check_output_is_command(Interface::CoSimulation);
    check_output_is_command(Interface::ModelExchange);
}

/// The output of such an actuator in the loop is the command of the first tick from the start.
#[test]
fn loop_actuator_without_lag_outputs_first_command() {
    for interface in [Interface::CoSimulation, Interface::ModelExchange] {
        let mut instance = WITHOUT_LAG.set_up::<ClosedLoop>(interface);
        let name = instance.model().plant.vehicle().actuators.last().unwrap().name.clone();
        let step = instance.table().reference("step_time").unwrap();
        instance.set(&[step], |_| 0.0).unwrap();
        instance.enter_initialization().unwrap();
        instance.exit_initialization(&mut Silent).unwrap();
        let pair = [name.clone(), format!("{name}_output")];
        let pair = pair.map(|name| instance.table().reference(&name).unwrap());
        let found = read(&mut instance, &pair);
        let trim = *instance.model().plant.trim().actuators.last().unwrap();
        assert!(found[0] == found[1] && (found[0] - trim).abs() > 1.0, "{found:?} and {trim}");
    }
}

/// The derivative of pitch is the pitch rate by the equations of motion, and proportional to it by the LPV model.
#[test]
fn derivative_of_pitch_depends_on_pitch_rate() {
    fn knowns_of_rate<M: Model>() -> Vec<String> {
        let description = SQUID.describe::<M>().description;
        let rate = description.position("der(pitch)").unwrap() + 1;
        let listed = description.structure().derivatives.into_iter().find(|one| one.index == rate).unwrap();
        let name = |(index, _): (usize, _)| description.variables[index - 1].name.clone();
        listed.dependencies.unwrap().into_iter().map(name).collect()
    }
    assert_eq!(knowns_of_rate::<PlantModel>(), ["operating_speed", "pitch_rate"]);
    assert_eq!(knowns_of_rate::<ClosedLoop>(), ["pitch_rate"]);
}
