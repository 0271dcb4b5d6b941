//! One stored state, restored by instances in several threads.

use std::ptr::null_mut;

use crate::example::Lag;
use crate::importer::*;
use squid_fmi2::abi::{FmuState, Status};

/// Any number of instances may read a state concurrently.
#[test]
fn instances_in_several_threads_restore_one_state() {
    const fn may_be_shared<T: Sync>() {}
    const { may_be_shared::<squid_fmi2::Snapshot<Lag>>() };
    let fmu = unpack();
    let owner = fmu.instantiate(false);
    initialise(owner);
    set(owner, U, 1.0);
    let mut state = null_mut();
    unsafe {
        assert_eq!(fmi2DoStep(owner, 0.0, 0.5, 1), Status::Ok);
        assert_eq!(fmi2GetFMUstate(owner, &mut state), Status::Ok);
    }
    let address = state as usize;
    let values: Vec<f64> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|_| {
                scope.spawn(|| unsafe {
                    let c = fmu.instantiate(false);
                    assert_eq!(fmi2SetFMUstate(c, address as FmuState), Status::Ok);
                    assert_eq!(fmi2DoStep(c, 0.5, 0.5, 1), Status::Ok);
                    let value = real(c, Y);
                    fmi2FreeInstance(c);
                    value
                })
            })
            .collect();
        threads.into_iter().map(|thread| thread.join().unwrap()).collect()
    });
    unsafe {
        assert_eq!(fmi2DoStep(owner, 0.5, 0.5, 1), Status::Ok);
        assert!(values.iter().all(|value| *value == real(owner, Y)));
        fmi2FreeFMUstate(owner, &mut state);
        fmi2FreeInstance(owner);
    }
}
