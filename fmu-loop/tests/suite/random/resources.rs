//! Random changes of resource files: a model either loads them, starts, steps and is freed, or refuses them with a
//! message, without a panic. `PROPTEST_CASES` and `SQUID_FUZZ_MINUTES` extend the run; `corpus` stores cases with
//! outcomes that were new when found.

use std::sync::OnceLock;
use std::sync::atomic::Ordering;

use super::fuzz;
use super::fuzz::{Case, Seen, kind_of};
use crate::abi::{Unpacked, do_step, free, own_defects, texts};
use crate::example;
use proptest::prelude::*;
use serde::{Deserialize, Serialize};
use squid_fmi2::abi::{Status, lifecycle};
use squid_fmi2::{Interface, Model, Resources, describe};
use squid_fmu_controller::Controller;
use squid_fmu_loop::ClosedLoop;
use squid_fmu_plant::PlantModel;

/// A change of a file.
#[derive(Debug, Clone, Serialize, Deserialize)]
enum Change {
    /// Replaces the n-th number by a text.
    Number(usize, String),
    /// Changes a byte.
    Byte(usize, u8),
    /// Truncates the file.
    Cut(usize),
    /// Duplicates a part of the file.
    Twice(usize, usize),
    /// Removes the file.
    Gone,
}

const FILES: [&str; 4] = ["vehicle.json", "plant.json", "controller.json", "manoeuvre.json"];

const NUMBERS: [&str; 14] = [
    "0",
    "-1",
    "1",
    "2",
    "1e-300",
    "-1e308",
    "1e308",
    "1e999",
    "nan",
    "null",
    "[]",
    "\"x\"",
    "4294967296",
    "0.5",
];

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        6 => (any::<usize>(), prop::sample::select(NUMBERS.to_vec()))
            .prop_map(|(n, to)| Change::Number(n, to.to_owned())),
        2 => (any::<usize>(), any::<u8>()).prop_map(|(at, byte)| Change::Byte(at, byte)),
        1 => any::<usize>().prop_map(Change::Cut),
        1 => (any::<usize>(), any::<usize>()).prop_map(|(from, to)| Change::Twice(from, to)),
        1 => Just(Change::Gone),
    ]
}

fn changed(text: &[u8], change: &Change) -> Option<Vec<u8>> {
    let within = |position: usize| position % text.len().max(1);
    let mut bytes = text.to_vec();
    match *change {
        Change::Number(which, ref to) => {
            let numbers = numbers_of(text);
            if !numbers.is_empty() {
                let (start, end) = numbers[which % numbers.len()];
                bytes.splice(start..end, to.bytes());
            }
        }
        Change::Byte(at, byte) => {
            if let Some(changed) = bytes.get_mut(within(at)) {
                *changed = byte;
            }
        }
        Change::Cut(at) => bytes.truncate(within(at)),
        Change::Twice(one, other) => {
            let (from, to) = (within(one).min(within(other)), within(one).max(within(other)));
            bytes.splice(from..from, text[from..to].iter().copied());
        }
        Change::Gone => return None,
    }
    Some(bytes)
}

/// Returns the ranges of numbers in a text.
fn numbers_of(text: &[u8]) -> Vec<(usize, usize)> {
    let of_number = |byte: u8| byte.is_ascii_digit() || b"+-.eE".contains(&byte);
    let mut found = Vec::new();
    let mut position = 0;
    while position < text.len() {
        let length = text[position..].iter().take_while(|&&byte| of_number(byte)).count();
        if text[position..position + length].iter().any(u8::is_ascii_digit) {
            found.push((position, position + length));
        }
        position += length.max(1);
    }
    found
}

/// Changes of the n-th files of a model; a file may be changed more than once.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Changes(Vec<(usize, Change)>);

impl Case for Changes {
    fn fresh() -> BoxedStrategy<Self> {
        let one = || (0..FILES.len(), change());
        prop_oneof![4 => prop::collection::vec(one(), 1), 1 => prop::collection::vec(one(), 2..4)]
            .prop_map(Self)
            .boxed()
    }

    fn grown(mut self, by: Self, at: usize) -> Self {
        self.0.truncate(1 + at % self.0.len());
        self.0.extend(by.0);
        self
    }

    fn simpler(&self) -> Vec<Self> {
        let without = |left_out: usize| {
            let mut changes = self.0.clone();
            changes.remove(left_out);
            Self(changes)
        };
        (0..self.0.len()).map(without).filter(|changes| !changes.0.is_empty()).collect()
    }
}

/// Loads the changed files; simulates them briefly if they load.
fn survives<M: Model>(files: &[&str], changes: &Changes) -> Seen {
    static WHOLE: OnceLock<[Resources; 2]> = OnceLock::new();
    let whole = WHOLE.get_or_init(|| [example::resources(), example::with_two_degrees()]);
    whole.iter().flat_map(|whole| survives_of::<M>(whole, files, changes)).collect()
}

fn survives_of<M: Model>(whole: &Resources, files: &[&str], changes: &Changes) -> Seen {
    let mut resources = Resources::default();
    for (name, bytes) in whole.iter() {
        let mut of_file = changes.0.iter().filter(|(file, _)| files[file % files.len()] == name);
        let bytes = of_file.try_fold(bytes.to_vec(), |bytes, (_, one)| changed(&bytes, one));
        if let Some(bytes) = bytes {
            resources.insert(name, bytes);
        }
    }
    if let Err(refused) = describe::<M>(&resources) {
        let sentence = refused.to_string();
        assert!(!sentence.is_empty() && !sentence.contains("panic"), "{sentence}");
        return Seen::from([kind_of(&sentence)]);
    }
    let fmu = Unpacked::<M>::new(&resources);
    texts();
    let c = fmu.instantiate(Interface::CoSimulation);
    assert!(!c.is_null());
    unsafe { lifecycle::enter_initialization_mode::<M>(c) };
    if unsafe { lifecycle::exit_initialization_mode::<M>(c) } == Status::Ok {
        for k in 0..5 {
            do_step::<M>(c, f64::from(k) * 0.02, 0.02);
        }
    }
    free::<M>(c);
    assert_eq!(own_defects(), 0, "{changes:?}");
    texts().iter().map(|text| kind_of(text)).collect()
}

#[test]
fn plant_handles_changed_resources() {
    fuzz::run("plant_resources", |changes| survives::<PlantModel>(&FILES[..2], changes));
}

#[test]
fn controller_handles_changed_resources() {
    fuzz::run("controller_resources", |changes| survives::<Controller>(&FILES[2..3], changes));
}

#[test]
fn loop_handles_changed_resources() {
    fuzz::run("squid_resources", |changes| survives::<ClosedLoop>(&FILES, changes));
}

/// A folder in place of a file, and a file of a hundred megabytes.
#[test]
fn rejects_folder_and_huge_file() {
    let fmu = Unpacked::<Controller>::new(&example::resources());
    let path = fmu.folder.path().join("controller.json");
    std::fs::write(&path, vec![b' '; 100_000_000]).unwrap();
    assert!(fmu.instantiate(Interface::CoSimulation).is_null());
    std::fs::remove_file(&path).unwrap();
    std::fs::create_dir(&path).unwrap();
    assert!(fmu.instantiate(Interface::CoSimulation).is_null());
    assert!(crate::abi::MESSAGES.load(Ordering::Relaxed) >= 2);
}
