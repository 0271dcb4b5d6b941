//! Plant and controller connected as one system, in System Structure and Parameterization (SSP) 1.0:
//!
//! ```text
//! SystemStructure.ssd     default variant, at a speed V at the centre of the range
//! speed_V.ssd             one variant for each other speed V along the path
//! resources/*.fmu         both FMUs
//! resources/*_V.ssv       start values of each for that speed: trim, with a constant reference a step above it
//! ```
//!
//! The parameter sets are bound to the components, not to the system, and the references are inputs of the component
//! `controller`, not of the system: libcosim and Ecos ignore or refuse the alternatives. Section numbers are those of
//! "System Structure and Parameterization", version 1.0 (Modelica Association, 2019).

mod types;

use crate::axes::{Designs, inputs};
use crate::error::Error;
use crate::fmu::{Packed, zipped};
use crate::kind::Kind;
use crate::ssp::types::{connected, connectors, of_connectors, units};
use squid_auv::{Motion, State, TrimPoint, VIEWS};
use squid_design::axis::several;
use squid_model_description::element::{NONE, Xml, document, leaf, parent};
use squid_model_description::{Causality, ModelDescription, ScalarVariable};
use squid_scheduled::Manoeuvre;
use squid_signals::Signal;
use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};

/// Number of speeds with a variant.
const VARIANTS: usize = 6;

const SSD: &str = "http://ssp-standard.org/SSP1/SystemStructureDescription";
const SSC: &str = "http://ssp-standard.org/SSP1/SystemStructureCommon";
const SSV: &str = "http://ssp-standard.org/SSP1/SystemStructureParameterValues";
/// Namespace of OMSimulator's annotations (`schema/oms.xsd` of that project).
const OMS: &str = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd";
/// Tolerance required by OMSimulator's schema; a master with a fixed step does not use it.
const UNUSED_TOLERANCE: &str = "0.0001";
const TOOL: &str = concat!("squid ", env!("CARGO_PKG_VERSION"));

/// A component of the system: its kind and its FMU.
pub type Component<'a> = (Kind, &'a Packed);

/// Packs the system of some components, in memory, and returns its path in `directory`. Each output of a component is
/// connected to the inputs of the same name of the others.
///
/// # Errors
/// [`Error::Zip`], [`Error::Ssp`].
pub fn pack(
    name: &str,
    components: &[Component<'_>],
    designs: Designs<'_>,
    directory: &Path,
) -> Result<(PathBuf, Vec<u8>), Error> {
    let path = directory.join(format!("{name}.ssp"));
    let failed = |reason| Error::Ssp { path: path.display().to_string(), reason };
    let mut entries: BTreeMap<String, Vec<u8>> = BTreeMap::new();
    for (_, packed) in components {
        entries.insert(source(packed), packed.bytes.clone());
    }
    let Some(((_, stored), manoeuvre)) = designs.first().zip(several::manoeuvre(&inputs(designs))) else {
        return Err(Error::OfHeading);
    };
    let model = stored.plant.as_ref().ok_or(Error::OfHeading)?;
    let points = speeds(&model.trim);
    for (index, point) in points.iter().enumerate() {
        let variant = format!("speed_{:.3}", point.speed);
        let system = System {
            name,
            variant: &variant,
            components,
            duration: manoeuvre.duration,
            sample_time: stored.controller.sample_time,
        };
        let is_default = index == (points.len() - 1) / 2;
        let file = if is_default { "SystemStructure" } else { &variant };
        entries.insert(format!("{file}.ssd"), system.description().map_err(failed)?);
        for (kind, packed) in components {
            let values = start_values(*kind, packed, (point, model.depth), &manoeuvre);
            let set = parameter_set(&variant, &packed.description, &values).map_err(failed)?;
            entries.insert(values_file(*kind, &variant), set);
        }
    }
    let packed =
        zipped(&entries).map_err(|reason| Error::Zip { path: path.display().to_string(), reason })?;
    Ok((path, packed))
}

/// Returns rows of the trim table, spread evenly and away from both ends, because a step overshoots.
fn speeds(trim: &[TrimPoint]) -> Vec<&TrimPoint> {
    let last = trim.len().saturating_sub(1);
    let mut rows: Vec<usize> =
        (0..VARIANTS).map(|k| (last * (2 * k + 1) + VARIANTS) / (2 * VARIANTS)).collect();
    rows.dedup();
    rows.iter().filter_map(|&row| trim.get(row)).collect()
}

/// Returns the start values of a component: the plant in trim at the speed, the references a step above it.
fn start_values(
    kind: Kind,
    packed: &Packed,
    (at, depth): (&TrimPoint, f64),
    manoeuvre: &Manoeuvre,
) -> Vec<(&'static str, f64)> {
    let values = match kind {
        Kind::Plant => vec![
            ("initial_speed", at.speed),
            ("operating_speed", at.speed),
            ("given_speed", at.forward_speed),
        ],
        _ => {
            let level =
                State::in_plane(Motion::in_plane(at.forward_speed, at.heave, 0.0, at.pitch), 0.0, depth);
            let mut values: Vec<(&str, f64)> = Vec::new();
            for view in VIEWS {
                // Every view has the speed.
                let is_new = |(name, _): &(&str, f64)| values.iter().all(|(other, _)| other != name);
                let new = signals_and_references(view.interface.signals, &view.measured(&level), manoeuvre);
                let new: Vec<_> = new.into_iter().filter(is_new).collect();
                values.extend(new);
            }
            values
        }
    };
    let known = |name: &str| packed.description.variables.iter().any(|variable| variable.name == name);
    values.into_iter().filter(|(name, _)| known(name)).collect()
}

/// Returns the signals of an axis in level flight, and its references a step above them.
fn signals_and_references(
    signals: &[Signal],
    level: &[f64],
    manoeuvre: &Manoeuvre,
) -> Vec<(&'static str, f64)> {
    let each = || signals.iter().zip(level);
    let step = |(signal, level): (&Signal, &f64)| {
        Some((signal.reference?.name, level + manoeuvre.step(signal.name)))
    };
    each().map(|(signal, level)| (signal.name, *level)).chain(each().filter_map(step)).collect()
}

fn values_file(kind: Kind, variant: &str) -> String {
    format!("resources/{}_{variant}.ssv", component(kind))
}

fn source(packed: &Packed) -> String {
    format!("resources/{}.fmu", packed.description.model_identifier)
}

fn component(kind: Kind) -> &'static str {
    match kind {
        Kind::Plant => "plant",
        Kind::Controller => "controller",
        Kind::Squid => "loop",
    }
}

