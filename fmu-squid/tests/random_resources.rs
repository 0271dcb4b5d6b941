//! Random changes of resource files: a model that loads them starts, steps and is freed, or refuses in a sentence; nothing
//! panics. `PROPTEST_CASES` makes the run longer; failures are kept in `random_resources.regressions`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod abi;
mod example;

use std::sync::OnceLock;
use std::sync::atomic::Ordering;

use abi::{DEFECTS, Unpacked, do_step, free};
use fmi2::abi::{Status, lifecycle};
use fmi2::{Interface, Model, Resources, describe};
use fmu_controller::Controller;
use fmu_plant::PlantModel;
use fmu_squid::ClosedLoop;
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;

/// What happens to a file.
#[derive(Debug, Clone)]
enum Change {
    /// The n-th number becomes a text.
    Number(usize, &'static str),
    /// A byte is changed.
    Byte(usize, u8),
    /// The file ends early.
    Cut(usize),
    /// A part of the file comes twice.
    Twice(usize, usize),
    /// The file is gone.
    Gone,
}

const FILES: [&str; 4] = ["vehicle.toml", "plant.json", "controller.json", "manoeuvre.json"];

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
        6 => (any::<usize>(), prop::sample::select(NUMBERS.to_vec())).prop_map(|(n, to)| Change::Number(n, to)),
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
        Change::Number(which, to) => {
            let numbers = numbers_of(text);
            let (start, end) = numbers[which % numbers.len()];
            bytes.splice(start..end, to.bytes());
        }
        Change::Byte(at, byte) => bytes[within(at)] = byte,
        Change::Cut(at) => bytes.truncate(within(at)),
        Change::Twice(one, other) => {
            let (from, to) = (within(one).min(within(other)), within(one).max(within(other)));
            bytes.splice(from..from, text[from..to].iter().copied());
        }
        Change::Gone => return None,
    }
    Some(bytes)
}

/// Where numbers stand in a text.
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

/// Loads the changed files; where that works, flies them for a moment.
fn survives<M: Model>(file: &str, change: &Change) {
    static WHOLE: OnceLock<Resources> = OnceLock::new();
    let whole = WHOLE.get_or_init(example::resources);
    let mut resources = Resources::default();
    for (name, bytes) in whole.iter() {
        match if name == file { changed(bytes, change) } else { Some(bytes.to_vec()) } {
            Some(bytes) => resources.insert(name, bytes),
            None => continue,
        }
    }
    if let Err(refused) = describe::<M>(&resources) {
        let sentence = refused.to_string();
        assert!(!sentence.is_empty() && !sentence.contains("panic"), "{sentence}");
        return;
    }
    let fmu = Unpacked::<M>::new(&resources);
    let c = fmu.instantiate(Interface::CoSimulation);
    assert!(!c.is_null());
    unsafe { lifecycle::enter_initialization_mode::<M>(c) };
    if unsafe { lifecycle::exit_initialization_mode::<M>(c) } == Status::Ok {
        for k in 0..5 {
            do_step::<M>(c, f64::from(k) * 0.02, 0.02);
        }
    }
    free::<M>(c);
    assert_eq!(DEFECTS.load(Ordering::Relaxed), 0, "{file}: {change:?}");
}

/// As many cases as `PROPTEST_CASES` says; what fails is kept beside this file, and tried first from then on.
fn config() -> ProptestConfig {
    let kept = FileFailurePersistence::WithSource("regressions");
    ProptestConfig { failure_persistence: Some(Box::new(kept)), ..ProptestConfig::default() }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn plants_survive(file in prop::sample::select(FILES[..2].to_vec()), change in change()) {
        survives::<PlantModel>(file, &change);
    }

    #[test]
    fn controllers_survive(change in change()) {
        survives::<Controller>("controller.json", &change);
    }

    #[test]
    fn loops_survive(file in prop::sample::select(FILES.to_vec()), change in change()) {
        survives::<ClosedLoop>(file, &change);
    }
}

/// A folder instead of a file, and a file of a hundred megabytes.
#[test]
fn odd_files_are_refused_in_a_sentence() {
    let fmu = Unpacked::<Controller>::new(&example::resources());
    let path = fmu.folder.path().join("controller.json");
    std::fs::write(&path, vec![b' '; 100_000_000]).unwrap();
    assert!(fmu.instantiate(Interface::CoSimulation).is_null());
    std::fs::remove_file(&path).unwrap();
    std::fs::create_dir(&path).unwrap();
    assert!(fmu.instantiate(Interface::CoSimulation).is_null());
    assert!(abi::MESSAGES.load(Ordering::Relaxed) >= 2);
}
