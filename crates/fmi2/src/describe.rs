//! Model, description and GUID from the resources; packager and binary share this code, and the packager
//! writes the XML.

use squid_model_description::{Capabilities, CoSimulation, Interfaces, ModelDescription, WriteError, guid};

use crate::log::Category;
use crate::refusal::LoadError;
use crate::{Interface, Model, ResourceError, Resources, Table};

/// The resource that names the only interface of an FMU: `CoSimulation` or `ModelExchange`. Without it, the FMU has all
/// interfaces of its model.
pub const INTERFACE_RESOURCE: &str = "interface.txt";

/// A loaded model with its XML.
#[derive(Debug)]
pub struct Described<M> {
    /// The model with its start values.
    pub model: M,
    /// Table of variables.
    pub table: Table<M>,
    /// Model description.
    pub description: ModelDescription,
    /// GUID over description and resources.
    pub guid: String,
    /// `modelDescription.xml`.
    pub xml: String,
}

/// Reason for which a model cannot be described.
#[derive(Debug, thiserror::Error)]
pub enum DescribeError {
    /// The model could not be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The table of variables violates the standard.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Loads a model and writes its XML with the GUID that the binary will require.
///
/// # Errors
/// Returns a [`DescribeError`] if the model cannot be loaded or its description cannot be written.
pub fn describe<M: Model>(resources: &Resources) -> Result<Described<M>, DescribeError> {
    let Loaded { model, table, description, guid, interfaces } = load(resources)?;
    let xml = description.to_xml(&guid, interfaces)?;
    Ok(Described { model, table, description, guid, xml })
}

/// A model with its variables, its description, its GUID, and the interfaces that its FMU offers.
pub(crate) struct Loaded<M> {
    pub(crate) model: M,
    pub(crate) table: Table<M>,
    description: ModelDescription,
    pub(crate) guid: String,
    pub(crate) interfaces: Interfaces,
}

/// Loads a model. The packager has checked its description against the standard, and the GUID shows that it is
/// unchanged.
///
/// # Errors
/// Returns a [`LoadError`] if the resources are missing or invalid.
pub(crate) fn load<M: Model>(resources: &Resources) -> Result<Loaded<M>, LoadError> {
    let model = M::load(resources).map_err(|error| LoadError(Box::new(error)))?;
    let table = Table::of(&model);
    let description = description_of(&model, &table);
    let guid = guid(&description, resources.iter());
    let interfaces = interfaces::<M>(resources)?;
    Ok(Loaded { model, table, description, guid, interfaces })
}

/// Error for an [`INTERFACE_RESOURCE`] that names no interface of the model.
#[derive(Debug, thiserror::Error)]
#[error("resources/{INTERFACE_RESOURCE} is '{found}'; it must be {allowed}")]
struct WrongInterface {
    found: String,
    allowed: &'static str,
}

fn interfaces<M: Model>(resources: &Resources) -> Result<Interfaces, LoadError> {
    match resources.text(INTERFACE_RESOURCE) {
        Err(ResourceError::Missing { .. }) => Ok(Interfaces::All),
        Err(error) => Err(LoadError(Box::new(error))),
        Ok("CoSimulation") => Ok(Interfaces::CoSimulation),
        Ok("ModelExchange") if M::MODEL_EXCHANGE => Ok(Interfaces::ModelExchange),
        Ok(found) => {
            let allowed = if M::MODEL_EXCHANGE { "CoSimulation or ModelExchange" } else { "CoSimulation" };
            Err(LoadError(Box::new(WrongInterface { found: found.to_owned(), allowed })))
        }
    }
}

/// Returns `true` if an FMU with these interfaces can be instantiated for one of them.
pub(crate) fn offers(interfaces: Interfaces, interface: Interface) -> bool {
    match interfaces {
        Interfaces::All => true,
        Interfaces::CoSimulation => interface == Interface::CoSimulation,
        Interfaces::ModelExchange => interface == Interface::ModelExchange,
    }
}

fn description_of<M: Model>(model: &M, table: &Table<M>) -> ModelDescription {
    let about = model.about();
    let described = |(reference, entry): (u32, &crate::Variable<M>)| entry.described(reference, model);
    ModelDescription {
        model_name: about.name,
        model_identifier: about.identifier,
        description: about.description,
        author: env!("CARGO_PKG_AUTHORS").to_owned(),
        version: about.version,
        copyright: concat!("Copyright ", env!("CARGO_PKG_AUTHORS")).to_owned(),
        license: env!("CARGO_PKG_LICENSE").to_owned(),
        generation_tool: concat!("squid ", env!("CARGO_PKG_VERSION")).to_owned(),
        model_exchange: M::MODEL_EXCHANGE,
        capabilities: Capabilities {
            can_get_and_set_fmu_state: true,
            can_serialize_fmu_state: true,
            provides_directional_derivative: M::tangents().is_some(),
        },
        co_simulation: CoSimulation {
            can_handle_variable_communication_step_size: true,
            can_interpolate_inputs: table.interpolates(),
            max_output_derivative_order: u32::from(M::MODEL_EXCHANGE && M::tangents().is_some()),
        },
        enumerations: about.enumerations,
        log_categories: Category::ALL.map(Category::described).to_vec(),
        default_experiment: about.default_experiment,
        variables: (0..).zip(table.variables()).map(described).collect(),
    }
}
