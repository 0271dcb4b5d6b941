//! The C symbols of the FMU of the plant.

fmi2::export!(fmu_plant::PlantModel);
