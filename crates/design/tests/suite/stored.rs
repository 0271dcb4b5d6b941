//! Designs in one folder: with concurrent writers, a reader always gets one complete design.

use crate::designs::read;
use squid_base::progress::Progress;
use squid_design::certify::verify;
use squid_design::error::{Error, StoreError};
use squid_design::inputs::Inputs;
use squid_design::run::Finished;
use squid_design::run::run;
use squid_design::store;
use squid_design::store::Stored;
use squid_proof::claim::parse;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

/// Number of times that each of the two designs is written.
const TIMES: usize = 50;

/// Loads either of two stored designs.
fn either<'a>(directory: &Path, designs: [&'a Inputs; 2]) -> (&'a Inputs, Stored) {
    loop {
        for inputs in designs {
            match store::load(directory, inputs) {
                Err(Error::Store(StoreError::OtherDesign { .. } | StoreError::Stale { .. })) => {}
                other => return (inputs, other.unwrap()),
            }
        }
    }
}

/// Asserts that all files belong to the design whose hashes are in controller.json: the certificate is that of its
/// controller, or missing if nothing was proved.
fn assert_one_design(directory: &Path, proved: &Inputs, other: &Inputs) {
    let (inputs, stored) = either(directory, [proved, other]);
    if inputs.hashes == proved.hashes {
        let text = stored.certificate.unwrap();
        let certificate = parse(&text, "certificate.json").unwrap();
        verify::check_design(&stored.controller, &certificate).unwrap();
    } else {
        assert!(stored.certificate.is_err(), "the certificate of the other design");
    }
}

/// The paper's designs are used because they are computed quickly.
#[test]
fn concurrent_writers_leave_one_design() {
    let proved = read("squid", "paper");
    let other = proved.clone().with_bandwidth(0.23).unwrap();
    let made = |inputs: &Inputs| run(inputs, &Progress::default()).unwrap();
    let (with_proof, mut without) = (made(&proved), made(&other));
    without.proof = Err("taken away".into());
    without.frozen.controller.gamma.certified = false;
    let folder = tempfile::tempdir().unwrap();
    store::save(folder.path(), &proved, &with_proof).unwrap();
    let done = AtomicBool::new(false);
    let write = |inputs: &Inputs, finished: &Finished| {
        (0..TIMES).for_each(|_| store::save(folder.path(), inputs, finished).unwrap());
        done.store(true, Ordering::Relaxed);
    };
    std::thread::scope(|scope| {
        scope.spawn(|| write(&proved, &with_proof));
        scope.spawn(|| write(&other, &without));
        scope.spawn(|| {
            while !done.load(Ordering::Relaxed) {
                assert_one_design(folder.path(), &proved, &other);
            }
        });
    });
    assert_one_design(folder.path(), &proved, &other);
}

/// A file that is JSON with other keys, types or another format is of another version; the error names it.
#[test]
fn names_the_file_of_another_version() {
    let inputs = read("squid", "paper");
    let folder = tempfile::tempdir().unwrap();
    store::save(folder.path(), &inputs, &run(&inputs, &Progress::default()).unwrap()).unwrap();
    let changes = [
        ("controller.json", "\"delay\": 0, \"format\"", true),
        ("controller.json", "\"older\"", true),
        ("plant.json", "\"older\"", true),
        ("controller.json", "not JSON", false),
        ("plant.json", "not JSON", false),
    ];
    for (name, format, is_format) in changes {
        let path = folder.path().join(name);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replacen("\"format\"", format, 1)).unwrap();
        let error = store::load(folder.path(), &inputs).unwrap_err();
        match error {
            Error::Store(StoreError::OtherFormat { path: found, .. }) if is_format => {
                assert_eq!(Path::new(&found), path);
            }
            error => assert!(!is_format, "{name}, {format}: {error}"),
        }
        std::fs::write(&path, text).unwrap();
    }
    std::fs::write(folder.path().join("robust.json"), "{}").unwrap();
    let error = store::load(folder.path(), &inputs).unwrap_err();
    assert!(matches!(error, Error::Store(StoreError::OtherFormat { .. })), "{error}");
}
