//! C symbols of the plant FMU.

squid_fmi2::export!(squid_fmu_plant::PlantModel);
