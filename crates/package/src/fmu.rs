//! Packs FMUs: model description, binary, resources and documentation in one zip, with reproducible bytes.

use crate::axes::{Designs, controllers, inputs, prefixed, unproved};
use crate::c::{CERTIFICATE, CONTROLLER};
use crate::error::Error;
use crate::kind::Kind;
use crate::platform::Platform;
use crate::terminals::terminals;
use squid_base::files::read_bytes;
use squid_base::numbers::above;
use squid_certificate::Theorem;
use squid_design::axis::several;
use squid_design::certify::claims::{self, Terms};
use squid_design::check::coupled::gain::CERTIFICATES;
use squid_design::inputs::Inputs;
use squid_design::store::Stored;
use squid_fmi2::{Described, INTERFACE_RESOURCE, Model, Resources};
use squid_fmu_controller::of_axis;
use squid_model_description::{Interfaces, ModelDescription};
use squid_proof::error::ProofError;
use squid_report::rendered::Rendered;
use squid_scheduled::ControllerDesign;
use std::collections::BTreeMap;
use std::io::{self, Cursor, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;

/// Binaries to be packed into the FMUs.
#[derive(Debug)]
pub struct Binaries {
    /// Platforms, with one binary each.
    pub platforms: Vec<Platform>,
    /// Directory of the binaries; `None` for that of cargo.
    pub directory: Option<PathBuf>,
}

impl Binaries {
    /// Checks that all binaries exist, before any work.
    ///
    /// # Errors
    /// [`Error::NoBinary`].
    pub fn find(&self) -> Result<(), Error> {
        let each = self.platforms.iter().flat_map(|platform| Kind::ALL.map(|kind| (platform, kind)));
        each.into_iter()
            .try_for_each(|(platform, kind)| platform.find(kind, self.directory.as_deref()).map(|_| ()))
    }
}

/// Contents of an FMU without its binaries.
#[derive(Debug)]
pub struct Prepared {
    /// Name of the FMU and of its binary.
    pub identifier: String,
    /// Text of `modelDescription.xml`.
    pub xml: String,
    description: ModelDescription,
    resources: Resources,
}

/// A finished FMU in memory.
#[derive(Debug)]
pub struct Packed {
    /// Path of the FMU.
    pub path: PathBuf,
    /// Bytes of the FMU.
    pub bytes: Vec<u8>,
    /// Model description.
    pub description: ModelDescription,
}

/// Proves the certificate of a stored design. With `allow_uncertified` a design without proof is marked as uncertified
/// instead of being refused, and the reason returned.
///
/// # Errors
/// [`Error::Uncertified`].
pub fn require_proof(
    inputs: &Inputs,
    stored: &mut Stored,
    directory: &Path,
    allow_uncertified: bool,
) -> Result<Result<Theorem, String>, Error> {
    match stored.prove(inputs) {
        Ok(theorem) if stored.controller.gamma.certified => Ok(Ok(theorem)),
        Ok(_) => Err(ProofError::Mismatch { what: "'certified' in controller.json".into() }.into()),
        Err(reason) if allow_uncertified => {
            stored.controller.gamma.certified = false;
            Ok(Err(reason))
        }
        Err(reason) => Err(Error::Uncertified { directory: directory.display().to_string(), reason }),
    }
}

/// Returns the outcome of [`require_proof`] as text.
pub fn standing(proof: &Result<Theorem, String>) -> String {
    match proof {
        Ok(theorem) => format!("certified: {theorem}"),
        Err(reason) => uncertified(reason),
    }
}

/// Returns the outcome of [`require_proof`] for people, one line per claim.
pub fn lines(proof: &Result<Theorem, String>, stored: &Stored) -> Vec<String> {
    match proof {
        Ok(theorem) => {
            let terms = Terms::of(&stored.controller, theorem, Some(&stored.manoeuvre));
            let claims = claims::lines(theorem, Some(&terms));
            let unproved = claims::unproved(theorem, &terms);
            claims.into_iter().map(|claim| format!("certified: {claim}")).chain(unproved).collect()
        }
        Err(reason) => vec![uncertified(reason)],
    }
}

fn uncertified(reason: &str) -> String {
    format!("UNCERTIFIED: {reason}")
}

/// Prepares model description and resources of an FMU with the given interfaces.
///
/// # Errors
/// [`Error::Describe`] if the frozen designs do not give a valid FMU, or the model lacks the interface.
pub fn prepare(kind: Kind, designs: Designs<'_>, interfaces: Interfaces) -> Result<Prepared, Error> {
    let inputs = inputs(designs);
    let mut resources = Resources::default();
    match interfaces {
        Interfaces::All => {}
        Interfaces::CoSimulation => resources.insert(INTERFACE_RESOURCE, "CoSimulation"),
        Interfaces::ModelExchange => resources.insert(INTERFACE_RESOURCE, "ModelExchange"),
    }
    if kind != Kind::Plant {
        for (axis, (_, stored)) in designs.iter().enumerate() {
            resources.insert(&of_axis(CONTROLLER, axis), stored.controller.to_json()?);
            if let (true, Ok(certificate)) = (stored.controller.gamma.certified, &stored.certificate) {
                resources.insert(&of_axis(CERTIFICATE, axis), certificate.as_str());
            }
            if let Some(coupling) = &stored.coupling {
                resources.insert(CERTIFICATES[axis], coupling.certificate.as_str());
            }
        }
    }
    if kind != Kind::Controller {
        let plant = designs.iter().find_map(|(_, stored)| stored.plant.as_ref()).ok_or(Error::OfHeading)?;
        resources.insert("plant.json", plant.to_json()?);
        resources.insert("vehicle.json", several::vehicle(&inputs).ok_or(Error::OfHeading)?.to_json()?);
    }
    if kind == Kind::Squid {
        let manoeuvre = several::manoeuvre(&inputs).ok_or(Error::OfHeading)?;
        resources.insert("manoeuvre.json", manoeuvre.to_json()?);
    }
    match kind {
        Kind::Plant => Ok(prepared(squid_fmu_plant::describe(&resources)?, resources)),
        Kind::Controller => Ok(prepared(squid_fmu_controller::describe(&resources)?, resources)),
        Kind::Squid => Ok(prepared(squid_fmu_loop::describe(&resources)?, resources)),
    }
}

fn prepared<M: Model>(described: Described<M>, resources: Resources) -> Prepared {
    let Described { description, xml, .. } = described;
    Prepared { identifier: description.model_identifier.clone(), xml, description, resources }
}

/// Packs a prepared FMU for `directory`, in memory, with `page` as its documentation.
///
/// # Errors
/// [`Error::NoBinary`] if the shared library has not been built.
pub fn pack(
    kind: Kind,
    prepared: Prepared,
    designs: Designs<'_>,
    page: &Rendered,
    binaries: &Binaries,
    directory: &Path,
) -> Result<Packed, Error> {
    let path = directory.join(format!("{}.fmu", prepared.identifier));
    let failed = |reason| Error::Zip { path: path.display().to_string(), reason };
    let mut entries = attached(kind, &prepared.description, &controllers(designs))
        .map_err(|reason| failed(reason.into()))?;
    for platform in &binaries.platforms {
        let binary = platform.find(kind, binaries.directory.as_deref())?;
        entries.insert(platform.entry(&prepared.identifier), read_bytes(&binary)?);
    }
    entries.insert("modelDescription.xml".into(), prepared.xml.into_bytes());
    for (file, content) in prepared.resources.iter() {
        entries.insert(format!("resources/{file}"), content.to_vec());
    }
    entries.insert(PAGE.into(), documentation(kind, designs, page));
    let bytes = zipped(&entries).map_err(failed)?;
    Ok(Packed { path, bytes, description: prepared.description })
}

/// Path of the page that importers show.
pub const PAGE: &str = "documentation/index.html";

/// Returns the bytes of [`PAGE`].
pub fn documentation(kind: Kind, designs: Designs<'_>, page: &Rendered) -> Vec<u8> {
    page.page(&about(kind, designs)).into_bytes()
}

/// Returns the files of an FMU besides description, resources, binaries and page: icons, terminals, licences.
pub(crate) fn attached(
    kind: Kind,
    description: &ModelDescription,
    designs: &[&ControllerDesign],
) -> io::Result<BTreeMap<String, Vec<u8>>> {
    let icons = ["model.png", "terminalsAndIcons/icon.png"].map(|name| (name.to_owned(), ICON.to_vec()));
    let licence = |(name, text): (&str, &str)| (format!("documentation/licenses/{name}"), text.into());
    let plug = terminals(kind, description, designs)?;
    let plug = plug.map(|text| ("terminalsAndIcons/terminalsAndIcons.xml".to_owned(), text));
    Ok(icons.into_iter().chain(LICENCES.map(licence)).chain(plug).collect())
}

/// Icon that tools show for the FMU, read from one of two paths (FMI 2.0.4, section 2.3).
const ICON: &[u8] = include_bytes!("../model.png");

/// Licences: an overview (section 2.3), Squid's own, and those of the compiled dependencies, which `tools/licences.py`
/// writes.
const LICENCES: [(&str, &str); 4] = [
    ("license.txt", include_str!("../license.txt")),
    ("LICENSE-MIT", include_str!("../LICENSE-MIT")),
    ("LICENSE-APACHE", include_str!("../LICENSE-APACHE")),
    ("third_party.txt", include_str!("../third_party.txt")),
];

/// Writes a zip with Deflate only, sorted entries and a fixed time: the same input gives the same bytes.
pub(crate) fn zipped(entries: &BTreeMap<String, Vec<u8>>) -> Result<Vec<u8>, zip::result::ZipError> {
    let mut writer = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in entries {
        let mode = if name.starts_with("binaries/") { 0o755 } else { 0o644 };
        let options = SimpleFileOptions::default()
            .compression_method(zip::CompressionMethod::Deflated)
            .compression_level(Some(9))
            .last_modified_time(zip::DateTime::default())
            .unix_permissions(mode);
        writer.start_file(name, options)?;
        writer.write_all(content)?;
    }
    Ok(writer.finish()?.into_inner())
}

/// Returns the first paragraphs of the page that importers show: the contents, and the status of the proofs.
fn about(kind: Kind, designs: Designs<'_>) -> Vec<String> {
    let steered: Vec<String> = designs.iter().map(|(_, stored)| stored.controller.steered_signal()).collect();
    let what = match kind {
        Kind::Plant if designs.iter().any(|(inputs, _)| inputs.design.view().is_level_held) => {
            "This FMU contains the vehicle: nonlinear motion in six degrees of freedom.".to_owned()
        }
        Kind::Plant => {
            "This FMU contains the vehicle: nonlinear longitudinal motion, or its LPV model.".to_owned()
        }
        Kind::Controller => format!(
            "This FMU contains the autopilot: a sampled LPV controller of {}, scheduled on forward speed.",
            steered.join(" and another of ")
        ),
        Kind::Squid => {
            "This FMU contains vehicle and autopilot in closed loop, performing a manoeuvre.".to_owned()
        }
    };
    let bounds =
        designs.iter().zip(&steered).map(|((_, stored), name)| prefixed(designs.len(), name, &bound(stored)));
    let coupling = designs.iter().find_map(|(_, stored)| stored.coupling.as_ref());
    let coupled = coupling.map(|coupling| format!("Proved: {}.", coupling.claim));
    let unproved = unproved(designs.len(), coupled.is_some()).map(str::to_owned);
    std::iter::once(what).chain(bounds).chain(coupled).chain(unproved).collect()
}

/// Returns a statement of the bound of a design and of its proof.
fn bound(stored: &Stored) -> String {
    let gamma = &stored.controller.gamma;
    let scheduling = &stored.controller.scheduling;
    if gamma.certified {
        format!(
            "Bound of the L2 gain from references and disturbances to weighted errors and commands: {}, certified in \
                exact arithmetic, for speeds from {} to {} m/s. The bound applies to the loop in continuous time \
                without saturation, and does not cover the nonlinear vehicle.",
            above(gamma.bound),
            scheduling.minimum,
            scheduling.maximum
        )
    } else {
        format!(
            "UNCERTIFIED: this controller was packed without a valid proof for the vehicle. The bound of the L2 gain \
                in its file is {}, for speeds from {} to {} m/s.",
            gamma.bound, scheduling.minimum, scheduling.maximum
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use squid_design::fit::Model;
    use squid_design::store::freeze::frozen;
    use squid_design::store::load;
    use squid_model_description::{Causality, ScalarVariable};
    use squid_scheduled::{ControllerInput, Gamma, Kind as Part, LftMatrices};

    /// Returns the committed design with additional measurements that the controller does not use.
    fn measuring(measured: &[(&str, &str)]) -> (Inputs, Stored) {
        let vehicle = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles/squid"));
        let inputs = Inputs::read(vehicle, "design").unwrap();
        let mut stored = load(&vehicle.join("frozen"), &inputs).unwrap();
        let controller = &mut stored.controller;
        let input = |&(signal, unit): &(&str, &str)| ControllerInput {
            signal: signal.into(),
            kind: Part::Measurement,
            unit: unit.into(),
            scale: 0.1,
        };
        controller.controller_inputs.extend(measured.iter().map(input));
        if let Some(failsafe) = &mut controller.failsafe {
            let pitch = failsafe.sensors["pitch"].clone();
            failsafe.sensors.extend(measured.iter().map(|(signal, _)| ((*signal).to_owned(), pitch.clone())));
        }
        let lft = &mut controller.lft;
        for row in lft.by.iter_mut().chain(&mut lft.duy).chain(&mut lft.dty) {
            row.extend(measured.iter().map(|_| 0.0));
        }
        (inputs, stored)
    }

    /// Returns an FMU without its bytes.
    fn unpacked(kind: Kind, designs: Designs<'_>) -> Packed {
        let Prepared { identifier, description, .. } = prepare(kind, designs, Interfaces::All).unwrap();
        Packed { path: identifier.into(), bytes: Vec::new(), description }
    }

    /// Returns the members of a plug.
    fn plug(kind: Kind, of: &Packed, designs: Designs<'_>) -> Vec<String> {
        let text =
            String::from_utf8(terminals(kind, &of.description, &controllers(designs)).unwrap().unwrap())
                .unwrap();
        let members = text.split("memberName=\"").skip(1).map(|rest| rest.split('"').next().unwrap());
        members.map(str::to_owned).collect()
    }

    /// Returns a function that reads files of the SSP of plant and controller by name.
    fn read_system(
        plant: &Packed,
        controller: &Packed,
        designs: Designs<'_>,
    ) -> impl FnMut(&str) -> String + use<> {
        let (_, system) = crate::ssp::pack(
            "system",
            &[(Kind::Plant, plant), (Kind::Controller, controller)],
            designs,
            Path::new(""),
        )
        .unwrap();
        let mut system = zip::ZipArchive::new(Cursor::new(system)).unwrap();
        move |name| std::io::read_to_string(system.by_name(name).unwrap()).unwrap()
    }

    #[test]
    fn connects_measured_signals() {
        let wires = |measured: &[(&str, &str)]| {
            let (inputs, stored) = measuring(measured);
            let designs = &[(&inputs, &stored)];
            let packed = |kind| unpacked(kind, designs);
            let (plant, controller) = (packed(Kind::Plant), packed(Kind::Controller));
            let plug = |kind, of| plug(kind, of, designs);
            assert_eq!(plug(Kind::Plant, &plant), plug(Kind::Controller, &controller));
            let mut read = read_system(&plant, &controller, designs);
            let structure = read("SystemStructure.ssd");
            let start = read("resources/controller_speed_0.700.ssv");
            let wired = ["pitch", "speed", "pitch_rate", "heave"].map(|name| {
                let ends =
                    format!("startConnector=\"{name}\" endElement=\"controller\" endConnector=\"{name}\"");
                (structure.contains(&ends), start.contains(&format!("ssv:Parameter name=\"{name}\"")))
            });
            (plug(Kind::Plant, &plant), wired)
        };
        let actuators = ["lower", "upper_port", "upper_starboard"];
        let (yes, no) = ((true, true), (false, false));
        assert_eq!(
            wires(&[]),
            (
                [&["pitch", "speed", "pitch_rate"][..], &actuators]
                    .concat()
                    .iter()
                    .map(|&name| name.into())
                    .collect(),
                [yes, yes, yes, no]
            )
        );
        let all = ["pitch", "speed", "pitch_rate", "heave"];
        assert_eq!(
            wires(&[("heave", "m/s")]),
            ([&all[..], &actuators].concat().iter().map(|&name| name.into()).collect(), [yes; 4])
        );
    }

    /// Returns a design of REMUS 100 whose controller does nothing.
    fn idle(axis: &str) -> (Inputs, Stored) {
        let vehicle = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../vehicles/remus100"));
        let inputs = Inputs::read_axis(vehicle, "design", Some(axis)).unwrap();
        let model = Model::new(&inputs.axis(), &inputs.design).unwrap();
        let columns = inputs.design.tracked.len() + inputs.design.measured.len();
        let rows = inputs.vehicle.actuators.len();
        let zeros = |rows: usize, columns: usize| vec![vec![0.0; columns]; rows];
        let lft = LftMatrices {
            blocks: vec![1],
            a: vec![vec![-1.0]],
            by: zeros(1, columns),
            bt: zeros(1, 1),
            cu: zeros(rows, 1),
            duy: zeros(rows, columns),
            dut: zeros(rows, 1),
            ct: zeros(1, 1),
            dty: zeros(1, columns),
            dtt: zeros(1, 1),
        };
        let gamma = Gamma { optimum: 1.0, bound: 1.0, back_off: 0.0, certified: false };
        let stored = Stored::of(&frozen(&inputs, &model, lft, gamma).unwrap(), &inputs);
        (inputs, stored)
    }

    #[test]
    fn packs_heading_design_with_another() {
        let (depth, heading) = (idle("depth"), idle("heading"));
        let first = (&depth.0, &depth.1);
        let alone = &[first];
        let both: Designs<'_> = &[first, (&heading.0, &heading.1)];

        let prepared = prepare(Kind::Controller, both, Interfaces::All).unwrap();
        let texts =
            ["controller.json", "controller_2.json"].map(|file| prepared.resources.text(file).unwrap());
        assert_eq!(texts, [&depth, &heading].map(|(_, stored)| stored.controller.to_json().unwrap()));
        assert!(prepared.xml.contains("name=\"heading_gamma\""), "{}", prepared.xml);

        let inputs = inputs(both);
        assert_eq!(several::vehicle(&inputs), Some(&depth.0.six_dof));
        let steps = several::manoeuvre(&inputs).unwrap().steps;
        assert_eq!(steps.keys().collect::<Vec<_>>(), ["depth", "heading"]);

        let (plant, controller) = (unpacked(Kind::Plant, alone), unpacked(Kind::Controller, both));
        assert_eq!(
            plug(Kind::Controller, &controller, both),
            [
                "pitch",
                "speed",
                "depth",
                "pitch_rate",
                "heading",
                "heading_rate",
                "propeller",
                "stern_planes",
                "rudder"
            ]
        );
        let mut read = read_system(&plant, &controller, both);
        let start = read("resources/controller_speed_1.736.ssv");
        for (name, value) in
            [("heading", 0.0), ("heading_rate", 0.0), ("heading_reference", steps["heading"])]
        {
            let line = format!("<ssv:Parameter name=\"{name}\">");
            let (_, found) = start.split_once(&line).unwrap_or_else(|| panic!("no {name} in {start}"));
            assert!(found.trim_start().starts_with(&format!("<ssv:Real value=\"{value:?}\"")), "{found}");
        }
        assert_eq!(start.matches("name=\"speed\"").count(), 1);

        let page = about(Kind::Controller, both);
        assert!(page[1].starts_with("depth: UNCERTIFIED") && page[2].starts_with("heading: UNCERTIFIED"));
        insta::assert_snapshot!(page[0]);
    }

    #[test]
    fn inputs_outputs_and_parameters_have_connectors() {
        let (inputs, stored) = measuring(&[]);
        let designs: Designs<'_> = &[(&inputs, &stored)];
        let [plant, controller] = [Kind::Plant, Kind::Controller].map(|kind| unpacked(kind, designs));
        let structure = read_system(&plant, &controller, designs)("SystemStructure.ssd");
        let between = |text: &str, start: &str| {
            text.split_once(start).unwrap().1.split(['"', ' ', '/', '>']).next().unwrap().to_owned()
        };
        let found: Vec<[String; 3]> = structure
            .split("<ssd:Connector ")
            .skip(1)
            .map(|one| ["name=\"", "kind=\"", "<ssc:"].map(|start| between(one, start)))
            .collect();
        let of = |one: &ScalarVariable| {
            let kind = match one.causality {
                _ if matches!(one.kind, squid_model_description::Kind::Enumeration { .. }) => return None,
                Causality::Input => "input",
                Causality::Output => "output",
                Causality::Parameter => "parameter",
                _ => return None,
            };
            let debug = format!("{:?}", one.kind);
            Some([one.name.clone(), kind.to_owned(), debug.split(' ').next().unwrap().to_owned()])
        };
        let all = plant.description.variables.iter().chain(&controller.description.variables);
        assert_eq!(found, all.filter_map(of).collect::<Vec<_>>());
        let engaged = ["engaged", "input", "Boolean"];
        assert!(found.iter().any(|connector| connector == &engaged), "{found:?}");
    }
}
