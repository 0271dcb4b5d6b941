//! Kinds of FMU.

pub use squid_model_description::Interfaces;

/// Kind of an FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Vehicle.
    Plant,
    /// Autopilot.
    Controller,
    /// Closed loop of vehicle and autopilot.
    Squid,
}

impl Kind {
    /// All kinds.
    pub const ALL: [Kind; 3] = [Kind::Plant, Kind::Controller, Kind::Squid];

    /// Returns the kinds that support an interface: a sampled controller has no continuous state to integrate.
    pub fn with(interfaces: Interfaces) -> Vec<Kind> {
        let has = |kind: &Kind| interfaces != Interfaces::ModelExchange || *kind != Kind::Controller;
        Self::ALL.into_iter().filter(has).collect()
    }

    /// Returns the name of the crate of the shared library.
    pub fn library(self) -> &'static str {
        match self {
            Kind::Plant => "squid-fmu-plant-library",
            Kind::Controller => "squid-fmu-controller-library",
            Kind::Squid => "squid-fmu-loop-library",
        }
    }
}
