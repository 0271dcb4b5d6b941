//! The root element `fmiModelDescription` and its small parts (section 2.2.1).

use crate::{Enumeration, ScalarVariable, Unit};

/// The content of `modelDescription.xml` but its GUID, for co-simulation and optionally model exchange.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelDescription {
    /// Name of the model, to display.
    pub model_name: String,
    /// Short C identifier: file name of the binary, and name of the FMU.
    pub model_identifier: String,
    /// What the model is, in a sentence.
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
    /// Whether the FMU supports model exchange, too.
    pub model_exchange: bool,
    /// Capabilities of the binary in both.
    pub capabilities: Capabilities,
    /// Capabilities of the binary in co-simulation.
    pub co_simulation: CoSimulation,
    /// Enumerated types that the variables refer to.
    pub enumerations: Vec<Enumeration>,
    /// Categories that the logger uses.
    pub log_categories: Vec<LogCategory>,
    /// Default start, stop, tolerance and step.
    pub default_experiment: DefaultExperiment,
    /// The variables, in the order of the XML.
    pub variables: Vec<ScalarVariable>,
}

impl ModelDescription {
    /// Units of the Real variables, each once, sorted by name.
    ///
    /// A unit that cannot be read is omitted here and reported by [`check`](Self::check).
    pub fn units(&self) -> Vec<Unit> {
        let mut names: Vec<&str> = self.variables.iter().filter_map(ScalarVariable::unit).collect();
        names.sort_unstable();
        names.dedup();
        names.into_iter().filter_map(|name| Unit::parse(name).ok()).collect()
    }

    /// Index of a variable counted from zero.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.variables.iter().position(|variable| variable.name == name)
    }
}

/// Which of the interfaces that a model has its FMU offers; some importers take only FMUs with one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interfaces {
    /// All of them.
    #[default]
    All,
    /// Co-simulation alone.
    CoSimulation,
    /// Model exchange alone.
    ModelExchange,
}

/// Capability flags of the element `CoSimulation` (section 4.3.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CoSimulation {
    /// The communication step may differ from step to step.
    pub can_handle_variable_communication_step_size: bool,
    /// `fmi2SetRealInputDerivatives` is supported.
    pub can_interpolate_inputs: bool,
    /// Highest order of `fmi2GetRealOutputDerivatives`.
    pub max_output_derivative_order: u32,
}

/// Capability flags that the elements `ModelExchange` and `CoSimulation` share (sections 3.3.1 and 4.3.1); the memory
/// callbacks are never used, and any number of instances may live in one process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Capabilities {
    /// `fmi2GetFMUstate` and `fmi2SetFMUstate` work.
    pub can_get_and_set_fmu_state: bool,
    /// The state can be turned into bytes and back.
    pub can_serialize_fmu_state: bool,
    /// `fmi2GetDirectionalDerivative` works.
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
    /// Relative tolerance, where the model integrates with one.
    pub tolerance: Option<f64>,
}

/// One category of log messages (section 2.2.4).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LogCategory {
    /// Name that `fmi2SetDebugLogging` uses.
    pub name: String,
    /// What is logged there.
    pub description: String,
}

/// The C identifier nearest to a name: lower-case letters, digits, and `_` for anything else.
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
