//! The kinds of FMU.

/// The kinds of FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The vehicle.
    Plant,
    /// The autopilot.
    Controller,
    /// Both in one loop.
    Squid,
}

impl Kind {
    /// All of them.
    pub const ALL: [Kind; 3] = [Kind::Plant, Kind::Controller, Kind::Squid];

    /// The crate that is its shared library.
    pub fn library(self) -> &'static str {
        match self {
            Kind::Plant => "fmu-plant-library",
            Kind::Controller => "fmu-controller-library",
            Kind::Squid => "fmu-squid-library",
        }
    }
}
