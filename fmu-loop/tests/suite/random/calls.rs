//! Random calls with random arguments through the C ABI of each FMU: each returns a status, and none exposes a defect.
//! `PROPTEST_CASES` and `SQUID_FUZZ_MINUTES` extend the run; `corpus` stores cases with outcomes that were new when
//! found.

use std::ffi::{c_char, c_int};
use std::ptr::{null, null_mut};

use super::fuzz;
use super::fuzz::{Case, Seen, kind_of};
use crate::abi::{Unpacked, free, own_defects, texts};
use crate::example;
use proptest::prelude::*;
use serde::{Deserialize, Serialize};
use squid_fmi2::abi::{Component, EventInfo, FmuState, Status, access, exchange, lifecycle, state, step};
use squid_fmi2::{Interface, Model};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

/// One call: function, variables and numbers.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Call {
    function: u8,
    references: Vec<u32>,
    #[serde(with = "fuzz::reals")]
    numbers: Vec<f64>,
    whole: i32,
    /// `true` if a pointer is NULL.
    null: bool,
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -3.0..3.0,
        2 => 0.0..0.2,
        1 => prop::num::f64::ANY,
        1 => prop::sample::select(vec![
            0.0, -0.0, 0.02, 1e-6, 1e-300, 1e6, 1e300, f64::MAX, f64::MIN_POSITIVE, f64::NAN, f64::INFINITY,
            f64::NEG_INFINITY,
        ]),
    ]
}

/// Number of continuous states of the models.
const NUMBERS: usize = 9;

fn call() -> impl Strategy<Value = Call> {
    let references = prop::collection::vec(prop_oneof![9 => 0..110u32, 1 => any::<u32>()], 1..5);
    let numbers = prop::collection::vec(number(), NUMBERS);
    let whole = prop_oneof![4 => -2..5, 1 => any::<i32>()];
    (0..45u8, references, numbers, whole, prop::bool::weighted(0.03)).prop_map(
        |(function, references, numbers, whole, null)| Call { function, references, numbers, whole, null },
    )
}

/// Data that an importer holds besides the instance.
#[derive(Default)]
struct Held {
    time: f64,
    state: Option<FmuState>,
    bytes: Vec<u8>,
}

/// Maps a number to a step size. Long steps are covered by other tests; absurd ones, which are refused, are kept.
fn step_size(number: f64) -> f64 {
    if (0.2..=86_400.0).contains(&number) { 0.2 } else { number }
}

fn make<M: Model>(c: Component, call: &Call, held: &mut Held) -> Status {
    let count = call.references.len();
    let mut reals = call.numbers.clone();
    let mut wholes = [call.whole; 8];
    let references = if call.null { null() } else { call.references.as_ptr() };
    let real = if call.null { null_mut() } else { reals.as_mut_ptr() };
    let whole: *mut c_int = wholes.as_mut_ptr();
    let [first, second] = [call.numbers[0], call.numbers[1]];
    let states = if call.whole.unsigned_abs() < 3 { 9 } else { count };
    unsafe {
        match call.function {
            0 => lifecycle::set_debug_logging::<M>(c, call.whole, 1, &c"logStatusDiscard".as_ptr()),
            1 => lifecycle::setup_experiment::<M>(
                c,
                call.whole,
                second,
                first,
                call.whole & 1,
                call.numbers[2],
            ),
            2..=3 => lifecycle::enter_initialization_mode::<M>(c),
            4..=5 => lifecycle::exit_initialization_mode::<M>(c),
            6 => lifecycle::terminate::<M>(c),
            7 => lifecycle::reset::<M>(c),
            8..=9 => access::get_real::<M>(c, references, count, real),
            10 => access::get_integer::<M>(c, references, count, whole),
            11 => access::get_boolean::<M>(c, references, count, whole),
            12 => access::get_string::<M>(c, references, count, [null::<c_char>(); 8].as_mut_ptr()),
            13..=17 => access::set_real::<M>(c, references, count, real),
            18 => access::set_integer::<M>(c, references, count, whole),
            19 => access::set_boolean::<M>(c, references, count, whole),
            20 => access::set_string::<M>(c, references, count, [c"text".as_ptr(); 8].as_ptr()),
            21..=23 => on_states::<M>(c, call, held),
            24 => {
                let knowns = call.references[count / 2..].as_ptr();
                let others = count - count / 2;
                state::get_directional_derivative::<M>(
                    c,
                    references,
                    count,
                    knowns,
                    others,
                    real,
                    reals.as_mut_ptr(),
                )
            }
            25 => exchange::enter_event_mode::<M>(c),
            26 => exchange::new_discrete_states::<M>(c, &mut EventInfo::default()),
            27 => exchange::enter_continuous_time_mode::<M>(c),
            28 => exchange::completed_integrator_step::<M>(c, 1, whole, whole.add(1)),
            29 => exchange::set_time::<M>(c, first),
            30 => exchange::set_continuous_states::<M>(c, real, states),
            31 => exchange::get_derivatives::<M>(c, real, states),
            32 => exchange::get_event_indicators::<M>(c, real, states),
            33 => exchange::get_continuous_states::<M>(c, real, states),
            34 => exchange::get_nominals_of_continuous_states::<M>(c, real, states),
            35 => step::set_real_input_derivatives::<M>(c, references, count, whole, real),
            36 => step::get_real_output_derivatives::<M>(c, references, count, whole, real),
            37..=41 => {
                let size = step_size(first);
                let status = step::do_step::<M>(c, held.time, size, 1);
                if matches!(status, Status::Ok | Status::Warning) {
                    held.time += size;
                }
                status
            }
            42 => step::do_step::<M>(c, second, step_size(first), 1),
            43 => step::cancel_step::<M>(c),
            _ => step::get_real_status::<M>(c, call.whole, real),
        }
    }
}