/// One variant of the system.
struct System<'a> {
    name: &'a str,
    variant: &'a str,
    components: &'a [Component<'a>],
    duration: f64,
    sample_time: f64,
}

impl System<'_> {
    /// Returns the system structure description (section 5.2). Its name distinguishes the variants (section 5.2,
    /// attribute `name`).
    fn description(&self) -> io::Result<Vec<u8>> {
        document(|xml| {
            let root = [
                ("xmlns:ssd", SSD),
                ("xmlns:ssc", SSC),
                ("xmlns:ssv", SSV),
                ("version", "1.0"),
                ("name", self.variant),
                ("generationTool", TOOL),
            ];
            parent(xml, "ssd:SystemStructureDescription", &root, |xml| {
                let about =
                    format!("vehicle and autopilot in closed loop, {} m/s", &self.variant["speed_".len()..]);
                let system = [("name", self.name), ("description", about.as_str())];
                parent(xml, "ssd:System", &system, |xml| self.system(xml))?;
                let of_all = self.components.iter().flat_map(|(_, one)| of_connectors(&one.description));
                units(xml, "ssd:Units", of_all.collect())?;
                let stop = format!("{:?}", self.duration);
                leaf(xml, "ssd:DefaultExperiment", &[("startTime", "0.0"), ("stopTime", stop.as_str())])
            })
        })
    }

    fn system(&self, xml: &mut Xml) -> io::Result<()> {
        parent(xml, "ssd:Elements", NONE, |xml| {
            self.components.iter().try_for_each(|(kind, packed)| self.component(xml, *kind, packed))
        })?;
        parent(xml, "ssd:Connections", NONE, |xml| {
            let pairs =
                self.components.iter().flat_map(|from| self.components.iter().map(move |to| (from, to)));
            pairs.filter(|(from, to)| from.0 != to.0).try_for_each(|(from, to)| connections(xml, *from, *to))
        })?;
        self.master(xml)
    }

    /// Writes the step of the master, one sample time of the controller, as the annotation that OMSimulator reads and
    /// other tools ignore.
    fn master(&self, xml: &mut Xml) -> io::Result<()> {
        let step = format!("{:?}", self.sample_time);
        let master =
            [("description", "oms-ma"), ("stepSize", step.as_str()), ("relativeTolerance", UNUSED_TOLERANCE)];
        let annotation = [("type", "org.openmodelica"), ("xmlns:oms", OMS)];
        parent(xml, "ssd:Annotations", NONE, |xml| {
            parent(xml, "ssc:Annotation", &annotation, |xml| {
                parent(xml, "oms:Annotations", NONE, |xml| {
                    parent(xml, "oms:SimulationInformation", NONE, |xml| {
                        leaf(xml, "oms:FixedStepMaster", &master)
                    })
                })
            })
        })
    }

    fn component(&self, xml: &mut Xml, kind: Kind, packed: &Packed) -> io::Result<()> {
        let fmu = source(packed);
        let attributes = [
            ("name", component(kind)),
            ("type", "application/x-fmu-sharedlibrary"),
            ("source", fmu.as_str()),
            ("implementation", "CoSimulation"),
        ];
        parent(xml, "ssd:Component", &attributes, |xml| {
            parent(xml, "ssd:Connectors", NONE, |xml| connectors(xml, &packed.description))?;
            let values = values_file(kind, self.variant);
            let binding = [("type", "application/x-ssp-parameter-set"), ("source", values.as_str())];
            parent(xml, "ssd:ParameterBindings", NONE, |xml| leaf(xml, "ssd:ParameterBinding", &binding))
        })
    }
}

