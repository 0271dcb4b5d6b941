//! Files of an FMU that its proof does not cover: binaries, page, icons, licences.

use crate::archive::FmuArchive;
use crate::c::{CERTIFICATE, CONTROLLER};
use crate::fmu::{PAGE, attached};
use crate::kind::Kind;
use crate::platform::Platform;
use squid_base::files::read_bytes;
use squid_design::check::coupled::gain::CERTIFICATES;
use squid_fmi2::INTERFACE_RESOURCE;
use squid_fmu_controller::of_axis;
use squid_model_description::ModelDescription;
use squid_scheduled::ControllerDesign;
use std::io;

/// Names of the files of an FMU, compared with those that this version of squid packs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Contents {
    /// Files that are identical to the byte.
    pub identical: Vec<String>,
    /// Files that differ, that this version of squid does not pack, or that it cannot make on this machine.
    pub unexamined: Vec<String>,
}

impl Contents {
    /// Compares the files of an archive; the page only if it is given.
    ///
    /// # Errors
    /// [`io::Error`] of writing the terminals.
    pub fn of(
        archive: FmuArchive,
        (kind, description): (Kind, &ModelDescription),
        designs: &[&ControllerDesign],
        page: Option<Vec<u8>>,
    ) -> io::Result<Self> {
        let FmuArchive { others, resources, .. } = archive;
        let mut packed = attached(kind, description, designs)?;
        packed.extend(page.map(|page| (PAGE.to_owned(), page)));
        for platform in Platform::every() {
            let entry = platform.entry(&description.model_identifier);
            if others.contains_key(&entry)
                && let Ok(binary) = platform.find(kind, None)
                && let Ok(bytes) = read_bytes(&binary)
            {
                packed.insert(entry, bytes);
            }
        }
        let is_packed = |(name, bytes): &(String, Vec<u8>)| packed.get(name) == Some(bytes);
        let (identical, differing): (Vec<_>, Vec<_>) = others.into_iter().partition(is_packed);
        let unknown = resources.iter().filter(|(name, _)| !is_verified(name, designs.len()));
        let unknown = unknown.map(|(name, _)| format!("resources/{name}"));
        Ok(Self {
            identical: identical.into_iter().map(|(name, _)| name).collect(),
            unexamined: differing.into_iter().map(|(name, _)| name).chain(unknown).collect(),
        })
    }

    /// Returns one line for each of the two lists that is not empty.
    pub fn lines(&self) -> Vec<String> {
        let lines = [
            ("identical, to the byte, to the files that this version of squid packs", &self.identical),
            (
                "NOT EXAMINED, because this version of squid packs none, a different one, or cannot create it here",
                &self.unexamined,
            ),
        ];
        let line = |(title, names): (&str, &Vec<String>)| format!("{title}: {}", names.join(", "));
        lines.into_iter().filter(|(_, names)| !names.is_empty()).map(line).collect()
    }
}

/// Returns `true` if a resource of an FMU with `axes` axes is proved, compared with vehicle and design file, or
/// reported as not verified.
fn is_verified(resource: &str, axes: usize) -> bool {
    let of_axes = (0..axes).flat_map(|axis| [CONTROLLER, CERTIFICATE].map(|name| of_axis(name, axis)));
    let others = ["plant.json", "manoeuvre.json", squid_fmu_plant::VEHICLE_RESOURCE, INTERFACE_RESOURCE];
    of_axes.into_iter().any(|name| name == resource)
        || others.iter().chain(&CERTIFICATES).any(|name| *name == resource)
}
