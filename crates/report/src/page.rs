//! How a report is drawn: charts, figures, sections, the page.

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
