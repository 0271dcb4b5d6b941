//! The page of a finished FMU, made again from the files of its vehicle.

use crate::axes::Axes;
use crate::fmu::documentation;
use crate::kind::Kind;
use base::progress::Progress;
use certificate::Theorem;
use scheduled::ControllerDesign;
use squid_design::inputs::Inputs;
use squid_design::store::{self, StoredCoupling};
use squid_report::rendered::Rendered;
use squid_report::report::brief;
use std::path::Path;

/// Vehicle and design files to which something is compared.
#[derive(Debug, Clone, Copy)]
pub struct Given<'a> {
    /// The files of each axis.
    pub inputs: Axes<&'a Inputs>,
    /// The command that writes the report of the first, as the page in an FMU names it.
    pub report: &'a str,
}

/// The page of an FMU, made again with the figures of its design; `None` if the design is not stored in the folder of
/// the FMU, or that of heading in its own.
pub(crate) fn page(
    path: &Path,
    kind: Kind,
    (given, controllers): (Given<'_>, Axes<&ControllerDesign>),
    proof: &Theorem,
    coupling: Option<&str>,
) -> Option<Vec<u8>> {
    let stored = |inputs: &Inputs, directory: &Path, controller: &ControllerDesign| {
        store::load(directory, inputs).ok().filter(|stored| stored.controller == *controller)
    };
    let directory = path.parent()?;
    let mut first = stored(given.inputs.first, directory, controllers.first)?;
    let words = coupling.map(str::to_owned);
    first.coupling = words.map(|words| StoredCoupling { certificate: String::new(), words });
    let heading = match given.inputs.heading.zip(controllers.heading) {
        Some((inputs, controller)) => {
            Some((inputs, stored(inputs, &store::default_directory(inputs), controller)?))
        }
        None => None,
    };
    let designs = Axes {
        first: (given.inputs.first, &first),
        heading: heading.as_ref().map(|(inputs, stored)| (*inputs, stored)),
    };
    let (inputs, proof) = (given.inputs.first, Ok(proof.clone()));
    let page = brief(inputs, &first, &proof, given.report, &Progress::default()).ok()?;
    Some(documentation(kind, designs, &Rendered::of(&page)))
}
