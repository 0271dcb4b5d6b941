//! `squid report`: page on a stored design.
//!
//! ```text
//! inputs, stored design -> Subject -> sections (figures, tables) -> page, SVG files
//! ```
//!
//! `SECTIONS` in [`report`] is the table of contents; a new section needs one more entry.

pub mod at_sea;
pub mod campaign;
pub mod error;
pub mod page;
pub mod peers;
pub mod record;
pub mod rendered;
pub mod report;
pub mod sections;
pub mod simulate;
pub mod subject;
pub mod threads;
pub mod turning;

#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
