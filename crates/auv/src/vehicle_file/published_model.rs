//! The section `[published_linear_model]`, which a vehicle file may have: what its source prints as the linear model.

use nalgebra::Complex;

use super::error::{FileProblem, VehicleFileError};
use super::table::Table;
use crate::coefficients::Allowed;
use crate::vehicle::PublishedLinearModel;

/// Its name.
pub(super) const SECTION: &str = "published_linear_model";

const SPEED: &str = "speed";
const POLES: &str = "poles";

/// Reads the section, if it is there.
pub(super) fn read(root: &Table<'_>) -> Result<Option<PublishedLinearModel>, VehicleFileError> {
    let Some(table) = root.table(SECTION)? else { return Ok(None) };
    table.allow_only(&[SPEED, POLES, "source", "note"])?;
    let Some(speed) = table.quantity(SPEED, &["m/s"])? else {
        return Err(table.missing(SPEED, "the speed of the linear model"));
    };
    speed.check(Allowed::Positive)?;
    let poles = table.pairs(POLES, "pairs [real part, imaginary part] in rad/s, one or more")?;
    if let Some(found) = poles.iter().flatten().copied().find(|part| !part.is_finite()) {
        let (key, unit) = (table.full(POLES), "rad/s".into());
        let allowed = Allowed::Any.describe();
        return Err(table.blame(POLES, FileProblem::NotAllowed { key, found, unit, allowed }));
    }
    Ok(Some(PublishedLinearModel {
        speed: speed.value,
        poles: poles.into_iter().map(|[re, im]| Complex::new(re, im)).collect(),
        source: table.text("source")?,
        note: table.text("note")?,
    }))
}
