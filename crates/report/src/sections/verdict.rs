//! Requirements of the design, and figures of the loop as flown.

use crate::error::Error;
use crate::page::{Part, Table};
use crate::subject::Subject;
use squid_design::verdict::row::{Outcome, Row};

/// Returns the section with the table of the verdict.
///
/// # Errors
/// Errors of [`Subject::verdict`].
pub fn verdict(subject: &Subject) -> Result<Vec<Part>, Error> {
    let verdict = subject.verdict()?;
    let mut table = Table::new(["what", "required", "worst value", "", "where"]);
    let row = |row: &Row| {
        vec![row.name.clone(), row.required(), row.found(), row.outcome.to_string(), row.achieved.condition()]
    };
    table.rows = verdict.rows.iter().map(row).collect();
    if verdict.missed().next().is_some() {
        table.head.push("advice".into());
        for (cells, row) in table.rows.iter_mut().zip(&verdict.rows) {
            let missed = if row.outcome == Outcome::Missed { "`squid design` searches for it" } else { "" };
            cells.push(row.advice.as_ref().map_or(missed, |advice| &advice.text).into());
        }
    }
    let summary = format!(
        "For {}: {}. The limits are those of [require] in {}, or defaults.",
        subject.name(),
        verdict.summary(),
        subject.inputs.design.file
    );
    Ok(vec![Part::Text(summary), Part::Table(table)])
}
