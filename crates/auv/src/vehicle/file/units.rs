//! Units of the numbers in a vehicle file.

use crate::toml_file::{FileProblem, Table};
use crate::vehicle::allowed::Allowed;
use crate::vehicle::file::non_dimensional::{self, Scales};

/// Units in which a number may be given: SI, and non-dimensional if the file has scales for it.
pub(super) struct Units<'a> {
    /// Scales of the section; `None` if it is absent or invalid.
    scales: Option<Scales<'a>>,
    given: bool,
}

impl<'a> Units<'a> {
    /// Reads `[non_dimensional]`, if present.
    pub(super) fn read(root: &Table<'a>) -> Self {
        Self { scales: non_dimensional::read(root), given: root.has(non_dimensional::SECTION) }
    }

    /// Reads a number and its source if the key is present, in one of the SI units or, with scales, non-dimensional.
    pub(super) fn quantity(
        &self,
        table: &Table<'_>,
        key: &str,
        units: &[&str],
        allowed: Allowed,
    ) -> Option<(f64, String)> {
        let mut accepted = units.to_vec();
        accepted.extend(self.given.then_some(non_dimensional::PRIME));
        if !self.given && table.is_in(key, non_dimensional::PRIME) {
            let meaning =
                format!("a table with system, length and density, required by '{key}' in \"prime\"");
            table.blame(key, FileProblem::MissingKey { key: non_dimensional::SECTION.into(), meaning });
            return None;
        }
        let found = table.quantity(key, &accepted, allowed)?;
        let value = match &self.scales {
            Some(scales) => scales.si(key, &found, units[0])?,
            None => found.si(),
        };
        Some((value, found.source))
    }
}
