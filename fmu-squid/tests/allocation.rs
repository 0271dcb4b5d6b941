//! Exchange and step allocate nothing.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod example;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use fmi2::Silent;

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
    let mut flight = example::started(&example::resources());
    let table = flight.instance.table();
    let references = ["pitch", "lower", "tracking_error"].map(|name| table.reference(name).unwrap());
    let current = [table.reference("current_vertical").unwrap()];
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    let mut sum = 0.0;
    for k in 0..1000 {
        flight.instance.set(&current, |_| 1e-3 * f64::from(k % 7)).unwrap();
        flight.instance.step(f64::from(k) * 0.03, 0.03, &mut Silent).unwrap();
        flight.instance.get(&references, &mut Silent, |_, value: f64| sum += value).unwrap();
    }
    assert_eq!(ALLOCATIONS.load(Ordering::Relaxed) - before, 0);
    assert!(sum != 0.0 && before > 0, "the allocator counts");
}
