//! No step of the plant allocates: counted by the allocator itself.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use auv::Fidelity;
use fmi2::{Model, Silent};
use fmu_plant::PlantModel;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call goes to the system's allocator unchanged.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|count| count.set(count.get() + 1));
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn stepping_does_not_allocate() {
    let allocations = || ALLOCATIONS.with(Cell::get);
    let before = allocations();
    drop(std::hint::black_box(vec![1]));
    assert_eq!(allocations(), before + 1, "the allocator counts");

    for fidelity in [Fidelity::Nonlinear, Fidelity::Lpv] {
        let mut plant = PlantModel::load(&common::squid()).unwrap();
        plant.settings.fidelity = fidelity;
        plant.initialise(0.0, &mut Silent).unwrap();
        let before = allocations();
        for k in 1..=1000 {
            let time = f64::from(k) * 0.01;
            plant.inputs.commands[0] = 15.0 + time;
            plant.inputs.operating_speed = 1.75 + 0.1 * time;
            plant.inputs.current.horizontal = 0.2 * time.sin();
            plant.step(time - 0.01, time, &mut Silent).unwrap();
        }
        assert_eq!(allocations(), before, "{fidelity:?}");
        assert!(
            (plant.state().motion.theta - plant.trim().pitch).abs() > 0.01,
            "the vehicle must have moved"
        );
    }
}
