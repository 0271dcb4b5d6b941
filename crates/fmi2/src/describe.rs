//! From resources to model, description and GUID; packager and binary share this code, and the packager
//! writes the XML.

use model_description::{Capabilities, CoSimulation, ModelDescription, WriteError, guid};

use crate::log::Category;
use crate::refusal::LoadError;
use crate::{Model, Resources, Table};

/// A loaded model with its XML.
#[derive(Debug)]
pub struct Described<M> {
    /// The model with its start values.
    pub model: M,
    /// Its variables.
    pub table: Table<M>,
    /// Its description.
    pub description: ModelDescription,
    /// GUID over description and resources.
    pub guid: String,
    /// `modelDescription.xml`.
    pub xml: String,
}

/// Why a model cannot be described.
#[derive(Debug, thiserror::Error)]
pub enum DescribeError {
    /// The model could not be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// The table of variables breaks the standard.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Loads a model and writes its XML with the GUID that the binary will require.
///
/// # Errors
/// [`DescribeError`].
pub fn describe<M: Model>(resources: &Resources) -> Result<Described<M>, DescribeError> {
    let (model, table, description, guid) = load(resources)?;
    let xml = description.to_xml(&guid)?;
    Ok(Described { model, table, description, guid, xml })
}

/// A model with its variables, its description and its GUID.
type Loaded<M> = (M, Table<M>, ModelDescription, String);

/// Loads a model. The packager has checked its description against the standard, and the GUID shows that it is the
/// same.
///
/// # Errors
/// [`LoadError`].
pub(crate) fn load<M: Model>(resources: &Resources) -> Result<Loaded<M>, LoadError> {
    let model = M::load(resources).map_err(|error| LoadError(Box::new(error)))?;
    let table = Table::of(&model);
    let description = description_of(&model, &table);
    let guid = guid(&description, resources.iter());
    Ok((model, table, description, guid))
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
