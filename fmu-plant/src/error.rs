//! Errors of the plant, one sentence each.

use squid_auv::{CoefficientError, LpvModelError, SimulationError, TrimError, VehicleJsonError};
use squid_fmi2::ResourceError;
use squid_sea::SeaError;

use crate::resources::LPV_RESOURCE;

/// Errors of the plant.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the message says what each field is")]
pub enum PlantError {
    /// A resource cannot be read.
    #[error(transparent)]
    Resource(#[from] ResourceError),
    /// The vehicle is invalid.
    #[error(transparent)]
    Vehicle(#[from] VehicleJsonError),
    /// The LPV model is invalid, or has a different number of actuators.
    #[error("{}", in_file(.0))]
    Lpv(#[from] LpvModelError),
    /// The LPV model belongs to another vehicle.
    #[error("resources/{LPV_RESOURCE} is the LPV model of '{found}', but the vehicle is '{expected}'")]
    OtherVehicle { found: String, expected: String },
    /// A coefficient is out of range.
    #[error("the vehicle cannot start: {0}")]
    Coefficients(#[from] CoefficientError),
    /// A weight, buoyancy or centre of gravity set in flight is out of range.
    #[error("{0}")]
    Ballast(#[source] CoefficientError),
    /// A coefficient was changed in flight with the LPV model, which cannot follow it.
    #[error(
        "weight, buoyancy, x_G and z_G can be changed during the simulation only if fidelity is nonlinear, because \
         the LPV model contains the coefficients of the vehicle file; external_force_z acts in both"
    )]
    BallastOfLpv,
    /// The initial depth is above the surface.
    #[error("the vehicle cannot start: initial_depth is {depth} m; it must be at least zero (the surface)")]
    AboveSurface { depth: f64 },
    /// A wave parameter is out of range.
    #[error("the vehicle cannot start in these waves (the parameters wave_...): {0}")]
    Waves(#[from] SeaError),
    /// The hull breaks the surface of the waves at the start.
    #[error(
        "the vehicle cannot start: at an initial_depth of {depth} m the hull is {out:.2} m above the wave surface, \
         where linear wave theory does not hold"
    )]
    BreaksSurface { depth: f64, out: f64 },
    /// The initial speed is not above zero, as all trims of the vehicle are.
    #[error(
        "the vehicle cannot start: initial_speed is {speed} m/s; it must be above zero, because the trims are for \
            forward speeds"
    )]
    NotAhead { speed: f64 },
    /// There is no level trim to start from.
    #[error("the vehicle cannot start: {0}")]
    Trim(#[from] TrimError),
    /// The simulation failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The plant's time differs from that of the simulation, which only a manipulated saved state can cause.
    #[error("the plant is at {clock} s, but the time is {time} s")]
    OtherTime { clock: f64, time: f64 },
}

/// Adds the file name, which only the message about bad JSON already contains.
fn in_file(error: &LpvModelError) -> String {
    match error {
        LpvModelError::NotJson { .. } => error.to_string(),
        _ => format!("resources/{LPV_RESOURCE}: {error}"),
    }
}
