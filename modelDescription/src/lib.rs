//! Typed FMI 2.0 model description:
//!
//! ```text
//! variables, units, capabilities -> GUID -> check -> XML
//! ```
//!
//! The standard is the Functional Mock-up Interface for Model Exchange and Co-Simulation,
//! version 2.0.4 (Modelica Association, 2022); section numbers in this crate refer to it.
//!
//! Redundant parts of the XML are derived, so that they are consistent: unit definitions and declared types follow from
//! units and ranges of the variables, and `ModelStructure` from their causality and dependencies.

mod check;
mod description;
pub mod element;
mod enumeration;
mod guid;
mod problem;
mod real_type;
mod structure;
mod unit;
mod variable;
mod xml;

pub use description::{
    Capabilities, CoSimulation, DefaultExperiment, Interfaces, LogCategory, ModelDescription, identifier,
};
pub use enumeration::{Enumeration, Item};
pub use guid::guid;
pub use problem::Problem;
pub use real_type::RealType;
pub use structure::{ModelStructure, Unknown};
pub use unit::{BaseUnit, DisplayUnit, Unit, UnitError};
pub use variable::{Causality, Dependency, DependencyKind, Initial, Kind, ScalarVariable, Variability};
pub use xml::WriteError;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
