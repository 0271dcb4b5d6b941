//! What the XML files of SSP and terminals share.

use model_description::{Causality, Kind, ModelDescription, ScalarVariable};

/// Real inputs and outputs in their order.
pub(crate) fn real(description: &ModelDescription) -> impl Iterator<Item = &ScalarVariable> {
    let is_connected = |one: &&ScalarVariable| matches!(one.causality, Causality::Input | Causality::Output);
    let variables = description.variables.iter();
    variables.filter(move |one| is_connected(one) && matches!(one.kind, Kind::Real { .. }))
}
