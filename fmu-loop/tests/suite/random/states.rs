//! Random changes of serialised states: an accidental change is refused by the checksum; a change with a valid checksum
//! is refused with a message or simulated, without a panic or an endless loop. `PROPTEST_CASES` and
//! `SQUID_FUZZ_MINUTES` extend the run; `corpus` stores cases with outcomes that were new when found.

use std::ptr::null_mut;

use super::fuzz;
use super::fuzz::{Case, Seen, kind_of};
use crate::abi::{Unpacked, do_step, free, own_defects, texts};
use crate::example;
use proptest::prelude::*;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use squid_fmi2::abi::{Component, EventInfo, Status, exchange, lifecycle, state};
use squid_fmi2::{Interface, Model};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

/// Number of bytes of header and checksum.
const HEAD: usize = 52;
const CHECKSUM: usize = 32;

/// A change of the content.
#[derive(Debug, Clone, Serialize, Deserialize)]
enum Change {
    /// Changes a byte.
    Byte(usize, u8),
    /// Replaces eight bytes, starting where a number may begin, by those of a real number.
    Real(usize, #[serde(with = "fuzz::reals")] Vec<f64>),
    /// Replaces eight bytes likewise by those of an integer.
    Whole(usize, u64),
    /// Truncates the content to a number of bytes.
    Cut(usize),
}

fn change() -> impl Strategy<Value = Change> {
    let special = vec![0.0, -0.0, 1.0, -1.0, 1e-300, 1e300, f64::MAX, -1e18, 1e18, f64::NAN, f64::INFINITY];
    let real = prop_oneof![prop::sample::select(special), prop::num::f64::ANY, -10.0..10.0];
    let whole =
        prop_oneof![prop::sample::select(vec![0, 1, u64::MAX, 1 << 53, 1 << 63]), any::<u64>(), 0..9u64];
    prop_oneof![
        2 => (any::<usize>(), any::<u8>()).prop_map(|(at, to)| Change::Byte(at, to)),
        6 => (any::<usize>(), real).prop_map(|(at, to)| Change::Real(at, vec![to])),
        2 => (any::<usize>(), whole).prop_map(|(at, to)| Change::Whole(at, to)),
        1 => any::<usize>().prop_map(Change::Cut),
    ]
}

fn apply(content: &mut Vec<u8>, change: &Change) {
    if content.len() < 8 {
        return;
    }
    let eight = |at: usize| at % (content.len() - 7);
    let (at, bytes) = match change {
        Change::Byte(at, to) => (at % content.len(), vec![*to]),
        Change::Real(at, to) => (eight(*at), to[0].to_le_bytes().to_vec()),
        Change::Whole(at, to) => (eight(*at), to.to_le_bytes().to_vec()),
        Change::Cut(at) => return content.truncate(at % content.len()),
    };
    content[at..at + bytes.len()].copy_from_slice(&bytes);
}

/// A state saved after a number of steps, with changes.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Changed {
    steps: u8,
    exchange: bool,
    changes: Vec<Change>,
}

impl Case for Changed {
    fn fresh() -> BoxedStrategy<Self> {
        let changes = prop::collection::vec(change(), 1..4);
        (0..4u8, any::<bool>(), changes)
            .prop_map(|(steps, exchange, changes)| Self { steps, exchange, changes })
            .boxed()
    }

    fn grown(mut self, by: Self, at: usize) -> Self {
        self.changes.truncate(1 + at % self.changes.len());
        self.changes.extend(by.changes);
        self
    }

    fn simpler(&self) -> Vec<Self> {
        let without = |left_out: usize| {
            let mut simpler = self.clone();
            simpler.changes.remove(left_out);
            simpler
        };
        (0..self.changes.len()).map(without).filter(|one| !one.changes.is_empty()).collect()
    }
}

fn serialised<M: Model>(c: Component) -> Vec<u8> {
    let (mut stored, mut size) = (null_mut(), 0);
    unsafe {
        assert_eq!(state::get_fmu_state::<M>(c, &mut stored), Status::Ok);
        assert_eq!(state::serialized_fmu_state_size::<M>(c, stored, &mut size), Status::Ok);
        let mut bytes = vec![0u8; size];
        assert_eq!(state::serialize_fmu_state::<M>(c, stored, bytes.as_mut_ptr(), size), Status::Ok);
        assert_eq!(state::free_fmu_state::<M>(c, &mut stored), Status::Ok);
        bytes
    }
}

