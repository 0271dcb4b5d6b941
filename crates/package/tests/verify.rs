//! Verification of a finished FMU, with and without the files of its vehicle.
#![allow(clippy::unwrap_used, missing_docs)]

use squid_base::progress::Progress;
use squid_design::inputs::Inputs;
use squid_design::store::{Stored, load};
use squid_model_description::Interfaces;
use squid_package::error::Error;
use squid_package::fmu::{Binaries, PAGE, pack, prepare};
use squid_package::kind::Kind;
use squid_package::page::Given;
use squid_package::platform::Platform;
use squid_package::verify::{Verification, verify};
use squid_report::rendered::Rendered;
use squid_report::report::brief;
use std::env::consts::{DLL_PREFIX, DLL_SUFFIX};
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use zip::write::SimpleFileOptions;

const REPORT: &str = "squid report VEHICLE_DIR";

static PAGE_OF_DESIGN: OnceLock<Rendered> = OnceLock::new();

fn vehicle() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../vehicles/squid")
}

/// Returns a folder with the frozen design and the FMU of its controller, changed before it is packed; the binary is a
/// script.
fn packed(change: impl FnOnce(&mut Stored)) -> (tempfile::TempDir, PathBuf, Inputs) {
    let (folder, inputs) = (tempfile::tempdir().unwrap(), Inputs::read(&vehicle(), "design").unwrap());
    for entry in std::fs::read_dir(vehicle().join("frozen")).unwrap() {
        let path = entry.unwrap().path();
        std::fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
    }
    let mut stored = load(folder.path(), &inputs).unwrap();
    let page = PAGE_OF_DESIGN.get_or_init(|| {
        let proof = stored.prove(&inputs);
        Rendered::of(&brief(&[(&inputs, &stored, &proof)], REPORT, &Progress::default()).unwrap())
    });
    change(&mut stored);
    let library = format!("{DLL_PREFIX}{}{DLL_SUFFIX}", Kind::Controller.library().replace('-', "_"));
    std::fs::write(folder.path().join(library), "#!/bin/sh\n").unwrap();
    let binaries = Binaries {
        platforms: Platform::named(&["host".into()]).unwrap(),
        directory: Some(folder.path().to_owned()),
    };
    let designs = &[(&inputs, &stored)];
    let prepared = prepare(Kind::Controller, designs, Interfaces::All).unwrap();
    let fmu = pack(Kind::Controller, prepared, designs, page, &binaries, folder.path()).unwrap();
    std::fs::write(&fmu.path, &fmu.bytes).unwrap();
    (folder, fmu.path, inputs)
}

fn with_files(fmu: &Path, inputs: &Inputs) -> Result<Verification, Error> {
    verify(fmu, Some(Given { inputs: &[inputs], report: REPORT }))
}

/// Extends the text of one file in an archive.
fn edited(fmu: &Path, name: &str) {
    let mut from = zip::ZipArchive::new(Cursor::new(std::fs::read(fmu).unwrap())).unwrap();
    let mut to = zip::ZipWriter::new(Cursor::new(vec![]));
    for index in 0..from.len() {
        let mut entry = from.by_index(index).unwrap();
        let (entry_name, mut bytes) = (entry.name().unwrap().into_owned(), vec![]);
        entry.read_to_end(&mut bytes).unwrap();
        if entry_name == name {
            bytes.extend(b"<p>proved for every vehicle</p>");
        }
        to.start_file(entry_name, SimpleFileOptions::default()).unwrap();
        to.write_all(&bytes).unwrap();
    }
    std::fs::write(fmu, to.finish().unwrap().into_inner()).unwrap();
}

/// A scale is not part of the certificate: a threefold scale, with a new GUID, gives another controller.
#[test]
fn reports_only_what_is_verified() {
    let (_folder, fmu, inputs) = packed(|_| ());
    let found = with_files(&fmu, &inputs).unwrap();
    let (verified, contents) = (&found.axes[0], &found.contents);
    assert!(
        verified.step.is_some() && verified.lines.iter().any(|line| line.contains("deg")),
        "{verified:?}"
    );
    let is_binary = |name: &String| name.starts_with("binaries/");
    assert!(contents.unexamined.len() == 1 && contents.unexamined.iter().all(is_binary), "{contents:?}");
    for name in [PAGE, "model.png", "documentation/licenses/third_party.txt"] {
        assert!(contents.identical.iter().any(|one| one == name), "{contents:?}");
    }
    let found = verify(&fmu, None).unwrap();
    let honest = found.axes[0].clone();
    assert!(
        honest.lines.iter().all(|line| !line.contains("deg") && !line.contains("m/s")),
        "{:?}",
        honest.lines
    );
    assert!(
        honest.step.is_none() && honest.about.iter().any(|line| line.contains("deg")),
        "{:?}",
        honest.about
    );
    // The page has figures of simulations, which require the files of the vehicle.
    assert!(found.contents.unexamined.iter().any(|name| name == PAGE), "{:?}", found.contents);
    edited(&fmu, PAGE);
    let contents = with_files(&fmu, &inputs).unwrap().contents;
    assert!(contents.unexamined.iter().any(|name| name == PAGE), "{contents:?}");
    let (_folder, scaled, inputs) = packed(|stored| {
        stored.controller.controller_inputs.iter_mut().for_each(|input| input.scale *= 3.0);
    });
    assert_eq!(verify(&scaled, None).unwrap().axes[0].lines, honest.lines);
    assert!(matches!(with_files(&scaled, &inputs), Err(Error::NotOfInputs { .. })));
}