/// Calls functions on stored states; their bytes may be changed first.
fn on_states<M: Model>(c: Component, call: &Call, held: &mut Held) -> Status {
    unsafe {
        match call.whole.rem_euclid(5) {
            0 => {
                let mut stored = held.state.take().unwrap_or(null_mut());
                let status = state::get_fmu_state::<M>(c, &mut stored);
                held.state = (!stored.is_null()).then_some(stored);
                status
            }
            1 => state::set_fmu_state::<M>(c, held.state.unwrap_or(null_mut())),
            2 => {
                let (stored, mut size) = (held.state.unwrap_or(null_mut()), 0);
                let status = state::serialized_fmu_state_size::<M>(c, stored, &mut size);
                held.bytes = vec![0; size];
                state::serialize_fmu_state::<M>(c, stored, held.bytes.as_mut_ptr(), size);
                status
            }
            3 => {
                let mut bytes = held.bytes.clone();
                if call.null && !bytes.is_empty() {
                    let position = call.references[0] as usize % bytes.len();
                    bytes[position] ^= 1;
                    bytes.truncate(bytes.len() - call.references.len() % 2);
                }
                let mut read = null_mut();
                let status = state::deserialize_fmu_state::<M>(c, bytes.as_ptr(), bytes.len(), &mut read);
                assert_eq!(read.is_null(), status != Status::Ok);
                assert!(!call.null || status == Status::Error, "a changed state is refused");
                state::free_fmu_state::<M>(c, &mut read);
                status
            }
            _ => {
                let mut stored = held.state.take().unwrap_or(null_mut());
                let status = state::free_fmu_state::<M>(c, &mut stored);
                held.state = (!stored.is_null()).then_some(stored);
                status
            }
        }
    }
}

/// A sequence of calls.
type Calls = Vec<Call>;

impl Case for Calls {
    fn fresh() -> BoxedStrategy<Self> {
        prop::collection::vec(call(), 1..60).boxed()
    }

    fn grown(mut self, by: Self, at: usize) -> Self {
        self.truncate(1 + at % self.len());
        self.extend(by);
        self
    }

    fn simpler(&self) -> Vec<Self> {
        let halves = [&self[..self.len() / 2], &self[self.len() / 2..]].map(<[Call]>::to_vec);
        let without = (0..self.len()).map(|left_out| {
            let kept = self.iter().enumerate().filter(|(index, _)| *index != left_out);
            kept.map(|(_, call)| call.clone()).collect()
        });
        let plain = (0..self.len()).filter(|&index| self[index].numbers.iter().any(|number| *number != 0.0));
        let plain = plain.map(|index| {
            let mut calls = self.clone();
            calls[index].numbers.fill(0.0);
            calls
        });
        halves.into_iter().chain(without).chain(plain).filter(|calls| !calls.is_empty()).collect()
    }
}

/// Functions that may change the state of the instance.
const LEADING: [u8; 10] = [2, 3, 4, 5, 6, 7, 25, 26, 27, 37];

fn survives<M: Model>(fmu: &Unpacked<M>, interface: Interface, calls: &Calls) -> Seen {
    let c = fmu.instantiate(interface);
    assert!(!c.is_null());
    let mut held = Held::default();
    let (mut seen, mut led_by) = (Seen::new(), 0);
    texts();
    for call in calls {
        let status = make::<M>(c, call, &mut held);
        assert!(!matches!(status, Status::Fatal | Status::Pending), "{call:?}");
        seen.insert(format!("{} after {led_by}: {status:?}", call.function));
        seen.extend(texts().iter().map(|text| kind_of(text)));
        if status == Status::Ok && LEADING.contains(&call.function) {
            led_by = call.function;
        }
    }
    if let Some(mut stored) = held.state {
        assert_eq!(unsafe { state::free_fmu_state::<M>(c, &mut stored) }, Status::Ok);
    }
    free::<M>(c);
    assert_eq!(own_defects(), 0);
    seen
}

/// Runs the same calls on an FMU with lag in all actuators, on one with an actuator without lag, on one whose
/// controller has separate references and measurements, and on one in six degrees of freedom.
fn run_on_all<M: Model>(name: &str, interface: Interface) {
    let files =
        [example::resources(), example::without_lag(), example::with_two_degrees(), example::turning()];
    let fmus = files.map(|files| Unpacked::<M>::new(&files));
    fuzz::run(name, |calls| fmus.iter().flat_map(|fmu| survives(fmu, interface, calls)).collect());
}

#[test]
fn plant_handles_random_co_simulation_calls() {
    run_on_all::<PlantModel>("plant_calls", Interface::CoSimulation);
}

#[test]
fn plant_handles_random_model_exchange_calls() {
    run_on_all::<PlantModel>("plant_exchange_calls", Interface::ModelExchange);
}

#[test]
fn controller_handles_random_calls() {
    run_on_all::<Controller>("controller_calls", Interface::CoSimulation);
}

#[test]
fn loop_handles_random_co_simulation_calls() {
    run_on_all::<ClosedLoop>("squid_calls", Interface::CoSimulation);
}

#[test]
fn loop_handles_random_model_exchange_calls() {
    run_on_all::<ClosedLoop>("squid_exchange_calls", Interface::ModelExchange);
}
