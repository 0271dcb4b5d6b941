//! The C symbols of the FMU of the controller.

squid_fmi2::export!(squid_fmu_controller::Controller);
