//! Layout of a report: charts, figures, sections and the page.

pub mod axis;
pub mod chart;
pub mod diagram;
pub mod figure;
pub mod html;
pub mod key;
pub mod plot;
pub mod section;
mod thin;
pub mod words;
