//! `squid report`: one page about a stored design, and for the paper's vehicle what became of the paper's claims.
//!
//! ```text
//! inputs, stored design -> Subject -> sections (figures, tables, claims) -> page, SVG files
//! ```
//!
//! The paper: A. Sutarto, A. Budiyono, Indian J. Geo-Marine Sci. 40(2), 2011, 275-286. Every claim is judged by a
//! rule in
//! [`claims`]; `SECTIONS` in [`report`] is the table of contents, and a further section is a further line in it.

pub mod at_sea;
pub mod campaign;
pub mod claims;
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
