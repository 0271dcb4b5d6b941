//! Files in `resources/` from which the plant is built.

/// File of the vehicle in `resources/`.
pub const VEHICLE_RESOURCE: &str = "vehicle.json";

/// File of the vehicle's LPV model in `resources/`.
pub const LPV_RESOURCE: &str = "plant.json";
