//! The files in `resources/` that a plant is made of.

/// The vehicle in `resources/`.
pub const VEHICLE_RESOURCE: &str = "vehicle.json";

/// The LPV model of the vehicle in `resources/`.
pub const LPV_RESOURCE: &str = "plant.json";
