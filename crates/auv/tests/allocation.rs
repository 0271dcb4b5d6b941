//! No step allocates: counted by the allocator itself.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use auv::{Current, Fidelity, LpvModel, Plant, Speed, linearise, trim};

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

fn allocations() -> usize {
    ALLOCATIONS.with(Cell::get)
}

#[test]
fn stepping_does_not_allocate() {
    let before = allocations();
    drop(std::hint::black_box(vec![1]));
    assert_eq!(allocations(), before + 1, "the allocator counts");

    let vehicle = common::squid();
    let trim = trim(&vehicle, Speed::Path(1.0), 50.0).unwrap();
    let linear = linearise(&vehicle, &trim).unwrap();
    let model =
        LpvModel::new("squid", 50.0, (1.75, 1.25), &[linear.a], &[linear.b], std::slice::from_ref(&trim))
            .unwrap();
    let mut plant = Plant::new(&vehicle).unwrap().with_lpv(model).unwrap();
    for fidelity in [Fidelity::Nonlinear, Fidelity::Lpv] {
        plant.set_fidelity(fidelity).unwrap();
        plant.start(0.0, &trim).unwrap();
        let before = allocations();
        for i in 1..=1000 {
            let time = f64::from(i) * 0.01;
            plant.set_command(0, 5.0 + time).unwrap();
            plant.set_operating_speed(1.0 + 0.1 * time).unwrap();
            plant.set_current(Current { horizontal: 0.2 * time.sin(), vertical: 0.0 }).unwrap();
            plant.advance(time).unwrap();
        }
        assert_eq!(allocations(), before, "{fidelity:?}");
        assert!((plant.state().motion.theta - trim.pitch).abs() > 0.01, "the vehicle must have moved");
    }
}
