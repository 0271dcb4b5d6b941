//! `squid report`: the paper's figures for a vehicle, with the paper's claims and whether this vehicle confirms them.
//!
//! ```text
//! inputs, stored design -> Subject -> sections (figures, tables, verdicts) -> page, SVG files
//! ```
//!
//! The paper: A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, 275-286. Every verdict is computed by a
//! rule in [`verdict`]; `SECTIONS` in [`report`] is the table of contents, and a further section is a further line in
//! it.

pub mod error;
pub mod page;
pub mod peers;
pub mod record;
pub mod rendered;
pub mod report;
mod sections;
pub mod simulate;
pub mod subject;
mod threads;
pub mod verdict;
