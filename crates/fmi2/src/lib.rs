//! FMI 2.0 export for co-simulation and model exchange, without any model:
//!
//! ```text
//! resources -> Model::load -> variable table -> model description and GUID      (the packager, `describe`)
//!                                            -> instance -> C functions          (the binary, `export!`)
//! ```
//!
//! A model implements [`Model`] and writes its table of variables once; value references, XML, GUID, get and
//! set follow from that table. The table is built at run time from the files in `resources/`, because a
//! binary contains no vehicle.
//!
//! The standard is FMI 2.0.4 (Modelica Association, 2022); section numbers refer to it. `unsafe` code is
//! confined to [`abi`].

pub mod abi;
mod describe;
mod exchange;
mod instance;
mod legal;
mod log;
mod model;
mod phase;
mod refusal;
mod resources;
mod states;
mod uri;
mod variables;

pub use describe::{DescribeError, Described, INTERFACE_RESOURCE, describe};
pub use exchange::Events;
pub use instance::{Instance, rounding_of_time};
pub use legal::Function;
pub use log::{Category, Log, Silent};
pub use model::{About, Model, Moment, Tangents};
pub use phase::{Interface, Phase};
pub use refusal::{Failure, LoadError, Refusal};
pub use resources::{ResourceError, Resources};
pub use squid_model_description as model_description;
pub use states::bytes::{SavedState, StateError};
pub use states::snapshot::{Experiment, Snapshot};
pub use uri::{UriError, path_of};
pub use variables::role::Role;
pub use variables::table::Table;
pub use variables::values::Value;
pub use variables::variable::Variable;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
