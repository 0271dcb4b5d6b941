//! The kinds of FMU.

pub use squid_model_description::Interfaces;

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

    /// Those that have an interface: a sampled controller has no continuous state to integrate.
    pub fn with(interfaces: Interfaces) -> Vec<Kind> {
        let has = |kind: &Kind| interfaces != Interfaces::ModelExchange || *kind != Kind::Controller;
        Self::ALL.into_iter().filter(has).collect()
    }

    /// The crate that is its shared library.
    pub fn library(self) -> &'static str {
        match self {
            Kind::Plant => "squid-fmu-plant-library",
            Kind::Controller => "squid-fmu-controller-library",
            Kind::Squid => "squid-fmu-loop-library",
        }
    }
}