/// Restores an instance from these bytes; returns `false` if they are refused.
fn restored<M: Model>(c: Component, bytes: &[u8]) -> bool {
    let mut read = null_mut();
    unsafe {
        let status = state::deserialize_fmu_state::<M>(c, bytes.as_ptr(), bytes.len(), &mut read);
        assert_eq!(read.is_null(), status != Status::Ok);
        if read.is_null() {
            return false;
        }
        assert_eq!(state::set_fmu_state::<M>(c, read), Status::Ok);
        assert_eq!(state::free_fmu_state::<M>(c, &mut read), Status::Ok);
    }
    true
}

/// Returns the state with changed content, under the old checksum and under a valid one.
fn changed(bytes: &[u8], changes: &[Change]) -> [Vec<u8>; 2] {
    let (head, body) = bytes.split_at(HEAD);
    let (content, checksum) = body.split_at(body.len() - CHECKSUM);
    let mut content = content.to_vec();
    changes.iter().for_each(|one| apply(&mut content, one));
    let mut sealed = [&head[..HEAD - 8], &(content.len() as u64).to_le_bytes()[..], &content].concat();
    let damaged = [&sealed, checksum].concat();
    let fitting: [u8; CHECKSUM] = Sha256::digest(&sealed).into();
    sealed.extend(fitting);
    [damaged, sealed]
}

/// Continues from any state, and calls all functions.
fn go_on<M: Model>(c: Component, interface: Interface, at: f64) {
    let mut numbers = [0.0; 9];
    let mut event = EventInfo::default();
    unsafe {
        lifecycle::exit_initialization_mode::<M>(c);
        for reference in 0..100 {
            crate::abi::get::<M>(c, &[reference], &mut numbers[..1]);
        }
        if interface == Interface::CoSimulation {
            do_step::<M>(c, at, 0.02);
            do_step::<M>(c, at + 0.02, 0.05);
            return;
        }
        exchange::new_discrete_states::<M>(c, &mut event);
        exchange::enter_continuous_time_mode::<M>(c);
        exchange::get_continuous_states::<M>(c, numbers.as_mut_ptr(), 9);
        exchange::get_derivatives::<M>(c, numbers.as_mut_ptr(), 9);
        exchange::set_time::<M>(c, at + 0.02);
        exchange::enter_event_mode::<M>(c);
        exchange::new_discrete_states::<M>(c, &mut event);
    }
}

fn survives<M: Model>(fmu: &Unpacked<M>, case: &Changed) -> Seen {
    let exchange = case.exchange && M::MODEL_EXCHANGE;
    let interface = if exchange { Interface::ModelExchange } else { Interface::CoSimulation };
    let c = fmu.started(interface);
    for k in (0..case.steps).filter(|_| !exchange) {
        assert_eq!(do_step::<M>(c, f64::from(k) * 0.02, 0.02), Status::Ok);
    }
    let whole = serialised::<M>(c);
    let [damaged, sealed] = changed(&whole, &case.changes);
    assert!(damaged == whole || !restored::<M>(c, &damaged), "a damaged state is refused");
    texts();
    let mut seen = Seen::new();
    if restored::<M>(c, &sealed) {
        seen.insert("accepted".to_owned());
        go_on::<M>(c, interface, f64::from(case.steps) * 0.02);
        assert!(restored::<M>(c, &whole), "the instance is as usable as before");
    }
    free::<M>(c);
    assert_eq!(own_defects(), 0, "{case:?}");
    seen.extend(texts().iter().map(|text| kind_of(text)));
    seen
}

fn tried<M: Model>(name: &str) {
    let fmus = [example::resources(), example::with_two_degrees()].map(|files| Unpacked::<M>::new(&files));
    fuzz::run(name, |case| fmus.iter().flat_map(|fmu| survives(fmu, case)).collect());
}

#[test]
fn plant_restores_or_refuses_changed_states() {
    tried::<PlantModel>("plant_states");
}

#[test]
fn controller_restores_or_refuses_changed_states() {
    tried::<Controller>("controller_states");
}

#[test]
fn loop_restores_or_refuses_changed_states() {
    tried::<ClosedLoop>("squid_states");
}