/// Connects each output of one component to the input of that name of the other (section 5.3.3).
fn connections(xml: &mut Xml, from: Component<'_>, to: Component<'_>) -> io::Result<()> {
    for one in connected(&from.1.description).filter(|one| one.causality == Causality::Output) {
        let name = one.name.as_str();
        let takes = |other: &ScalarVariable| other.name == name && other.causality == Causality::Input;
        if connected(&to.1.description).any(takes) {
            let ends = [
                ("startElement", component(from.0)),
                ("startConnector", name),
                ("endElement", component(to.0)),
                ("endConnector", name),
            ];
            leaf(xml, "ssd:Connection", &ends)?;
        }
    }
    Ok(())
}

/// Returns a set of start values, with their units (section 6).
fn parameter_set(name: &str, of: &ModelDescription, values: &[(&str, f64)]) -> io::Result<Vec<u8>> {
    let unit = |name: &str| of.variables.iter().find(|one| one.name == name).and_then(ScalarVariable::unit);
    document(|xml| {
        let root = [
            ("xmlns:ssv", SSV),
            ("xmlns:ssc", SSC),
            ("version", "1.0"),
            ("name", name),
            ("generationTool", TOOL),
        ];
        parent(xml, "ssv:ParameterSet", &root, |xml| {
            parent(xml, "ssv:Parameters", NONE, |xml| {
                values.iter().try_for_each(|(name, value)| parameter(xml, name, *value, unit(name)))
            })?;
            units(xml, "ssv:Units", values.iter().filter_map(|(name, _)| unit(name)).collect())
        })
    })
}

fn parameter(xml: &mut Xml, name: &str, value: f64, unit: Option<&str>) -> io::Result<()> {
    let text = format!("{value:?}");
    let mut attributes = vec![("value", text.as_str())];
    attributes.extend(unit.map(|unit| ("unit", unit)));
    parent(xml, "ssv:Parameter", &[("name", name)], |xml| leaf(xml, "ssv:Real", &attributes))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(count: usize) -> Vec<TrimPoint> {
        let row = |k: usize| TrimPoint {
            speed: k as f64,
            forward_speed: k as f64,
            heave: 0.0,
            pitch: 0.0,
            actuators: Vec::new(),
        };
        (0..count).map(row).collect()
    }

    fn chosen(count: usize) -> Vec<f64> {
        speeds(&table(count)).iter().map(|point| point.speed).collect()
    }

    #[test]
    fn spreads_speeds_evenly_inside_the_range() {
        assert_eq!(chosen(26), [2.0, 6.0, 10.0, 15.0, 19.0, 23.0]);
        assert_eq!(chosen(61), [5.0, 15.0, 25.0, 35.0, 45.0, 55.0]);
    }

    #[test]
    fn short_table_gives_each_row_once() {
        assert_eq!(chosen(2), [0.0, 1.0]);
        assert_eq!(chosen(3), [0.0, 1.0, 2.0]);
    }
}
