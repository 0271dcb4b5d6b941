//! The C symbols of the FMU of the controller.

fmi2::export!(fmu_controller::Controller);
