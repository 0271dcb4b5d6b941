//! Page of a finished FMU, regenerated from the files of its vehicle.

use crate::fmu::documentation;
use crate::kind::Kind;
use squid_base::progress::Progress;
use squid_certificate::Theorem;
use squid_design::inputs::Inputs;
use squid_design::store::{self, Stored, StoredCoupling};
use squid_report::rendered::Rendered;
use squid_report::report::brief;
use squid_scheduled::ControllerDesign;
use std::path::Path;

/// Vehicle and design files used for comparison.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    /// Files of each axis.
    pub inputs: &'a [&'a Inputs],
    /// Command that writes the report of the first axis, as the page in an FMU states it.
    pub report: &'a str,
}

/// Returns the page of an FMU, regenerated with the figures of its design; `None` if the design is not stored in the
/// folder of the FMU.
pub(crate) fn page(
    path: &Path,
    kind: Kind,
    (given, controllers): (Given<'_>, &[&ControllerDesign]),
    proofs: &[&Theorem],
    coupling: Option<&str>,
) -> Option<Vec<u8>> {
    let directory = path.parent()?;
    let stored = |(inputs, controller): (&&Inputs, &&ControllerDesign)| {
        let of_axis = store::axis_directory(directory, inputs);
        let directory = if controllers.len() > 1 { &of_axis } else { directory };
        let mut stored = store::load(directory, inputs).ok().filter(|one| one.controller == **controller)?;
        let claim = coupling.map(str::to_owned);
        stored.coupling = claim.map(|claim| StoredCoupling { certificate: String::new(), claim });
        Some(stored)
    };
    let stored: Vec<Stored> = given.inputs.iter().zip(controllers).map(stored).collect::<Option<_>>()?;
    let designs: Vec<_> = given.inputs.iter().copied().zip(&stored).collect();
    let proofs: Vec<Result<Theorem, String>> = proofs.iter().map(|proof| Ok((*proof).clone())).collect();
    let axes: Vec<_> =
        designs.iter().zip(&proofs).map(|((inputs, stored), proof)| (*inputs, *stored, proof)).collect();
    let page = brief(&axes, given.report, &Progress::default()).ok()?;
    Some(documentation(kind, &designs, &Rendered::of(&page)))
}
