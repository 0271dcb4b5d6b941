//! `squid package`: verifies the certificate, and packs FMUs and SSP.

use crate::cli::{Packing, Selected, Which};
use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::show;
use serde_json::json;
use squid_base::files::{Files, check_directory};
use squid_base::progress::Progress;
use squid_design::axis::several::narrower;
use squid_design::inputs::Inputs;
use squid_design::store::{self, Stored};
use squid_package::axes::{inputs, prefixed, unproved};
use squid_package::coupling::coupled;
use squid_package::error::Error as PackageError;
use squid_package::fmu::{Binaries, Packed, Prepared, lines, pack, prepare, require_proof, standing};
use squid_package::kind::{Interfaces, Kind};
use squid_package::platform::Platform;
use squid_package::ssp;
use squid_report::rendered::Rendered;
use squid_report::report::brief;
use std::path::{Path, PathBuf};

/// Packs the FMUs of a design.
///
/// # Errors
/// Errors of the files, the design, the report and the libraries.
pub fn run(which: &Which, options: Packing) -> Result<(), Error> {
    let Packing { platforms, kind, binaries, allow_uncertified, descriptions, verbose } = options;
    let interfaces = kind.into();
    let binaries = Binaries { platforms: named(&platforms)?, directory: binaries };
    let Selected { axes: read, directory } = which.read()?;
    // A heading design alone is packed as a controller: the vehicle is packed with its pitch or depth design.
    let alone = read.iter().all(|(inputs, _)| inputs.design.view().is_level_held);
    let mut kinds = Kind::with(interfaces);
    kinds.retain(|kind| !alone || *kind == Kind::Controller);
    if kinds.is_empty() {
        let allowed =
            "cs or both if a controller is packed alone, because it has no continuous states".into();
        return Err(Error::Argument { name: "--kind", found: "me".into(), allowed });
    }
    let load = |(inputs, directory): (Inputs, PathBuf)| {
        store::load(&directory, &inputs).map(|stored| (inputs, directory, stored))
    };
    let loaded: Vec<_> = read.into_iter().map(load).collect::<Result<_, _>>()?;
    let folder = descriptions.as_ref().unwrap_or(&directory);
    check_directory(folder)?;
    if descriptions.is_none() {
        binaries.find()?;
    }
    let progress = Progress::new(&show);
    let prove = |(inputs, directory, mut stored): (Inputs, PathBuf, Stored)| {
        let proof = require_proof(&inputs, &mut stored, &directory, allow_uncertified);
        proof.map(|proof| (inputs, stored, proof))
    };
    let what = "proving again, and recomputing the plant of the proof";
    let proving = || loaded.into_iter().map(prove).collect::<Result<Vec<_>, _>>();
    let mut proved = progress.timed("certify", what, proving).0?;
    let coupling = if proved.len() > 1 {
        let designs: Vec<_> = proved.iter().map(|(inputs, stored, _)| (inputs, stored)).collect();
        progress.timed("couple", "bounding the coupling in turns", || coupled(&designs)).0?
    } else {
        None
    };
    let coupling_claim = coupling.as_ref().map(|[first, _]| first.claim.clone());
    for ((_, stored, _), own) in proved.iter_mut().zip(coupling.into_iter().flatten()) {
        stored.coupling = Some(own);
    }
    let designs: Vec<_> = proved.iter().map(|(inputs, stored, _)| (inputs, stored)).collect();
    let designs = &designs[..];
    let (mut standings, mut claims) = (vec![], vec![]);
    for (_, stored, proof) in &proved {
        let prefixed = |text: &str| prefixed(designs.len(), &stored.controller.steered_signal(), text);
        standings.push(prefixed(&standing(proof)));
        claims.extend(lines(proof, stored).iter().map(|line| prefixed(line)));
    }
    let standing = standings.join("\n");
    claims.iter().for_each(|line| say(line));
    let coupled = coupling_claim.map(|claim| format!("certified: {claim}"));
    coupled.iter().for_each(|line| say(line));
    unproved(designs.len(), coupled.is_some()).into_iter().for_each(say);
    let warn = |text: String| say(&format!("WARNING: {text}"));
    narrower(&inputs(designs)).into_iter().for_each(warn);
    for (_, stored) in designs {
        let name = stored.controller.steered_signal();
        stored.missed().into_iter().for_each(|text| warn(prefixed(designs.len(), &name, &text)));
    }
    if verbose {
        say(&standing);
    }
    // All files are generated before any is written.
    let files: Vec<(PathBuf, Vec<u8>)> = match &descriptions {
        Some(to) => {
            let kinds = kinds.iter().copied();
            let described = kinds.map(|kind| prepare(kind, designs, interfaces));
            let file = |p: Prepared| (to.join(format!("{}.xml", p.identifier)), p.xml.into_bytes());
            described.map(|made| made.map(file)).collect::<Result<_, _>>()?
        }
        None => {
            let axes: Vec<_> = proved.iter().map(|(inputs, stored, proof)| (inputs, stored, proof)).collect();
            let write = || brief(&axes, &which.report_of("VEHICLE_DIR"), &progress);
            let page = Rendered::of(&progress.timed("page", "writing the documentation", write).0?);
            let packing = progress.begin("package", "compressing");
            let packed = |kind| -> Result<Packed, PackageError> {
                let prepared = prepare(kind, designs, interfaces)?;
                pack(kind, prepared, designs, &page, &binaries, &directory)
            };
            let fmus = kinds.iter().copied().map(packed).collect::<Result<Vec<_>, _>>()?;
            let system = match &fmus[..] {
                [plant, controller, closed_loop] => {
                    let name = &closed_loop.description.model_identifier;
                    Some(ssp::pack(
                        name,
                        &[(Kind::Plant, plant), (Kind::Controller, controller)],
                        designs,
                        &directory,
                    )?)
                }
                _ => None,
            };
            drop(packing);
            fmus.into_iter().map(|packed| (packed.path, packed.bytes)).chain(system).collect()
        }
    };
    let size =
        |path: &Path, bytes: &[u8]| format!("{} ({:.0} kB)", path.display(), bytes.len() as f64 / 1000.0);
    let written: Vec<String> = files.iter().map(|(path, bytes)| size(path, bytes)).collect();
    let names: Vec<String> = files.iter().map(|(path, _)| path.display().to_string()).collect();
    let mut set = Files::default();
    if descriptions.is_none() && interfaces == Interfaces::ModelExchange {
        say("no controller and no SSP, because they require co-simulation");
        let [_, controller, closed_loop] = Kind::ALL.map(|kind| prepare(kind, designs, Interfaces::All));
        set.remove(directory.join(format!("{}.fmu", controller?.identifier)));
        set.remove(directory.join(format!("{}.ssp", closed_loop?.identifier)));
    }
    files.into_iter().for_each(|(path, bytes)| set.add(path, bytes));
    set.save(folder)?;
    written.iter().for_each(|line| say(line));
    let report = which.report();
    say(&format!("full report: {report}"));
    Ok(answer(
        &json!({ "proof": standing, "claims": claims, "coupling": coupled, "files": names, "report": report }),
    )?)
}

fn named(platforms: &[String]) -> Result<Vec<Platform>, Error> {
    Platform::named(platforms).map_err(|reason| match reason {
        PackageError::UnknownPlatform { found, allowed } => {
            Error::Argument { name: "--platforms", found, allowed }
        }
        reason => reason.into(),
    })
}
