//! Time derivatives of outputs, compared with differences over short steps.

use crate::case::*;
use squid_fmi2::model_description::Causality;
use squid_fmi2::{Failure, Instance, Interface, Model, Refusal, Silent};
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

fn check_output_derivatives<M: Model>(case: Case) {
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
    let mut stated = vec![0.0; outputs.len()];
    instance.output_derivatives(&outputs, &vec![1; outputs.len()], &mut stated, &mut Silent).unwrap();
    let before = read(&mut instance, &outputs);
    let h = 1e-6;
    instance.step(instance.time(), h, &mut Silent).unwrap();
    let after = read(&mut instance, &outputs);
    for (position, stated) in stated.iter().enumerate() {
        let found = (after[position] - before[position]) / h;
        let name = &description.variables[outputs[position] as usize].name;
        assert!((found - stated).abs() < 1e-4 * (1.0 + stated.abs()), "{name}: {stated} and {found}");
    }
    assert!(stated.iter().filter(|value| **value != 0.0).count() > 5);
    let refused = instance.output_derivatives(&outputs[..1], &[2], &mut [0.0], &mut Silent);
    assert!(matches!(refused, Err(Failure::Refused(Refusal::BadOrder { order: 2, .. }))));
}

/// A ramped input changes outputs with direct feedthrough, both by its value and by its rate.
#[test]
fn ramped_outputs_match_their_derivatives() {
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
    let mut stated = vec![0.0; outputs.len()];
    instance.output_derivatives(&outputs, &orders, &mut stated, &mut Silent).unwrap();
    let (h, before) = (1e-6, read(&mut instance, &outputs));
    ramp(&mut instance, h);
    let speed = description.position("speed").unwrap() as u32;
    for ((output, after), (before, stated)) in
        outputs.iter().zip(read(&mut instance, &outputs)).zip(before.iter().zip(&stated))
    {
        let found = (after - before) / h;
        assert!((found - stated).abs() < 1e-4 * (1.0 + stated.abs()), "{output}: {stated} and {found}");
        assert!(*output != speed || *stated < -0.05, "the water comes faster and faster: {stated}");
    }
    // The rates are part of the saved state, serialised or not; a step without rates resets them.
    let mut again = vec![0.0; outputs.len()];
    instance.restore(&instance.deserialise(&bytes).unwrap()).unwrap();
    instance.output_derivatives(&outputs, &orders, &mut again, &mut Silent).unwrap();
    assert_eq!(again, stated);
    instance.step(instance.time(), h, &mut Silent).unwrap();
    instance.output_derivatives(&outputs, &orders, &mut again, &mut Silent).unwrap();
    let position = outputs.iter().position(|output| *output == speed).unwrap();
    assert!((again[position] - stated[position] - 0.1).abs() < 1e-2, "{again:?}");
}

#[test]
fn outputs_match_their_derivatives() {
    for case in CASES {
        check_output_derivatives::<PlantModel>(case);
        check_output_derivatives::<ClosedLoop>(case);
    }
}
