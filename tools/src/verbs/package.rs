//! `squid package`: proves the certificate again, and packs FMUs and SSP.

use crate::cli::{Packing, Which};
use crate::error::Error;
use crate::output::{answer, say};
use crate::progress::show;
use base::files::{Files, check_directory};
use base::progress::Progress;
use serde_json::json;
use squid_design::store;
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
/// Those of the files, the design, the report and the libraries.
pub fn run(which: &Which, asked: Packing) -> Result<(), Error> {
    let Packing { platforms, kind, binaries, allow_uncertified, descriptions, verbose } = asked;
    let interfaces = kind.into();
    let binaries = Binaries { platforms: named(&platforms)?, directory: binaries };
    let (inputs, directory) = which.read()?;
    let mut stored = store::load(&directory, &inputs)?;
    let folder = descriptions.as_ref().unwrap_or(&directory);
    check_directory(folder)?;
    if descriptions.is_none() {
        binaries.find()?;
    }
    let progress = Progress::new(&show);
    let prove = || require_proof(&inputs, &mut stored, &directory, allow_uncertified);
    let what = "proving again, and computing the plant of the proof again";
    let proof = progress.timed("certify", what, prove).0?;
    let (standing, claims) = (standing(&proof), lines(&proof, &stored));
    claims.iter().for_each(|line| say(line));
    if verbose {
        say(&standing);
    }
    // Of heading a controller alone: the vehicle is packed with its design of pitch or depth.
    let of_design = |kind: &Kind| stored.plant.is_some() || *kind == Kind::Controller;
    let kinds: Vec<Kind> = Kind::with(interfaces).into_iter().filter(of_design).collect();
    // All are made before any is written.
    let files: Vec<(PathBuf, Vec<u8>)> = match &descriptions {
        Some(to) => {
            let kinds = kinds.iter().copied();
            let described = kinds.map(|kind| prepare(kind, &inputs, &stored, interfaces));
            let file = |p: Prepared| (to.join(format!("{}.xml", p.identifier)), p.xml.into_bytes());
            described.map(|made| made.map(file)).collect::<Result<_, _>>()?
        }
        None => {
            let write = || brief(&inputs, &stored, &proof, &which.report_of("VEHICLE_DIR"), &progress);
            let page = Rendered::of(&progress.timed("page", "writing the documentation", write).0?);
            let packing = progress.begin("package", "compressing");
            let packed = |kind| -> Result<Packed, PackageError> {
                let prepared = prepare(kind, &inputs, &stored, interfaces)?;
                pack(kind, prepared, &stored, &page, &binaries, &directory)
            };
            let fmus = kinds.iter().copied().map(packed).collect::<Result<Vec<_>, _>>()?;
            let system = match &fmus[..] {
                [plant, controller, whole] => {
                    let name = &whole.description.model_identifier;
                    Some(ssp::pack(name, plant, controller, &stored, &directory)?)
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
        say("no controller and no SSP: they are for co-simulation");
        let [_, controller, whole] = Kind::ALL.map(|kind| prepare(kind, &inputs, &stored, Interfaces::All));
        set.remove(directory.join(format!("{}.fmu", controller?.identifier)));
        set.remove(directory.join(format!("{}.ssp", whole?.identifier)));
    }
    files.into_iter().for_each(|(path, bytes)| set.add(path, bytes));
    set.save(folder)?;
    written.iter().for_each(|line| say(line));
    let report = which.report();
    say(&format!("the whole report: {report}"));
    Ok(answer(&json!({ "proof": standing, "claims": claims, "files": names, "report": report }))?)
}

fn named(platforms: &[String]) -> Result<Vec<Platform>, Error> {
    Platform::named(platforms).map_err(|reason| match reason {
        PackageError::UnknownPlatform { found, allowed } => {
            Error::Argument { name: "--platforms", found, allowed }
        }
        reason => reason.into(),
    })
}
