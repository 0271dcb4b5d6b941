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

    /// The crate whose shared library it carries.
    pub fn crate_name(self) -> &'static str {
        match self {
            Kind::Plant => "fmu-plant",
            Kind::Controller => "fmu-controller",
            Kind::Squid => "fmu-squid",
        }
    }
}
