//! Exchange and step allocate nothing.
#![allow(clippy::unwrap_used, missing_docs)]

mod example;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use fmi2::{Experiment, Instance, Resources, Silent};
use fmu_controller::{RESOURCE, describe};

struct Counting;

static ALLOCATIONS: AtomicUsize = AtomicUsize::new(0);

// SAFETY: hands everything on to the system's allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller keeps the contract.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// The only test of this file, so that no other thread allocates meanwhile.
#[test]
fn a_communication_step_allocates_nothing() {
    let resources: Resources = [(RESOURCE, example::design().to_string())].into_iter().collect();
    let mut instance = Instance::new(describe(&resources).unwrap());
    instance.set_up(Experiment::default()).unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization(&mut Silent).unwrap();
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    let mut sum = 0.0;
    for k in 0..1000 {
        instance.set(&[0, 1], |position| [0.01, 1.5][position]).unwrap();
        instance.step(f64::from(k) * 0.02, 0.02, &mut Silent).unwrap();
        instance.get(&[4, 5], &mut Silent, |_, value: f64| sum += value).unwrap();
    }
    assert_eq!(ALLOCATIONS.load(Ordering::Relaxed) - before, 0);
    assert!(sum != 0.0 && before > 0, "the allocator counts");
}
