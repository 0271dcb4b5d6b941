//! A tick allocates nothing.
#![allow(clippy::unwrap_used, missing_docs)]

mod example;

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering};

use scheduled::{Autopilot, Inputs};

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
fn a_tick_allocates_nothing() {
    let mut autopilot = Autopilot::new(&example::design()).unwrap();
    let inputs = Inputs { pitch: 0.1, speed: 2.2, pitch_reference: 0.2, speed_reference: 2.0 };
    autopilot.initialise(0.0, &inputs).unwrap();
    let before = ALLOCATIONS.load(Ordering::Relaxed);
    for step in 1..=1000 {
        autopilot.advance(f64::from(step) * 0.02, &inputs).unwrap();
    }
    assert_eq!(ALLOCATIONS.load(Ordering::Relaxed) - before, 0);
    assert_eq!(autopilot.ticks(), 1000);
    assert!(before > 0, "the allocator counts");
}
