//! Layout of a report: charts, figures, sections and page.

mod axis;
mod chart;
mod diagram;
mod figure;
pub(crate) mod html;
mod key;
mod plot;
mod section;
mod text;
mod thin;

pub use axis::{Axis, Scale, extent};
pub use chart::{Chart, Curve, SMALL, Size, WIDE};
pub use diagram::Diagram;
pub use figure::{FONT, Figure, STYLE};
pub use key::{Key, WIDTH};
pub use plot::{Kind, Line, Panel, draw};
pub use section::{Boxed, Part, Section, Table};
pub use squid_base::numbers::{known, percent, tidy};
pub use text::{capital, escaped};
pub(crate) use thin::thin;
