//! Exchange and step allocate nothing.
#![allow(clippy::unwrap_used, missing_docs)]

mod example;

use allocation_counter::measure;
use fmi2::{Experiment, Instance, Resources, Silent};
use fmu_controller::{RESOURCE, describe};
use serde_json::Value;

#[test]
fn a_communication_step_allocates_nothing() {
    allocates_nothing(&example::design());
    allocates_nothing(&example::with_pitch_rate());
}

fn allocates_nothing(design: &Value) {
    let resources: Resources = [(RESOURCE, design.to_string())].into_iter().collect();
    let mut made = None;
    let making = measure(|| made = describe(&resources).ok());
    assert!(making.count_total > 0, "the allocator counts");
    let mut instance = Instance::new(made.unwrap());
    instance.set_up(Experiment::default()).unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization(&mut Silent).unwrap();
    let commands = ["thruster", "fin"].map(|name| instance.table().reference(name).unwrap());
    let mut sum = 0.0;
    let flight = measure(|| {
        for k in 0..1000 {
            instance.set(&[0, 1], |position| [0.01, 1.5][position]).unwrap();
            instance.step(f64::from(k) * 0.02, 0.02, &mut Silent).unwrap();
            instance.get(&commands, &mut Silent, |_, value: f64| sum += value).unwrap();
        }
    });
    assert_eq!(flight.count_total, 0);
    assert!(sum != 0.0);
}
