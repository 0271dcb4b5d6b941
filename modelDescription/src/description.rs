//! Root element `fmiModelDescription` and its small parts (section 2.2.1).

use crate::{Enumeration, ScalarVariable, Unit};

/// Content of `modelDescription.xml` except its GUID, for co-simulation and optionally model exchange.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelDescription {
    /// Displayed name of the model.
    pub model_name: String,
    /// Short C identifier: file name of the binary, and name of the FMU.
    pub model_identifier: String,
    /// Description of the model in one sentence.
    pub description: String,
    /// Author of the model.
    pub author: String,
    /// Version of the model.
    pub version: String,
    /// Holder of the copyright.
    pub copyright: String,
    /// Licence of the model, as an SPDX expression.
    pub license: String,
    /// Tool that wrote the XML.
    pub generation_tool: String,
    /// `true` if the FMU also supports model exchange.
    pub model_exchange: bool,
    /// Capabilities of the binary in both interfaces.
    pub capabilities: Capabilities,
    /// Capabilities of the binary in co-simulation.
    pub co_simulation: CoSimulation,
    /// Enumerated types of the variables.
    pub enumerations: Vec<Enumeration>,
    /// Categories of log messages.
    pub log_categories: Vec<LogCategory>,
    /// Default start, stop, tolerance and step.
    pub default_experiment: DefaultExperiment,
    /// Variables, in the order of the XML.
    pub variables: Vec<ScalarVariable>,
}

impl ModelDescription {
    /// Returns the units of the Real variables, each once, sorted by name.
    ///
    /// A unit that cannot be read is omitted here and reported by [`check`](Self::check).
    pub fn units(&self) -> Vec<Unit> {
        let mut names: Vec<&str> = self.variables.iter().filter_map(ScalarVariable::unit).collect();
        names.sort_unstable();
        names.dedup();
        names.into_iter().filter_map(|name| Unit::parse(name).ok()).collect()
    }

    /// Returns the index of a variable, from 0.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.variables.iter().position(|variable| variable.name == name)
    }
}

/// Interfaces of a model that its FMU offers; some importers accept only FMUs with one interface.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interfaces {
    /// All interfaces of the model.
    #[default]
    All,
    /// Co-simulation only.
    CoSimulation,
    /// Model exchange only.
    ModelExchange,
}

/// Capability flags of the element `CoSimulation` (section 4.3.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CoSimulation {
    /// `true` if the communication step size may vary.
    pub can_handle_variable_communication_step_size: bool,
    /// `true` if `fmi2SetRealInputDerivatives` is supported.
    pub can_interpolate_inputs: bool,
    /// Highest order of `fmi2GetRealOutputDerivatives`.
    pub max_output_derivative_order: u32,
}

/// Capability flags common to the elements `ModelExchange` and `CoSimulation` (sections 3.3.1 and 4.3.1); the memory
/// callbacks are never used, and a process may contain any number of instances.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Capabilities {
    /// `true` if `fmi2GetFMUstate` and `fmi2SetFMUstate` are supported.
    pub can_get_and_set_fmu_state: bool,
    /// `true` if the state can be serialised and deserialised.
    pub can_serialize_fmu_state: bool,
    /// `true` if `fmi2GetDirectionalDerivative` is supported.
    pub provides_directional_derivative: bool,
}

/// Element `DefaultExperiment`, times in seconds (section 2.2.5).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DefaultExperiment {
    /// Start time in s.
    pub start_time: f64,
    /// Stop time in s.
    pub stop_time: f64,
    /// Communication step in s.
    pub step_size: f64,
    /// Relative tolerance, if the model integrates with one.
    pub tolerance: Option<f64>,
}

/// Category of log messages (section 2.2.4).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogCategory {
    /// Name for `fmi2SetDebugLogging`.
    pub name: String,
    /// Description of the logged messages.
    pub description: String,
}

/// Converts a name to a C identifier: lower-case letters, digits, and `_` for anything else.
///
/// ```
/// assert_eq!(squid_model_description::identifier("REMUS 100 (2001)"), "remus_100_2001");
/// assert_eq!(squid_model_description::identifier("100"), "_100");
/// ```
pub fn identifier(name: &str) -> String {
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let joined = words.collect::<Vec<_>>().join("_").to_ascii_lowercase();
    if joined.starts_with(|c: char| c.is_ascii_digit()) { format!("_{joined}") } else { joined }
}
