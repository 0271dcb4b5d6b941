//! Verdict on a finished design: the requirements, and the figures that the loop achieves in flight.
//!
//! There are three kinds of figures, each reported with its worst condition:
//!
//! ```text
//! frozen   the sampled loop with the true linearisation at many speeds: margins, steady errors, gust, noise, gain
//! flown    the nonlinear vehicle under its autopilot: steps of each reference at some speeds, the default flight
//! mu       a bound over all frequencies at some speeds, for the declared uncertainty
//! ```

pub mod beyond;
pub mod corners;
pub mod flown;
pub mod found;
pub mod frozen;
pub mod held;
pub mod mu;
pub mod row;
mod rows;

use crate::error::Error;
use crate::inputs::Inputs;
use crate::verdict::found::{Effort, Found};
use crate::verdict::row::{Outcome, Row, StoredRow};
use serde::Serialize;
use squid_scheduled::ControllerDesign;
use std::fmt::{self, Display, Formatter};

/// Requirements and achieved figures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Verdict {
    /// Rows of the table.
    pub rows: Vec<Row>,
    /// Figures over the range of speed.
    #[serde(flatten)]
    pub found: Found,
}

impl Verdict {
    /// Assesses a frozen controller of a design.
    ///
    /// # Errors
    /// The errors of [`Found::of`].
    pub fn of(inputs: &Inputs, controller: &ControllerDesign, effort: Effort) -> Result<Self, Error> {
        Ok(Self::judge(inputs, controller.gamma.bound, Found::of(inputs, controller, effort)?))
    }

    /// Assesses figures of a design with a bound gamma by the requirements of its file.
    pub fn judge(inputs: &Inputs, gamma: f64, found: Found) -> Self {
        Self { rows: rows::rows(inputs, gamma, &found, &[]), found }
    }

    /// Assesses a stored design like [`Verdict::of`], but with the slow figures, mu and the gain between the ticks,
    /// from the stored rows.
    ///
    /// # Errors
    /// The errors of [`Found::of`].
    pub fn of_stored(
        inputs: &Inputs,
        controller: &ControllerDesign,
        rows: &[StoredRow],
    ) -> Result<Self, Error> {
        let effort = Effort { sampled: false, mu: 0, ..Effort::FULL };
        let found = Found::of(inputs, controller, effort)?;
        Ok(Self { rows: rows::rows(inputs, controller.gamma.bound, &found, rows), found })
    }

    /// Returns the rows whose requirement is missed.
    pub fn missed(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().filter(|row| row.outcome == Outcome::Missed)
    }

    /// Returns `true` if every requirement that another verdict of the design meets is met.
    pub fn meets_all_of(&self, other: &Self) -> bool {
        self.missed().all(|row| other.missed().any(|missed| missed.name == row.name))
    }

    /// Returns the advice for each missed row, if any, one line each.
    pub fn advice(&self) -> String {
        let line = |row: &Row| {
            let text = &row.advice.as_ref()?.text;
            Some(format!("{} {} ({}): {text}", row.name, row.found(), row.required()))
        };
        self.missed().filter_map(line).collect::<Vec<_>>().join("\n")
    }

    /// Returns one line with the numbers of requirements that are met and missed.
    pub fn summary(&self) -> String {
        let count = |outcome| self.rows.iter().filter(|row| row.outcome == outcome).count();
        match count(Outcome::Missed) {
            0 => format!("all {} requirements are met", count(Outcome::Met)),
            missed => format!("{missed} of {} requirements MISSED", missed + count(Outcome::Met)),
        }
    }
}

impl Display for Verdict {
    /// Writes the summary, one line per row, and the advice.
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let cells = |row: &Row| [row.outcome.to_string(), row.name.clone(), row.required(), row.found()];
        let rows: Vec<[String; 4]> = self.rows.iter().map(cells).collect();
        let width = |column: usize| rows.iter().map(|cells| cells[column].chars().count()).max().unwrap_or(0);
        let [outcomes, names, required, found] = [0, 1, 2, 3].map(width);
        f.write_str(&self.summary())?;
        for (row, [outcome, name, limit, value]) in self.rows.iter().zip(&rows) {
            let condition = row.achieved.condition();
            let line = format!(
                "{outcome:<outcomes$}  {name:<names$}  {limit:<required$}  {value:<found$}  {condition}"
            );
            write!(f, "\n{}", line.trim_end())?;
        }
        self.advice().lines().try_for_each(|line| write!(f, "\n{line}"))
    }
}
