//! Writer of `modelDescription.xml` in the order of the schema (`fmi2ModelDescription.xsd`, FMI 2.0.4).

use std::fmt::Debug;
use std::io;

use crate::element::{NONE, Xml, document, leaf, number, parent};
use crate::{
    DependencyKind, Enumeration, Interfaces, Kind, LogCategory, ModelDescription, Problem, RealType,
    ScalarVariable, Unit, Unknown,
};

/// Error in writing the XML.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum WriteError {
    /// Description that violates the standard.
    #[error("the model description violates the FMI standard: {}", joined(problems))]
    Problems { problems: Vec<Problem> },
    /// Failure of the XML writer.
    #[error("the model description could not be written: {0}")]
    Writer(#[from] io::Error),
}

fn joined(problems: &[Problem]) -> String {
    problems.iter().map(Problem::to_string).collect::<Vec<_>>().join("; ")
}

type Attributes = Vec<(&'static str, String)>;

impl ModelDescription {
    /// Checks the description and returns the XML with the given GUID and interfaces; the same description gives the
    /// same bytes.
    ///
    /// # Errors
    /// [`WriteError::Problems`] if [`check`](Self::check) returns a problem.
    pub fn to_xml(&self, guid: &str, interfaces: Interfaces) -> Result<String, WriteError> {
        let problems = self.check();
        if !problems.is_empty() {
            return Err(WriteError::Problems { problems });
        }
        let bytes = document(|xml| {
            parent(xml, "fmiModelDescription", &self.root(guid), |xml| {
                if self.model_exchange && interfaces != Interfaces::CoSimulation {
                    leaf(xml, "ModelExchange", &self.model_exchange_attributes())?;
                }
                if interfaces != Interfaces::ModelExchange {
                    leaf(xml, "CoSimulation", &self.co_simulation_attributes())?;
                }
                list(xml, "UnitDefinitions", &self.units(), write_unit)?;
                self.write_types(xml)?;
                list(xml, "LogCategories", &self.log_categories, |xml, category| {
                    let LogCategory { name, description } = category;
                    leaf(xml, "Category", &[("name", name), ("description", description)])
                })?;
                leaf(xml, "DefaultExperiment", &self.experiment())?;
                parent(xml, "ModelVariables", NONE, |xml| {
                    self.variables.iter().try_for_each(|variable| self.write_variable(xml, variable))
                })?;
                self.write_structure(xml)
            })
        })?;
        String::from_utf8(bytes).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error).into())
    }

    fn root(&self, guid: &str) -> Attributes {
        vec![
            ("fmiVersion", "2.0".to_owned()),
            ("modelName", self.model_name.clone()),
            ("guid", guid.to_owned()),
            ("description", self.description.clone()),
            ("author", self.author.clone()),
            ("version", self.version.clone()),
            ("copyright", self.copyright.clone()),
            ("license", self.license.clone()),
            ("generationTool", self.generation_tool.clone()),
            ("variableNamingConvention", "structured".to_owned()),
            ("numberOfEventIndicators", "0".to_owned()),
        ]
    }

    fn model_exchange_attributes(&self) -> Attributes {
        let own = vec![("completedIntegratorStepNotNeeded", "false".to_owned())];
        [self.identity(), own, self.shared()].concat()
    }

    fn co_simulation_attributes(&self) -> Attributes {
        let flags = self.co_simulation;
        let steps = flags.can_handle_variable_communication_step_size;
        let own = vec![
            ("canHandleVariableCommunicationStepSize", steps.to_string()),
            ("canInterpolateInputs", flags.can_interpolate_inputs.to_string()),
            ("maxOutputDerivativeOrder", flags.max_output_derivative_order.to_string()),
            ("canRunAsynchronuously", "false".to_owned()),
        ];
        [self.identity(), own, self.shared()].concat()
    }

    fn identity(&self) -> Attributes {
        vec![("modelIdentifier", self.model_identifier.clone()), ("needsExecutionTool", "false".to_owned())]
    }

    fn shared(&self) -> Attributes {
        let flags = self.capabilities;
        vec![
            ("canBeInstantiatedOnlyOncePerProcess", "false".to_owned()),
            ("canNotUseMemoryManagementFunctions", "true".to_owned()),
            ("canGetAndSetFMUstate", flags.can_get_and_set_fmu_state.to_string()),
            ("canSerializeFMUstate", flags.can_serialize_fmu_state.to_string()),
            ("providesDirectionalDerivative", flags.provides_directional_derivative.to_string()),
        ]
    }

    fn experiment(&self) -> Attributes {
        let experiment = self.default_experiment;
        let mut attributes =
            vec![("startTime", number(experiment.start_time)), ("stopTime", number(experiment.stop_time))];
        attributes.extend(experiment.tolerance.map(|tolerance| ("tolerance", number(tolerance))));
        attributes.push(("stepSize", number(experiment.step_size)));
        attributes
    }

    fn write_types(&self, xml: &mut Xml) -> io::Result<()> {
        let types = self.real_types();
        if self.enumerations.is_empty() && types.is_empty() {
            return Ok(());
        }
        parent(xml, "TypeDefinitions", NONE, |xml| {
            types.iter().try_for_each(|one| write_real_type(xml, one))?;
            self.enumerations.iter().try_for_each(|one| write_enumeration(xml, one))
        })
    }

    fn write_variable(&self, xml: &mut Xml, variable: &ScalarVariable) -> io::Result<()> {
        let mut attributes = vec![
            ("name", variable.name.clone()),
            ("valueReference", variable.value_reference.to_string()),
            ("description", variable.description.clone()),
            ("causality", schema_name(variable.causality)),
            ("variability", schema_name(variable.variability)),
        ];
        attributes.extend(variable.initial().map(|one| ("initial", schema_name(one))));
        let (element, mut of_kind) = kind(&variable.kind);
        of_kind.splice(0..0, variable.real_type().map(|one| ("declaredType", one.name.to_owned())));
        let state = variable.derivative_of.as_deref().and_then(|state| self.position(state));
        of_kind.extend(state.map(|position| ("derivative", (position + 1).to_string())));
        parent(xml, "ScalarVariable", &attributes, |xml| leaf(xml, element, &of_kind))
    }

    fn write_structure(&self, xml: &mut Xml) -> io::Result<()> {
        let structure = self.structure();
        parent(xml, "ModelStructure", NONE, |xml| {
            list(xml, "Outputs", &structure.outputs, write_unknown)?;
            list(xml, "Derivatives", &structure.derivatives, write_unknown)?;
            list(xml, "InitialUnknowns", &structure.initial_unknowns, write_unknown)
        })
    }
}

