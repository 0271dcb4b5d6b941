//! What only the paper's vehicle is asked: its parameter study, its figures of the vehicle alone, its claims.

mod alternation;
pub mod difficulty;
pub mod open_loop;
mod switched;
pub mod switching;
pub mod tuning;

use crate::claims::Claim;
use crate::page::section::{Part, Section, Table};
use crate::page::words::capital;

/// The last section: the claims in one table, then each with its criterion and the numbers.
pub fn claims(claims: Vec<Claim>, subject: &str) -> Section {
    let words = "A. Sutarto, A. Budiyono, 'Development of Linear Parameter Varying Control System for Autonomous \
        Underwater Vehicle', Indian J. Geo-Marine Sci. 40(2), 2011, 275-286, and whether this vehicle confirms it, by \
        a stated criterion and numbers that are in the sections above.";
    let mut table = Table::new(["What the paper claims", &format!("Of {subject}")]);
    table.rows =
        claims.iter().map(|claim| vec![capital(claim.claim), claim.finding.words().into()]).collect();
    let head = [Part::Words(words.into()), Part::Table(table)];
    let parts = head.into_iter().chain(claims.into_iter().map(Part::Claim)).collect();
    Section { id: "claims", title: "The paper's claims", parts }
}
