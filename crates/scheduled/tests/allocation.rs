//! A tick allocates nothing.
#![allow(clippy::unwrap_used, missing_docs)]

mod example;

use allocation_counter::measure;
use squid_scheduled::{Autopilot, ControllerDesign, Inputs};

#[test]
fn tick_allocates_nothing() {
    allocates_nothing(&example::design());
    let mut filtered = example::two_degrees();
    filtered.reference_filter = Some(0.5);
    allocates_nothing(&filtered);
}

fn allocates_nothing(design: &ControllerDesign) {
    let mut autopilot = None;
    let construction = measure(|| autopilot = Autopilot::new(design).ok());
    assert!(construction.count_total > 0, "the allocator counts");
    let mut autopilot = autopilot.unwrap();
    let inputs = Inputs { measured: vec![0.1, 2.2, 0.0, 0.0, 0.0], references: vec![0.2, 2.0, 0.0] };
    autopilot.initialise(0.0, &inputs).unwrap();
    let flight = measure(|| {
        for step in 1..=1000 {
            autopilot.advance(f64::from(step) * 0.02, &inputs).unwrap();
        }
    });
    assert_eq!(flight.count_total, 0);
    assert_eq!(autopilot.ticks(), 1000);
}
