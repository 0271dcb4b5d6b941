//! `squid export`: verifies the certificate, and writes the controller as source for the vehicle's computer.

use crate::cli::{Export, Language, Real, Selected, Which};
use crate::error::Error;
use crate::output::{answer_each, say};
use crate::progress::show;
use serde_json::json;
use squid_base::files::check_directory;
use squid_base::progress::Progress;
use squid_design::store::{self, axis_directory, source_directory};
use squid_package::axes::prefixed;
use squid_package::c::{Packed, pack, whole};
use squid_package::fmu::{lines, require_proof, standing};

/// Writes the controller of a design.
///
/// # Errors
/// Errors of the files and the design, or of a controller that the language cannot represent.
pub fn run(which: &Which, options: Export) -> Result<(), Error> {
    let Export { language: Language::C, real, to, allow_uncertified, verbose } = options;
    let real = match real {
        Real::Double => squid_embedded::Real::Double,
        Real::Float => squid_embedded::Real::Float,
    };
    let Selected { axes, directory: of_all } = which.read()?;
    let several = axes.len() > 1;
    let (mut made, mut objects, mut sources) = (vec![], vec![], vec![]);
    // All sources are generated before any is written.
    for (inputs, directory) in &axes {
        let mut stored = store::load(directory, inputs)?;
        let to = match &to {
            Some(to) => axis_directory(to, inputs),
            None => source_directory(directory, inputs),
        };
        check_directory(&to)?;
        let prove = || require_proof(inputs, &mut stored, directory, allow_uncertified);
        let what = "proving again, and recomputing the plant of the proof";
        let proof = Progress::new(&show).timed("certify", what, prove).0?;
        let (standing, claims) = (standing(&proof), lines(&proof, &stored));
        claims.iter().for_each(|line| say(&prefixed(axes.len(), inputs.design.steered_signal(), line)));
        if verbose {
            say(&standing);
        }
        let Packed { files, paths, source } = pack(&stored, &proof, real, &to)?;
        let paths: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        let mut object = json!({ "proof": standing, "claims": claims, "files": paths });
        if several {
            object["axis"] = json!(inputs.design.steered_signal());
        }
        objects.push(object);
        sources.push((inputs.design.steered_signal(), stored.controller, source));
        made.push((files, to, paths));
    }
    if several {
        let to = to.clone().unwrap_or_else(|| of_all.join("c"));
        check_directory(&to)?;
        let (files, paths) = whole(&axes[0].0, &sources, &to);
        let paths: Vec<String> = paths.iter().map(|path| path.display().to_string()).collect();
        objects.push(json!({ "files": paths }));
        made.push((files, to, paths));
    }
    for (files, to, paths) in made {
        files.save(&to)?;
        paths.iter().for_each(|path| say(path));
    }
    Ok(answer_each(&objects)?)
}