fn write_unit(xml: &mut Xml, unit: &Unit) -> io::Result<()> {
    parent(xml, "Unit", &[("name", &unit.name)], |xml| {
        leaf(xml, "BaseUnit", &unit.in_base_units())?;
        unit.display_units.iter().try_for_each(|display| {
            leaf(xml, "DisplayUnit", &[("name", display.name.clone()), ("factor", number(display.factor))])
        })
    })
}

fn write_real_type(xml: &mut Xml, one: &RealType) -> io::Result<()> {
    let attributes = [("name", one.name), ("description", one.description)];
    let mut of_real = vec![("quantity", one.quantity.to_owned()), ("unit", one.unit.to_owned())];
    of_real.extend(one.display_unit().map(|unit| ("displayUnit", unit)));
    of_real.extend(one.min.map(|min| ("min", number(min))));
    of_real.extend(one.max.map(|max| ("max", number(max))));
    parent(xml, "SimpleType", &attributes, |xml| leaf(xml, "Real", &of_real))
}

fn write_enumeration(xml: &mut Xml, enumeration: &Enumeration) -> io::Result<()> {
    let attributes = [("name", &enumeration.name), ("description", &enumeration.description)];
    parent(xml, "SimpleType", &attributes, |xml| {
        parent(xml, "Enumeration", NONE, |xml| {
            enumeration.items.iter().enumerate().try_for_each(|(position, item)| {
                let value = (position + 1).to_string();
                let (name, description) = (&item.name, &item.description);
                leaf(xml, "Item", &[("name", name), ("value", &value), ("description", description)])
            })
        })
    })
}

fn kind(kind: &Kind) -> (&'static str, Attributes) {
    let mut attributes: Attributes = Vec::new();
    let mut add = |name, value: Option<String>| attributes.extend(value.map(|value| (name, value)));
    let element = match kind {
        Kind::Real { unit, display_unit, min, max, nominal, start } => {
            add("unit", unit.clone());
            add("displayUnit", display_unit.clone());
            add("min", min.map(number));
            add("max", max.map(number));
            add("nominal", nominal.map(number));
            add("start", start.map(number));
            "Real"
        }
        Kind::Integer { min, max, start } => {
            add("min", min.map(|value| value.to_string()));
            add("max", max.map(|value| value.to_string()));
            add("start", start.map(|value| value.to_string()));
            "Integer"
        }
        Kind::Boolean { start } => {
            add("start", start.map(|value| value.to_string()));
            "Boolean"
        }
        Kind::String { start } => {
            add("start", start.clone());
            "String"
        }
        Kind::Enumeration { declared_type, start } => {
            add("declaredType", Some(declared_type.clone()));
            add("start", start.map(|value| value.to_string()));
            "Enumeration"
        }
    };
    (element, attributes)
}

fn write_unknown(xml: &mut Xml, unknown: &Unknown) -> io::Result<()> {
    let mut attributes = vec![("index", unknown.index.to_string())];
    if let Some(dependencies) = &unknown.dependencies {
        let joined = |text: fn(&(usize, DependencyKind)) -> String| {
            dependencies.iter().map(text).collect::<Vec<_>>().join(" ")
        };
        attributes.push(("dependencies", joined(|(index, _)| index.to_string())));
        attributes.push(("dependenciesKind", joined(|(_, kind)| schema_name(*kind))));
    }
    leaf(xml, "Unknown", &attributes)
}

/// Writes an element with its items, or nothing without items.
fn list<T>(
    xml: &mut Xml,
    element: &'static str,
    items: &[T],
    mut write: impl FnMut(&mut Xml, &T) -> io::Result<()>,
) -> io::Result<()> {
    if items.is_empty() {
        return Ok(());
    }
    parent(xml, element, NONE, |xml| items.iter().try_for_each(|item| write(xml, item)))
}

/// Returns the spelling of a variant in the schema, with a lower-case first letter.
fn schema_name(variant: impl Debug) -> String {
    let mut schema_name = format!("{variant:?}");
    schema_name[..1].make_ascii_lowercase();
    schema_name
}
