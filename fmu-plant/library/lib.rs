//! The C symbols of the FMU of the plant.

squid_fmi2::export!(squid_fmu_plant::PlantModel);
