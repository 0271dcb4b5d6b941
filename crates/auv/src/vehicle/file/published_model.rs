//! Optional section `[published_linear_model]` of a vehicle file: the linear model printed in its source.

use nalgebra::Complex;

use crate::toml_file::Table;
use crate::vehicle::PublishedLinearModel;
use crate::vehicle::allowed::Allowed;

/// Name of the section.
pub(super) const SECTION: &str = "published_linear_model";

const SPEED: &str = "speed";
const POLES: &str = "poles";

/// Reads the section, if present.
pub(super) fn read(root: &Table<'_>) -> Option<PublishedLinearModel> {
    let table = root.table(SECTION)?;
    table.allow_only(&[SPEED, POLES, "source", "note"]);
    let speed = table.requires(SPEED, "the speed of the linear model");
    let speed = speed.then(|| table.quantity(SPEED, &["m/s"], Allowed::Positive)).flatten();
    let poles = table.pairs(POLES, "one or more pairs [real part, imaginary part] in rad/s");
    let (source, note) = (table.text("source"), table.text("note"));
    Some(PublishedLinearModel {
        speed: speed?.value,
        poles: poles?.into_iter().map(|[re, im]| Complex::new(re, im)).collect(),
        source: source?,
        note: note?,
    })
}
